"""What AP208 advises can be done: openings closed for all links, or for one."""

import json
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
import trimesh

Cli = Callable[..., subprocess.CompletedProcess[str]]

CONFIG = """
links:
  tip: {openings: fill}
validation: {checks: []}
"""


@pytest.fixture
def open_package(package: Path) -> Path:
    """The robot's bracket is a box without its lid."""
    box = trimesh.creation.box((0.2, 0.1, 0.06))
    box.update_faces(box.face_normals[:, 2] < 0.5)
    (mesh,) = package.parent.parent.rglob("bracket.stl")
    mesh.write_bytes(box.export(file_type="stl"))
    return package


def told(path: Path) -> set[str | None]:
    """Links whose openings are ambiguous."""
    findings = json.loads(path.read_text())["findings"]
    return {finding["link"] for finding in findings if finding["code"] == "AP208"}


def test_openings_are_closed_where_the_part_is_said_to_be_solid(
    cli: Cli, open_package: Path
) -> None:
    top = open_package.parents[2]
    (top / "config.yaml").write_text(CONFIG)
    done = cli("build", open_package, "-o", "out", "--config", "config.yaml")
    assert done.returncode == 1, done.stdout + done.stderr
    meshes = json.loads((top / "out" / "report.json").read_text())["robots"][0]["meshes"]
    volume = {link: mesh["volume"] for mesh in meshes for link in mesh["links"]}
    assert told(top / "out" / "report.json") == {"arm"}
    assert volume["tip"] == pytest.approx(0.2 * 0.1 * 0.06)
    assert volume["arm"] < 0.1 * volume["tip"]
    for choice, links in (("auto", {"arm", "tip"}), ("fill", set())):
        cli("inspect", open_package, "--openings", choice, "--json", "told.json")
        assert told(top / "told.json") == links
