"""Reading: every element is there, and what is wrong is told with its line."""

from pathlib import Path
from time import process_time

import numpy as np
import pytest
import trimesh.transformations as tra

from assetpipe.errors import InputError
from assetpipe.findings import Severity
from assetpipe.robot import (
    Box,
    Capsule,
    Cylinder,
    MeshShape,
    OtherShape,
    ReadRobot,
    Resolver,
    Sphere,
    finding_of,
    read_robot,
)

URDF = """<robot name="r">
<link name="base">
  <collision name="first"><origin xyz="1 2 3" rpy="0.1 0.2 0.3"/>
    <geometry><!-- c --><mesh filename="m.stl" scale="1 -2 0.5"/></geometry></collision>
  <collision><geometry><box size="1 2 3"/></geometry></collision>
  <collision><geometry><cylinder radius="0.5" length="2"/></geometry></collision>
  <collision><geometry><sphere radius="0.5"/></geometry></collision>
  <collision><geometry><capsule radius="0.25" length="1"/></geometry></collision>
  <visual><geometry><mesh filename="m.stl" scale="0.001"/></geometry></visual>
</link>
<link name="arm"/><link name="tip"/><link name="finger"/>
<joint name="turn" type="revolute"><parent link="base"/><child link="arm"/>
  <origin xyz="0 0 1"/><axis xyz="0 0 2"/>
  <limit lower="-1" upper="1" effort="5" velocity="3"/></joint>
<joint name="slide" type="prismatic"><parent link="arm"/><child link="tip"/>
  <limit upper="0.1" effort="1" velocity="1"/></joint>
<joint name="follow" type="continuous"><parent link="arm"/><child link="finger"/>
  <mimic joint="turn" multiplier="-2" offset="0.5"/></joint>
</robot>"""


def read(tmp_path: Path, text: str, files: tuple[str, ...] = ("m.stl",)) -> ReadRobot:
    for name in files:
        (tmp_path / name).write_text("x")
    path = tmp_path / "r.urdf"
    path.write_text(text)
    return read_robot(path, resolver=Resolver())


def test_every_collision_one_by_one(tmp_path: Path) -> None:
    result = read(tmp_path, URDF)
    assert result.findings == ()
    base = result.robot.link("base")
    assert [c.index for c in base.collisions] == [0, 1, 2, 3, 4]
    assert [c.line for c in base.collisions] == [3, 5, 6, 7, 8]
    assert [c.shape for c in base.collisions] == [
        MeshShape("m.stl", tmp_path / "m.stl", (1.0, -2.0, 0.5)),
        Box((1.0, 2.0, 3.0)),
        Cylinder(0.5, 2.0),
        Sphere(0.5),
        Capsule(0.25, 1.0),
    ]
    first = base.collisions[0]
    assert first.name == "first"
    expected = tra.euler_matrix(0.1, 0.2, 0.3, axes="sxyz")
    expected[:3, 3] = [1, 2, 3]
    np.testing.assert_allclose(first.link_from_shape, expected, atol=1e-15)
    with pytest.raises(ValueError, match="read-only"):
        first.link_from_shape[0, 0] = 2.0
    assert base.visuals[0].shape == MeshShape("m.stl", tmp_path / "m.stl", (0.001, 0.001, 0.001))


def test_joints(tmp_path: Path) -> None:
    robot = read(tmp_path, URDF).robot
    turn = robot.joint("turn")
    assert turn.axis.tolist() == [0, 0, 1]
    assert turn.limit is not None
    assert (turn.limit.lower, turn.limit.upper, turn.limit.effort) == (-1.0, 1.0, 5.0)
    slide = robot.joint("slide")
    assert slide.axis.tolist() == [1, 0, 0]
    assert slide.limit is not None
    assert slide.limit.lower is None
    follow = robot.joint("follow").mimic
    assert follow is not None
    assert (follow.joint, follow.multiplier, follow.offset) == ("turn", -2.0, 0.5)


LINK = '<robot name="r">\n<link name="a">{}</link></robot>'
SHAPE = "<collision>{}<geometry>{}</geometry></collision>"


