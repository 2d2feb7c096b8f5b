"""Robots as they are shipped with PyBullet: read whole, written back to the byte."""

from pathlib import Path

import pytest

from assetpipe.robot import (
    HullMesh,
    MeshShape,
    NewCollision,
    Resolver,
    find_robots,
    forward_kinematics,
    lay_out,
    read_robot,
    write_urdf,
)
from assetpipe.robot.markup import read_markup

pybullet_data = pytest.importorskip(
    "pybullet_data", reason="PyBullet has no wheels for this Python"
)
ROOT = Path(pybullet_data.getDataPath())

ROBOTS = {
    # links, collision elements, mesh collisions that resolve
    "kuka_iiwa/model.urdf": (8, 8, 8),
    "franka_panda/panda.urdf": (13, 11, 11),
    "laikago/laikago.urdf": (13, 13, 13),
    "mini_cheetah/mini_cheetah.urdf": (17, 17, 13),
    "xarm/xarm6_robot.urdf": (8, 7, 7),
    "r2d2.urdf": (16, 16, 4),
}


@pytest.mark.parametrize("name", ROBOTS)
def test_robots_load_whole(name: str) -> None:
    result = read_robot(ROOT / name, resolver=Resolver())
    links, collisions, meshes = ROBOTS[name]
    shapes = [c.shape for link in result.robot.links for c in link.collisions]
    found = [s for s in shapes if isinstance(s, MeshShape) and s.path is not None]
    assert (len(result.robot.links), len(shapes), len(found)) == (links, collisions, meshes)
    assert [f for f in result.findings if f.code in ("AP101", "AP103")] == []
    assert len(forward_kinematics(result.robot)) == links


def _sample() -> list[Path]:
    every = find_robots(ROOT)
    # the thousand random shapes are all alike
    varied = [p for p in every if "random_urdfs" not in p.parts]
    return [*varied, *[p for p in every if "random_urdfs" in p.parts][::97]]


def test_every_urdf_is_read_and_written_back_to_the_byte() -> None:
    sample = _sample()
    assert len(sample) > 90
    for path in sample:
        robot = read_robot(path, resolver=Resolver()).robot
        assert write_urdf(robot, {}) == path.read_bytes(), path
        forward_kinematics(robot)


def test_replacing_every_mesh_changes_collision_elements_only() -> None:
    replaced = 0
    for path in _sample():
        robot = read_robot(path, resolver=Resolver()).robot
        layout = lay_out(robot)
        new = {
            (link.name, c.index): [
                NewCollision(HullMesh(layout.hulls["collision", link.name, c.index].uri(k)))
                for k in range(3)
            ]
            for link in robot.links
            for c in link.collisions
            if isinstance(c.shape, MeshShape) and c.shape.path is not None
        }
        replaced += len(new)
        written = write_urdf(robot, new)
        before, after = (_outside(text, path) for text in (robot.source, written))
        # between copies there is nothing but white space
        assert b"".join(before).split() == b"".join(after).split(), path
        assert len(after) == len(before) + 2 * len(new), path
    assert replaced > 150


def _outside(source: bytes, path: Path) -> list[bytes]:
    markup = read_markup(source, path)
    pieces, position = [], 0
    for link in markup.root.all("link"):
        for collision in link.all("collision"):
            pieces.append(markup.text[position : collision.start])
            position = collision.end
    return [*pieces, markup.text[position:]]


def test_files_that_are_not_well_formed_are_read_and_told() -> None:
    told = {
        path.name: [f.message for f in result.findings if f.code == "AP104"]
        for path in (ROOT / "plane.urdf", ROOT / "humanoid/humanoid.urdf", ROOT / "biped")
        if path.is_file() and (result := read_robot(path, resolver=Resolver()))
    }
    assert "XML version '0.0' does not exist" in told["plane.urdf"][0]
    assert "text after the end of the root element" in told["humanoid.urdf"][0]
