"""Inner hulls written beside the hulls: ``--inner write``."""

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from assetpipe.geometry.files import read_mesh
from assetpipe.robot import MeshShape, read_robot

Cli = Callable[..., subprocess.CompletedProcess[str]]

QUICK = ("--no-validate", "--inner", "write")


def tree(out: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(out)): path.read_bytes() for path in out.rglob("*") if path.is_file()
    }


def in_bracket(points: np.ndarray, slack: float) -> np.ndarray:
    """Whether points are in the L of the package ``tiny``, as its outline says."""
    x, y, z = points.T
    around = (points >= -slack).all(axis=1) & (x <= 0.2 + slack) & (y <= 0.2 + slack)
    return around & (z <= 0.06 + slack) & ((x <= 0.04 + slack) | (y <= 0.04 + slack))


def inside(points: np.ndarray, vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Whether points are below every face's plane."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    return (points @ normals.T <= np.einsum("ij,ij->i", normals, a)).all(axis=1)


def test_inner_hulls_are_inside_fill_the_part_and_are_told(cli: Cli, package: Path) -> None:
    done = cli("build", package, "-o", "out", *QUICK)
    assert done.returncode == 0, done.stdout + done.stderr
    out = package.parents[2] / "out"
    report = json.loads((out / "report.json").read_text())
    (built,) = out.rglob("tiny.urdf")
    assert b"inner" not in built.read_bytes()
    robot = read_robot(package).robot
    rng = np.random.default_rng(0)
    probes = rng.uniform(0.0, (0.2, 0.2, 0.06), (20_000, 3))
    probes = probes[in_bracket(probes, 0.0)]
    told = report["robots"][0]
    listed = set()
    for link in ("arm", "tip"):
        for element, collision in zip(
            told["links"][link], robot.link(link).collisions, strict=True
        ):
            assert isinstance(collision.shape, MeshShape)
            facts = told["meshes"][element["mesh"]]["inner"]
            assert len(element["inner_files"]) == facts["hulls"] > 1
            covered = np.zeros(len(probes), bool)
            for name in element["inner_files"]:
                assert Path(name).parent.parent.name == "inner_hulls"
                # Scale is baked in as in the hulls: mirrored parts have mirrored inner hulls.
                mesh = read_mesh(out / name).mesh.scaled(1.0 / np.array(collision.shape.scale))
                weights = rng.dirichlet(np.full(len(mesh.vertices), 0.3), 2000)
                assert in_bracket(np.vstack([mesh.vertices, weights @ mesh.vertices]), 1e-12).all()
                covered |= inside(probes, mesh.vertices, mesh.faces)
            assert facts["share"] == pytest.approx(covered.mean(), abs=0.01)
            assert 0.9 < facts["share"] <= 1.0
            listed |= set(element["inner_files"])
    there = {p.relative_to(out).as_posix() for p in out.rglob("*_inner_*")}
    assert there == listed
    assert there <= set(json.loads((out / "assetpipe.json").read_text())["outputs"])


def test_inner_hulls_are_the_same_bytes_anew_and_go_when_not_asked_for(
    cli: Cli, package: Path
) -> None:
    out = package.parents[2] / "out"
    cli("build", package, "-o", "out", *QUICK)
    first = tree(out)
    anew = cli("build", package, "-o", "other", *QUICK, "--no-cache", "--jobs", 1)
    assert anew.returncode == 0, anew.stderr
    assert tree(out.parent / "other") == first
    cached = cli("build", package, "-o", "third", *QUICK, "--jobs", 2)
    assert cached.returncode == 0, cached.stderr
    assert tree(out.parent / "third") == first
    assert cli("build", package, "-o", "out", "--no-validate").returncode == 0
    left = tree(out)
    assert set(first) - set(left) == {name for name in first if "inner_hulls" in name}
    hulls = [name for name in first if "collision_hulls" in name]
    assert [left[name] for name in hulls] == [first[name] for name in hulls]


def test_of_a_bare_mesh_they_lie_in_a_folder_beside_the_hulls(cli: Cli, package: Path) -> None:
    mesh = package.parents[1] / "meshes" / "bracket.stl"
    done = cli("decompose", mesh, "-o", "out", *QUICK, "--json")
    assert done.returncode == 0, done.stderr
    (element,) = json.loads(done.stdout)["robots"][0]["links"]["bracket"]
    out = package.parents[2] / "out"
    there = sorted(p.relative_to(out).as_posix() for p in out.glob("inner_hulls/*.obj"))
    assert there == element["inner_files"]
    assert there[0] == "inner_hulls/bracket_inner_000.obj"
    assert sorted(p.name for p in out.glob("*.obj")) == element["files"]


def test_an_unknown_choice_names_the_known(cli: Cli, package: Path) -> None:
    done = cli("build", package, "-o", "out", "--inner", "yes")
    assert done.returncode == 2
    assert "'none', 'write'" in done.stderr
