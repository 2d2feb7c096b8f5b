"""Simple shapes, seams and reach as options of ``build`` and ``validate``."""

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np

from assetpipe.robot import Box, MeshShape, read_robot

Cli = Callable[..., subprocess.CompletedProcess[str]]


def test_a_bracket_becomes_boxes_that_enclose_it_and_stand_up_to_validation(
    cli: Cli, package: Path
) -> None:
    options = ("--shapes", "primitives", "--overlap", "0.5mm", "--reach", "5mm")
    done = cli("build", package, "-o", "out", *options)
    assert done.returncode == 0, done.stdout + done.stderr
    out = package.parents[2] / "out"
    report = json.loads((out / "report.json").read_text())
    (built,) = out.rglob("tiny.urdf")
    after = read_robot(built).robot
    before = read_robot(package).robot
    for name in ("arm", "tip"):
        olds, news = before.link(name).collisions, after.link(name).collisions
        assert len(news) == 2 * len(olds)
        assert all(isinstance(new.shape, Box) for new in news)
        for k, old in enumerate(olds):
            # Corners and middles of edges of the original, in the link's frame, mirrored or not.
            assert isinstance(old.shape, MeshShape)
            corners = bracket_points() * old.shape.scale
            points = corners @ old.link_from_shape[:3, :3].T + old.link_from_shape[:3, 3]
            covered = np.zeros(len(points), bool)
            for new in news[2 * k : 2 * k + 2]:
                local = (points - new.link_from_shape[:3, 3]) @ new.link_from_shape[:3, :3]
                assert isinstance(new.shape, Box)
                covered |= (np.abs(local) <= 0.5 * np.array(new.shape.size)).all(axis=1)
            assert covered.all()
    for mesh in report["robots"][0]["meshes"]:
        assert [shape["kind"] for shape in mesh["primitives"]] == ["box", "box"]
        assert mesh["seams"] == {"overlap": 0.0005, "widened": 1, "open": 0}
        assert mesh["closed"]["pockets"] == 0
        assert mesh["contact"]["holds"]
        assert mesh["certificate"]["thickening"]["upper"] <= mesh["tolerance"]
    checked = cli("validate", package, built, "--json", "told.json")
    assert checked.returncode == 0, checked.stdout + checked.stderr


def bracket_points() -> np.ndarray:
    outline = np.array([[0, 0], [0.2, 0], [0.2, 0.04], [0.04, 0.04], [0.04, 0.2], [0, 0.2]])
    between = 0.5 * (outline + np.roll(outline, -1, axis=0))
    flat = np.vstack([outline, between])
    return np.vstack([np.insert(flat, 2, z, axis=1) for z in (0.0, 0.03, 0.06)])


def test_shapes_are_refused_with_a_metric_that_cannot_prove_them(cli: Cli, package: Path) -> None:
    done = cli("build", package, "-o", "out", "--shapes", "primitives", "--metric", "concavity")
    assert done.returncode == 2
    assert "thickening" in done.stderr
