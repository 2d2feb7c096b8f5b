"""What is combined, where the knee lies, and a real measurement of a small mesh."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from assetpipe.cli.shell import run
from assetpipe.decomposition.tolerance import Tolerance
from assetpipe.errors import UsageError
from assetpipe.pipeline.tradeoff import Row, knee, settings

ROOT = Path(__file__).resolve().parents[3]


def row(error, hulls, effort="balanced", engine="assetpipe"):
    return Row(engine, effort, f"{error}m", 1.0, hulls, 8 * hulls, error, 100, 5.0, None, 0)


def test_other_engines_have_no_efforts_and_one_hull_no_tolerances():
    tolerances = [Tolerance.metres(0.01), Tolerance.metres(0.001)]
    chosen = settings(tolerances, ["fast", "best"], ["assetpipe", "coacd", "hull"])
    assert [s.curve for s in chosen] == [
        *["assetpipe fast"] * 2, *["assetpipe best"] * 2, "coacd", "coacd", "hull",
    ]  # fmt: skip
    with pytest.raises(UsageError):
        settings([], ["fast"], ["assetpipe"])


def test_knee_is_the_corner_of_an_l():
    rows = [row(0.1, 1), row(0.01, 2), row(0.009, 20), row(0.008, 200)]
    assert knee(rows) == 1


def test_beaten_points_are_no_knee():
    rows = [row(0.1, 1), row(0.05, 40), row(0.01, 4), row(0.008, 200)]
    assert knee(rows) == 2


def test_two_points_have_no_knee():
    assert knee([row(0.1, 1), row(0.01, 10)]) is None
    assert knee([row(0.1, 1), row(0.01, 10, "fast"), row(0.02, 5, engine="coacd")]) is None


def test_measures_a_mesh(tmp_path, capsys):
    mesh = ROOT / "sample_assets/arm_gripper/meshes/palm_link.obj"
    code = run(
        ["tradeoff", str(mesh), "-o", str(tmp_path / "t"), "--tolerances", "20%,5%", "--json"]
    )
    assert code == 0
    record = json.loads(capsys.readouterr().out)
    coarse, fine = record["rows"]
    assert coarse["hulls"] <= fine["hulls"]
    diagonal = float(np.linalg.norm([0.05, 0.11, 0.045]))
    assert fine["error"] <= 0.05 * diagonal * (1 + 1e-9)
    assert coarse["error"] <= 0.2 * diagonal
    assert fine["seconds"] > 0
    assert fine["bytes"] > 0
    assert fine["query_us"] > 0
    with (tmp_path / "t/tradeoff.csv").open() as file:
        assert [int(r["hulls"]) for r in csv.DictReader(file)] == [coarse["hulls"], fine["hulls"]]
    page = (tmp_path / "t/tradeoff.html").read_text()
    assert "http" not in page
    assert "5%" in page


def test_unknown_names_are_named(tmp_path, capsys):
    mesh = ROOT / "sample_assets/arm_gripper/meshes/palm_link.obj"
    assert run(["tradeoff", str(mesh), "-o", str(tmp_path), "--efforts", "fsat"]) == 2
    assert "did you mean 'fast'" in capsys.readouterr().err
