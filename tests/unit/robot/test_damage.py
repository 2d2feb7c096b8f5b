"""URDFs with random damage: read with findings or refused with a line, and written to the byte."""

import random
from pathlib import Path

from assetpipe.errors import AssetpipeError
from assetpipe.robot import (
    HullMesh,
    NewCollision,
    Resolver,
    Robot,
    forward_kinematics,
    lay_out,
    read_robot,
    write_urdf,
)

WORDS = [b"-1", b"1e999", b"nan", b"", b"<", b">", b'"', b"'", b"/>", b"</link>", b"<!--", b"-->"]
WORDS += [
    b"--",
    b'<link name="a">',
    b"<collision>",
    b"</collision>",
    b"&amp;",
    b"&",
    b"\0",
    b"\xff",
]
WORDS += [b"..", b"/", b"package://", b"<![CDATA[", b"]]>", b'<?xml version="1.0"?>', b",", b" "]

SOURCE = b"""<?xml version="1.0"?>
<!-- a comment -->
<robot name="r">
  <link name="a"><!-- b -->
    <visual><geometry><mesh filename="m.obj" scale="1 1 1"/></geometry></visual>
    <collision name="c"><origin xyz="0 0 1" rpy="0 0 0"/>
      <geometry><mesh filename="package://x/m.obj" scale="1 1 -1"/></geometry></collision>
    <collision><geometry><box size="1 2 3"/></geometry></collision>
  </link>
  <link name="b"/>
  <joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
  <gazebo reference="a"><collision/></gazebo>
</robot>
"""


def damaged(chance: random.Random) -> bytes:
    text = bytearray(SOURCE)
    for _ in range(chance.choice([1, 1, 1, 2, 4])):
        at = chance.randrange(len(text))
        kind = chance.random()
        if kind < 0.2:
            text[at : at + 1] = bytes([chance.randrange(256)])
        elif kind < 0.4:
            del text[at : at + chance.randrange(1, 9)]
        elif kind < 0.85:
            text[at : at + chance.randrange(3)] = chance.choice(WORDS)
        else:
            text[at:at] = text[at : at + chance.randrange(1, 200)]
    return bytes(text)


def outcome(path: Path) -> Robot | AssetpipeError:
    try:
        return read_robot(path, resolver=Resolver()).robot
    except AssetpipeError as error:
        return error


def test_damage_is_survived(tmp_path: Path) -> None:
    path = tmp_path / "r.urdf"
    chance = random.Random(5)
    outcomes = {"read": 0, "refused": 0}
    hulls = [NewCollision(HullMesh(uri)) for uri in ("x", "y")]
    for _ in range(400):
        source = damaged(chance)
        path.write_bytes(source)
        robot = outcome(path)
        if isinstance(robot, AssetpipeError):
            outcomes["refused"] += 1
            assert robot.location is not None
            assert robot.location.line is not None
            continue
        outcomes["read"] += 1
        assert write_urdf(robot, {}) == source
        forward_kinematics(robot)
        lay_out(robot)
        new = {(link.name, c.index): hulls for link in robot.links for c in link.collisions}
        path.write_bytes(write_urdf(robot, new))
        again = read_robot(path, resolver=Resolver()).robot
        assert [len(link.collisions) for link in again.links] == [
            2 * len(link.collisions) for link in robot.links
        ]
        assert [len(link.visuals) for link in again.links] == [
            len(link.visuals) for link in robot.links
        ]
    assert min(outcomes.values()) > 50
