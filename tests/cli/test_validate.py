"""``assetpipe validate`` and the Python interface."""

import json
import threading
from collections.abc import Callable
from pathlib import Path
from subprocess import CompletedProcess

import numpy as np
import pytest

import assetpipe
from assetpipe.errors import CancelledError, ConfigError, InputError, UsageError
from assetpipe.geometry.mesh import Mesh
from assetpipe.pipeline.cache import Cache
from assetpipe.pipeline.progress import Progress

Cli = Callable[..., CompletedProcess[str]]
Workshop = tuple[Cli, Path, Path]


def test_built_robot_holds_against_its_original(workshop: Workshop) -> None:
    cli, original, out = workshop
    done = cli("validate", original, out, "--json")
    assert done.returncode == 0, done.stdout + done.stderr
    result = json.loads(done.stdout)
    assert set(result["links"]) == {"arm", "tip"}
    assert all(facts["contact"]["holds"] for facts in result["links"].values())
    assert result["engine"]["outcome"] == "loaded"
    assert result["self_collision"]["new"] == []


def test_hull_that_is_cut_short_is_caught(workshop: Workshop) -> None:
    cli, original, out = workshop
    hull = sorted(out.rglob("*_hull_000.obj"))[0]
    lines = []
    for line in hull.read_text().splitlines():
        kind, *rest = line.split()
        if kind == "v":
            rest = [repr(0.9 * float(x)) for x in rest]
        lines.append(" ".join([kind, *rest]))
    hull.write_text("\n".join(lines) + "\n")
    done = cli("validate", original, out, "--json")
    assert done.returncode == 1
    assert "AP404" in {f["code"] for f in json.loads(done.stdout)["findings"]}


def test_link_that_lost_its_collision_is_caught(workshop: Workshop) -> None:
    cli, original, out = workshop
    urdf = next(out.rglob("tiny.urdf"))
    text = urdf.read_text()
    start = text.index("<collision", text.index('<link name="tip">'))
    end = text.rindex("</collision>", 0, text.index("<joint")) + len("</collision>")
    urdf.write_text(text[:start] + text[end:])
    done = cli("validate", original, out, "--json")
    assert done.returncode == 1
    lost = [f for f in json.loads(done.stdout)["findings"] if f["code"] == "AP404"]
    assert [f["link"] for f in lost] == ["tip"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "nothing to validate"),
        (["only_one.urdf"], "both ORIGINAL and BUILT"),
        (["a.urdf", "b.urdf"], "does not exist"),
        (["--scene", "tower_setles"], "did you mean 'tower_settles'"),
        (["--explain"], "name scenes"),
    ],
)
def test_wrong_usage_is_explained(cli: Cli, arguments: list[str], words: str) -> None:
    done = cli("validate", *arguments)
    assert done.returncode == 2
    assert words in done.stderr


def test_scene_is_answered_and_explained(cli: Cli) -> None:
    done = cli("validate", "--scene", "tower_settles", "--json")
    assert done.returncode == 0, done.stderr
    scene = json.loads(done.stdout)["scenes"][0]
    assert (scene["question"], scene["expected"]) == ("settle", True)
    plan = cli("validate", "--scene", "tower_settles", "--explain")
    assert plan.returncode == 0
    assert "gravity" in plan.stdout


def test_python_build_tells_what_it_made(package: Path, tmp_path: Path) -> None:
    heard: list[Progress] = []
    result = assetpipe.build(
        package,
        tmp_path / "out",
        config=assetpipe.Config(tolerance="2mm", jobs=1),
        on_progress=heard.append,
        cache=Cache(tmp_path / "cache"),
    )
    assert result.exit_code == 0
    assert result.urdf.is_file()
    assert [len(link.hulls) for link in result.links.values()] == [0, 4, 2]
    hull = result.links["arm"].hulls[0]
    assert hull.volume > 0
    assert hull.certificate.upper <= 0.002
    assert (result.out / hull.file).is_file()
    assert set(result.validation) == {"contact", "self_collision", "engine"}
    assert {"read", "decompose", "validate", "write", "done"} <= {event.stage for event in heard}
    assert any("arm" in event.name for event in heard)
    assert json.dumps(result.as_dict())
    again = assetpipe.build(
        package,
        tmp_path / "out",
        config=assetpipe.Config(tolerance="2mm"),
        cache=Cache(tmp_path / "cache"),
    )
    assert again.as_dict() == result.as_dict()
    assert again.changed == ()
    np.testing.assert_array_equal(again.links["arm"].hulls[0].vertices, hull.vertices)
    checked = assetpipe.validate(package, tmp_path / "out")
    assert checked.exit_code == 0


def test_cancel_leaves_nothing(package: Path, tmp_path: Path) -> None:
    token = threading.Event()

    def listener(event: Progress) -> None:
        if event.stage not in ("read", "start"):
            token.set()

    with pytest.raises(CancelledError):
        assetpipe.build(
            package, tmp_path / "out", on_progress=listener, cancel=token, cache=Cache(None)
        )
    assert sorted(p.name for p in tmp_path.iterdir()) == ["tiny"]


def test_errors_are_typed_and_located(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="does not exist"):
        assetpipe.build(tmp_path / "missing.urdf", tmp_path / "out")
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="no robot found"):
        assetpipe.build(tmp_path / "empty", tmp_path / "out")
    broken = tmp_path / "broken.urdf"
    broken.write_text("<robot>\n<link name='a'>\n</robot>")
    with pytest.raises(InputError, match=r"broken\.urdf:3"):
        assetpipe.build(broken, tmp_path / "out")
    with pytest.raises(ConfigError):
        assetpipe.Config(effort="most")
    with pytest.raises(UsageError, match="both"):
        assetpipe.validate(tmp_path / "a.urdf")


def test_import_is_cheap_and_names_are_there() -> None:
    for name in assetpipe.__all__:
        assert getattr(assetpipe, name) is not None
    assert assetpipe.Mesh is Mesh
    with pytest.raises(AttributeError, match="no attribute 'bild'"):
        assetpipe.bild  # noqa: B018
