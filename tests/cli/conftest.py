"""Tiny robot packages, made anew for every test."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]

URDF = """<?xml version="1.0"?>
<!-- tiny: a base with a bracket on a hinge -->
<robot name="tiny">
  <link name="base">
    <visual><geometry><mesh filename="package://tiny/meshes/bracket.stl"/></geometry></visual>
    <collision name="plate">
      <origin xyz="0 0 -0.05"/>
      <geometry><box size="0.2 0.2 0.02"/></geometry>
    </collision>
  </link>
  <link   name='arm'>   <!-- odd spacing stays -->
    <collision>
      <origin xyz="0.01 0 0.02" rpy="0 0.1 0"/>
      <geometry><mesh filename="package://tiny/meshes/bracket.stl" scale="1 1 1"/></geometry>
    </collision>
    <collision>
      <geometry><mesh filename="package://tiny/meshes/bracket.stl" scale="1 -1 1"/></geometry>
    </collision>
  </link>
  <link name="tip">
    <collision><geometry><mesh filename="package://tiny/meshes/bracket.stl"/></geometry></collision>
  </link>
  <joint name="hinge" type="revolute">
    <parent link="base"/><child link="arm"/>
    <origin xyz="0 0 0.1"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/>
  </joint>
  <joint name="slide" type="prismatic">
    <parent link="arm"/><child link="tip"/>
    <origin xyz="0.4 0 0"/><axis xyz="1 0 0"/><limit lower="0" upper="0.1" effort="1" velocity="1"/>
  </joint>
  <gazebo reference="arm"><mu1>0.2</mu1></gazebo>
</robot>
"""


def box(low: tuple[float, ...], high: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    corners = np.array(
        [[(low, high)[i][0], (low, high)[j][1], (low, high)[k][2]]
         for k in (0, 1) for j in (0, 1) for i in (0, 1)]
    )  # fmt: skip
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    faces = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
    return corners, faces


def bracket() -> tuple[np.ndarray, np.ndarray]:
    """An L of 0.2 m: an extruded outline of six corners, closed and concave."""
    outline = np.array([[0, 0], [0.2, 0], [0.2, 0.04], [0.04, 0.04], [0.04, 0.2], [0, 0.2]])
    n = len(outline)
    vertices = np.vstack([np.hstack([outline, np.full((n, 1), z)]) for z in (0.0, 0.06)])
    cap = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    faces = [(a, c, b) for a, b, c in cap] + [(a + n, b + n, c + n) for a, b, c in cap]
    for i in range(n):
        j = (i + 1) % n
        faces += [(i, j, j + n), (i, j + n, i + n)]
    return vertices, np.array(faces)


def write_stl(path: Path, vertices: np.ndarray, faces: np.ndarray) -> None:
    lines = ["solid made by a test"]
    for face in faces:
        lines.append("facet normal 0 0 0\nouter loop")
        lines += ["vertex {!r} {!r} {!r}".format(*map(float, vertices[v])) for v in face]
        lines.append("endloop\nendfacet")
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join([*lines, "endsolid made by a test", ""]))


def write_package(folder: Path, urdf: str = URDF) -> Path:
    """A package ``tiny``; returns its URDF."""
    folder.mkdir(parents=True)
    (folder / "package.xml").write_text(
        '<package format="3"><name>tiny</name><version>0.0.1</version></package>\n'
    )
    write_stl(folder / "meshes/bracket.stl", *bracket())
    (folder / "urdf").mkdir()
    path = folder / "urdf/tiny.urdf"
    path.write_text(urdf)
    return path


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """The URDF of a sound package."""
    return write_package(tmp_path / "tiny")


Cli = Callable[..., subprocess.CompletedProcess[str]]


def run_in(folder: Path, cache: Path) -> Cli:
    def run(*arguments: object, **changes: str) -> subprocess.CompletedProcess[str]:
        environment = {
            **os.environ, "PYTHONPATH": str(ROOT), "XDG_CACHE_HOME": str(cache), **changes
        }  # fmt: skip
        return subprocess.run(
            [sys.executable, "-m", "assetpipe", *map(str, arguments)],
            capture_output=True,
            text=True,
            check=False,
            env=environment,
            cwd=folder,
            timeout=300,
        )

    return run


@pytest.fixture
def cli(tmp_path: Path) -> Cli:
    """Runs the command line in a process of its own, with a cache of its own."""
    return run_in(tmp_path, tmp_path / "cache")


@pytest.fixture(scope="session")
def once(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a package ``tiny``, built into ``out`` with ``cache``; not to be changed."""
    folder = tmp_path_factory.mktemp("once")
    urdf = write_package(folder / "tiny")
    done = run_in(folder, folder / "cache")("build", urdf, "-o", "out")
    assert done.returncode == 0, done.stderr + done.stdout
    return folder


@pytest.fixture
def workshop(once: Path, tmp_path: Path) -> tuple[Cli, Path, Path]:
    """The same to be changed: a command line with a filled cache, the URDF, and OUT."""
    for name in ("tiny", "out", "cache"):
        shutil.copytree(once / name, tmp_path / name)
    return run_in(tmp_path, tmp_path / "cache"), tmp_path / "tiny/urdf/tiny.urdf", tmp_path / "out"
