from pathlib import Path

import pytest

from assetpipe.decomposition.tolerance import Tolerance
from assetpipe.errors import ConfigError
from assetpipe.pipeline.config import Config, load_config
from assetpipe.shipped import CONFIGS


def written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "c.yaml"
    path.write_text(text)
    return path


def refused(tmp_path: Path, text: str) -> str:
    with pytest.raises(ConfigError) as error:
        load_config(written(tmp_path, text))
    return str(error.value)


@pytest.mark.parametrize("name", ["default", "planning", "simulation"])
def test_shipped_configurations_load_by_name(name: str) -> None:
    assert isinstance(load_config(name), Config)


def test_default_yaml_says_what_the_code_does() -> None:
    assert load_config("default") == Config()


def test_every_field_is_in_default_yaml() -> None:
    text = (CONFIGS / "default.yaml").read_text()
    for name in set(Config.model_fields) - {"jobs", "links"}:
        assert f"{name}:" in text


def test_unknown_key_names_line_neighbour_and_all_keys(tmp_path: Path) -> None:
    said = refused(tmp_path, "seed: 1\ntolerence: 1mm\n")
    assert "c.yaml:2:" in said
    assert "did you mean 'tolerance'?" in said
    for key in Config.model_fields:
        assert key in said


def test_unknown_nested_key_names_its_siblings(tmp_path: Path) -> None:
    said = refused(tmp_path, "repair:\n  mode: auto\n  budgt: 1%\n")
    assert "c.yaml:3:" in said
    assert "'repair.budgt'" in said
    assert "repair.budget, repair.mode" in said


def test_wrong_value_names_the_allowed_ones(tmp_path: Path) -> None:
    said = refused(tmp_path, "effort: bst\n")
    assert said.endswith(
        "c.yaml:1: effort: 'bst' is not allowed; allowed: 'fast', 'balanced' or 'best'"
    )


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("seed: 1\nseed: 2\n", 2, "comes twice (first on line 1)"),
        ("seed: 1\na: [1\n", 3, "not YAML"),
        ("- 1\n", 1, "keys and values"),
        ("max_hulls: 0\n", 1, "max_hulls"),
        ("tolerance: 2 furlongs\n", 1, "2mm"),
        ("tolerance: true\n", 1, "2mm or 1%"),
        ("links:\n  hand:\n    tolerance: no\n", 3, "links.hand.tolerance"),
        ("limits:\n  memory: 3XiB\n", 2, "GiB"),
        ("validation:\n  checks: [contact, wind]\n", 2, "'contact', 'self_collision' or 'engine'"),
        ("reach: -1mm\n", 1, "reach"),
        ("seed: .nan\n", 1, "seed"),
    ],
)
def test_faults_are_located(tmp_path: Path, text: str, line: int, words: str) -> None:
    said = refused(tmp_path, text)
    assert words in said
    assert f"c.yaml:{line}:" in said


def test_alias_bomb_is_refused_quickly(tmp_path: Path) -> None:
    lines = ["a0: &a0 [x,x,x,x,x,x,x,x,x]"]
    lines += [f"a{i}: &a{i} [" + ",".join([f"*a{i - 1}"] * 9) + "]" for i in range(1, 12)]
    assert "repeats itself" in refused(tmp_path, "\n".join(lines))


def test_python_values_get_the_same_explanation() -> None:
    with pytest.raises(ConfigError, match="allowed: 'fast', 'balanced' or 'best'"):
        Config(effort="quick")  # type: ignore[arg-type]
    with pytest.raises(ConfigError, match=r"repair\.mode: 'x' is not allowed"):
        Config(repair={"mode": "x"})  # type: ignore[arg-type]


def test_missing_file_and_unknown_name_tell_the_shipped_ones() -> None:
    with pytest.raises(ConfigError, match="did you mean 'planning'"):
        load_config("planing")
    with pytest.raises(ConfigError, match="does not exist; shipped: default, planning"):
        load_config("nowhere/else.yaml")


@pytest.mark.parametrize("text", ["2mm", "0.1%", "1%", "0.333333333333333mm", "coacd 0.05"])
def test_tolerance_survives_its_written_form(text: str) -> None:
    config = Config(tolerance=text)  # type: ignore[arg-type]
    assert Config(**config.as_dict()).tolerance == config.tolerance


def test_config_is_frozen_and_changes_by_copy() -> None:
    config = Config()
    with pytest.raises(Exception, match="frozen"):
        config.seed = 1  # type: ignore[misc]
    assert config.with_changes(seed=1).seed == 1
    assert config.with_changes(seed=1).tolerance == Tolerance.relative(0.01)


def test_jobs_do_not_decide_the_output() -> None:
    assert Config(jobs=1).as_dict() == Config(jobs=7).as_dict()


@pytest.mark.parametrize(
    "text",
    [
        "[" * 100_000,
        "seed: 2020-13-45",
        "seed: " + "9" * 5000,
        "seed: !!int x",
        "seed: !!bool x",
        "seed: !!timestamp x",
    ],
)
def test_values_that_yaml_itself_fails_on_are_told_with_the_file(tmp_path: Path, text: str) -> None:
    assert "c.yaml: " in refused(tmp_path, text)