@pytest.mark.parametrize(
    ("inside", "message"),
    [
        (SHAPE.format("", '<sphere radius="x"/>'), "could not convert string to float: 'x'"),
        (SHAPE.format("", "<sphere/>"), "attribute 'radius' is missing"),
        (SHAPE.format("", '<sphere radius="nan"/>'), "not finite"),
        (SHAPE.format("", '<sphere radius="1e999"/>'), "not finite"),
        (SHAPE.format("", '<box size="1 2"/>'), "2 lengths instead of 3"),
        (SHAPE.format("", '<box size="1 -2 3"/>'), "negative size"),
        (SHAPE.format("", '<mesh filename="m.stl" scale="1 0 1"/>'), "scale of zero"),
        (SHAPE.format("", '<mesh filename="m.stl" scale="1 2"/>'), "scale of 2 numbers"),
        (SHAPE.format("", "<mesh/>"), "names no mesh file"),
        (SHAPE.format("", '<plane normal="0 0 1"/>'), "unknown shape <plane>"),
        (SHAPE.format("", ""), "no shape"),
        (SHAPE.format('<origin xyz="0 0"/>', '<sphere radius="1"/>'), "cannot be read"),
        ("<collision/>", "has no <geometry>"),
    ],
)
def test_unusable_collisions_are_told_and_counted(
    tmp_path: Path, inside: str, message: str
) -> None:
    good = SHAPE.format("", '<sphere radius="1"/>')
    result = read(tmp_path, LINK.format(inside + good))
    collisions = result.robot.link("a").collisions
    assert [c.index for c in collisions] == [0, 1]
    assert isinstance(collisions[0].shape, OtherShape)
    assert collisions[1].shape == Sphere(1.0)
    (finding,) = result.findings
    assert finding.code == "AP105"
    assert finding.severity is Severity.ERROR
    assert finding.link == "a"
    assert finding.location is not None
    assert finding.location.line == 2
    assert message in finding.message


@pytest.mark.parametrize(
    ("inside", "message", "shape"),
    [
        (SHAPE.format("", '<box size="1, 2, 3"/>'), "commas", Box((1.0, 2.0, 3.0))),
        (SHAPE.format('<origin xyz="1,2,3"/>', '<sphere radius="1"/>'), "commas", Sphere(1.0)),
        (
            SHAPE.format("", '<mesh filename="m.stl" scale="1 1 1 1"/>'),
            "the first 3 count",
            MeshShape("m.stl", None, (1.0, 1.0, 1.0)),
        ),
        (SHAPE.format("", '<sphere radius="1"/><box size="1 1 1"/>'), "first one", Sphere(1.0)),
    ],
)
def test_oddities_are_read_and_told(
    tmp_path: Path, inside: str, message: str, shape: object
) -> None:
    result = read(tmp_path, LINK.format(inside))
    found = result.robot.link("a").collisions[0].shape
    if isinstance(shape, MeshShape):
        shape = MeshShape(shape.uri, tmp_path / "m.stl", shape.scale)
    assert found == shape
    assert [f.severity for f in result.findings] == [Severity.WARNING]
    assert message in result.findings[0].message


def test_unresolved_meshes_are_told_with_neighbours_and_the_rest_is_read(tmp_path: Path) -> None:
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "Arm.stl").write_text("x")
    mesh = SHAPE.format("", '<mesh filename="{}"/>')
    text = LINK.format(mesh.format("meshes/arm.stl") + "\n" + mesh.format("m.stl"))
    result = read(tmp_path, text)
    (finding,) = result.findings
    assert (finding.code, finding.severity) == ("AP101", Severity.ERROR)
    assert finding.location is not None
    assert (finding.location.line, finding.link, finding.mesh) == (2, "a", "meshes/arm.stl")
    assert finding.hint == "there is 'meshes/Arm.stl': only the case differs"
    shapes = [c.shape for c in result.robot.link("a").collisions]
    assert [s.path for s in shapes if isinstance(s, MeshShape)] == [None, tmp_path / "m.stl"]


@pytest.mark.parametrize(
    ("joint", "message"),
    [
        ('type="fixed"><parent link="a"/><child link="none"/>', "child 'none', which is no link"),
        ('type="fixed"><parent link="a"/>', "an element that it needs is missing"),
        ('type="ball"><parent link="a"/><child link="b"/>', "type 'ball', none of revolute"),
        ('><parent link="a"/><child link="b"/>', "type 'None'"),
        (
            'type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 0 0"/>',
            "axis of length zero",
        ),
        (
            'type="fixed"><parent link="a"/><child link="b"/><origin xyz="0 0 nan"/>',
            "not finite",
        ),
        ('type="fixed"><parent link="b"/><child link="b"/>', "closes a loop"),
    ],
)
def test_unusable_joints(tmp_path: Path, joint: str, message: str) -> None:
    text = (
        f'<robot name="r"><link name="a"/><link name="b"/>\n<joint name="j" {joint}</joint></robot>'
    )
    result = read(tmp_path, text)
    assert result.robot.joints == ()
    told = [f for f in result.findings if f.code == "AP105"]
    assert len(told) == 1
    assert message in told[0].message
    assert told[0].location is not None
    assert told[0].location.line == 2


def joint(name: str, parent: str, child: str, more: str = "") -> str:
    return (
        f'<joint name="{name}" type="continuous"><parent link="{parent}"/>'
        f'<child link="{child}"/>{more}</joint>'
    )


