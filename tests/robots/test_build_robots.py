"""Real robots, built through the command line and judged from outside.

The judges share no code with what they judge: trimesh and libigl for geometry, the
standard library for XML.
"""

import json
import os
import re
import subprocess
import sys
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path

import igl
import numpy as np
import pytest
import trimesh

pybullet_data = pytest.importorskip("pybullet_data", reason="PyBullet's robots are not installed")

DATA = Path(pybullet_data.__file__).parent
ROOT = Path(__file__).resolve().parents[2]
QUICK = ["r2d2.urdf", "kuka_iiwa/model.urdf", "xarm/xarm6_robot.urdf"]
SLOW = ["franka_panda/panda.urdf", "laikago/laikago.urdf", "mini_cheetah/mini_cheetah.urdf"]
COARSE = {"mini_cheetah/mini_cheetah.urdf": ("--effort", "fast", "--tolerance", "2%")}
"""Robots whose many details would take minutes at the defaults."""

SAMPLES = 300


class Built:
    """A robot built once for all tests of this file."""

    def __init__(self, source: Path, out: Path, *options: str) -> None:
        self.source, self.out = source, out
        done = subprocess.run(
            [sys.executable, "-m", "assetpipe", "build", source, "-o", out, "--no-cache", *options],
            capture_output=True,
            text=True,
            check=False,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            timeout=900,
        )
        self.code, self.said = done.returncode, done.stdout + done.stderr
        self.report = json.loads((out / "report.json").read_text())["robots"][0]
        self.urdf = out / self.report["urdf"]

    def elements(self) -> Iterator[tuple[dict, dict]]:
        """(element, mesh) of every collision element that became hulls."""
        for elements in self.report["links"].values():
            for element in elements:
                if element["treatment"] == "decomposed":
                    yield element, self.report["meshes"][element["mesh"]]


@pytest.fixture(
    scope="module",
    params=[*QUICK, *(pytest.param(name, marks=pytest.mark.slow) for name in SLOW)],
)
def built(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Built:
    out = tmp_path_factory.mktemp("robot") / "out"
    return Built(DATA / request.param, out, *COARSE.get(request.param, ()))


def test_builds_with_findings_at_most(built: Built) -> None:
    assert built.code in (0, 1), built.said
    codes = {finding["code"] for finding in built.report["findings"]}
    assert not codes & {"AP401", "AP404", "AP405", "AP406", "AP407", "AP408", "AP901"}, built.said


def test_no_collision_element_is_lost(built: Built) -> None:
    before, after = (ET.parse(path).getroot() for path in (built.source, built.urdf))
    for link in before.findall("link"):
        name = link.get("name")
        elements = built.report["links"][name]
        assert len(elements) == len(link.findall("collision"))
        assert all(e["treatment"] != "decomposed" or e["files"] for e in elements)
        written = sum(len(e["files"]) or 1 for e in elements)
        other = next(item for item in after.findall("link") if item.get("name") == name)
        assert len(other.findall("collision")) == written


def test_urdf_differs_in_collision_elements_only(built: Built) -> None:
    collision = re.compile(rb"<collision\b.*?</collision>", re.DOTALL)
    texts = [collision.sub(b"", path.read_bytes()) for path in (built.source, built.urdf)]
    assert re.sub(rb"\s+", b"", texts[0]) == re.sub(rb"\s+", b"", texts[1])


def test_engine_sees_every_shape(built: Built) -> None:
    engine = built.report["validation"]["engine"]
    assert engine["outcome"] == "loaded", engine["message"]
    expected = sum(
        len(e["files"]) or 1 for elements in built.report["links"].values() for e in elements
    )
    assert sum(engine["shapes"].values()) == expected


def test_hulls_are_convex_cover_the_solid_and_stay_within_their_certificate(built: Built) -> None:
    seen: set[tuple[str, ...]] = set()
    root = built.source.parent
    for element, mesh in built.elements():
        files = tuple(element["files"])
        if files in seen:
            continue
        seen.add(files)
        hulls = [trimesh.load_mesh(built.out / file, process=False) for file in files]
        planes = []
        for hull in hulls:
            assert hull.is_watertight
            assert hull.volume > 0
            normals = hull.face_normals[hull.area_faces > 0]
            origins = hull.triangles[hull.area_faces > 0][:, 0]
            heights = normals @ hull.vertices.T - np.sum(normals * origins, axis=1)[:, None]
            assert heights.max() <= 1e-9 * max(1.0, hull.scale)
            planes.append((normals, np.sum(normals * origins, axis=1)))
        name = mesh["name"].split("://")[-1]
        found = [p for p in (root / name, root.parent / name) if p.is_file()]
        assert found, mesh["name"]
        # Certificates are towards the repaired solid, whose surface lies this near the file's.
        slack = mesh["repair"]["moved"] + 1e-6 * mesh["diagonal"]
        raw = trimesh.load_mesh(found[0], process=False)
        vertices = np.asarray(raw.vertices) * mesh["scale"]
        faces = np.asarray(raw.faces)
        points = np.vstack(
            [vertices, trimesh.sample.sample_surface(trimesh.Trimesh(vertices, faces), SAMPLES)[0]]
        )
        outside = np.min(
            [(n @ points.T - offset[:, None]).max(axis=0) for n, offset in planes], axis=0
        )
        assert outside.max() <= slack
        bound = mesh["certificate"]["thickening"]["upper"]
        for hull in hulls:
            inside = np.vstack(
                [hull.vertices, trimesh.sample.sample_surface(hull, SAMPLES, seed=1)[0]]
            )
            distance = np.sqrt(igl.point_mesh_squared_distance(inside, vertices, faces)[0])
            distance[igl.fast_winding_number(vertices, faces, inside) > 0.5] = 0.0
            assert distance.max() <= bound + slack