def test_loops_second_parents_and_doubles_leave_a_tree(tmp_path: Path) -> None:
    links = "".join(f'<link name="{n}"/>' for n in "abc")
    joints = (
        joint("1", "a", "b") + joint("2", "b", "c") + joint("3", "c", "a") + joint("4", "a", "c")
    )
    result = read(tmp_path, f'<robot name="r">{links}<link name="a"/>{joints}</robot>')
    assert [j.name for j in result.robot.joints] == ["1", "2"]
    codes = [f.code for f in result.findings if f.severity is Severity.ERROR]
    assert sorted(codes) == ["AP105", "AP105", "AP109"]


@pytest.mark.parametrize(
    ("mimics", "free"),
    [
        ({"1": "2", "2": "1"}, {"1", "2"}),
        ({"1": "1"}, {"1", "2"}),
        ({"1": "none"}, {"1", "2"}),
        ({"1": "2"}, {"2"}),
    ],
)
def test_mimics_that_lead_nowhere_count_as_free(
    tmp_path: Path, mimics: dict[str, str], free: set[str]
) -> None:
    links = "".join(f'<link name="{n}"/>' for n in "abc")
    more = {n: f'<mimic joint="{m}"/>' for n, m in mimics.items()}
    text = joint("1", "a", "b", more.get("1", "")) + joint("2", "b", "c", more.get("2", ""))
    result = read(tmp_path, f'<robot name="r">{links}{text}</robot>')
    found = {j.name for j in result.robot.joints if j.mimic is None}
    assert found == free
    assert len([f for f in result.findings if f.code == "AP105"]) == (
        len(mimics) - len({"1", "2"} - free)
    )


def test_a_ring_of_a_thousand_mimics_is_told_soon(tmp_path: Path) -> None:
    number = 1000
    links = "".join(f'<link name="{k}"/>' for k in range(number + 1))
    joints = "".join(
        joint(f"j{k}", str(k), str(k + 1), f'<mimic joint="j{(k + 1) % number}"/>')
        for k in range(number)
    )
    clock = process_time()
    result = read(tmp_path, f'<robot name="r">{links}{joints}</robot>')
    assert process_time() - clock < 5.0
    assert all(j.mimic is None for j in result.robot.joints)
    assert len([f for f in result.findings if "mimics itself" in f.message]) == number


def test_not_well_formed_is_an_error_or_a_finding(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="not well-formed") as caught:
        read(tmp_path, '<robot name="r">\n<link name="a"></robot>')
    assert caught.value.location is not None
    assert caught.value.location.line == 2
    assert finding_of(caught.value).code == "AP104"
    result = read(tmp_path, '<?xml version="0.0" ?>\n' + URDF)
    assert [(f.code, f.severity) for f in result.findings] == [("AP104", Severity.WARNING)]


@pytest.mark.parametrize(
    ("text", "message"),
    [("<sdf/>", "root element is <sdf>, not <robot>"), ("", "no element found")],
)
def test_no_robot_at_all(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read(tmp_path, text)


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        read_robot(tmp_path / "none.urdf")


def test_a_robot_without_collisions_is_told(tmp_path: Path) -> None:
    result = read(tmp_path, '<robot name="r"><link name="a"/></robot>')
    assert [f.code for f in result.findings] == ["AP107"]


def test_references_hold_everything_that_the_description_names(tmp_path: Path) -> None:
    text = """<robot name="r"><link name="a">
      <visual><geometry><mesh filename="m.stl"/></geometry>
        <material name="x"><texture filename="t.png"/></material></visual>
      <collision><geometry><plane/><mesh filename="c.stl"/></geometry></collision></link>
      <gazebo><plugin><mesh><uri>model://none/p.dae</uri></mesh></plugin></gazebo>
      <sensor><mesh filename="s.stl"/></sensor></robot>"""
    result = read(tmp_path, text, files=("m.stl", "t.png", "c.stl", "s.stl"))
    found = [(r.role, r.uri, r.resolution.state) for r in result.robot.references]
    assert found == [
        ("collision", "c.stl", "found"),
        ("visual", "m.stl", "found"),
        ("texture", "t.png", "found"),
        ("other", "model://none/p.dae", "missing"),
        ("other", "s.stl", "found"),
    ]
    severities = {f.mesh: f.severity for f in result.findings if f.code == "AP101"}
    assert severities == {"model://none/p.dae": Severity.NOTE}


def test_names_are_spelled_out_on_mistakes(tmp_path: Path) -> None:
    robot = read(tmp_path, URDF).robot
    with pytest.raises(Exception, match="link 'bas' not found; did you mean 'base'"):
        robot.link("bas")
    with pytest.raises(Exception, match="joint 'turns' not found; did you mean 'turn'"):
        robot.joint("turns")
