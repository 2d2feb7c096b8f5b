"""Poses of links, against yourdfpy."""

import io
from pathlib import Path

import numpy as np
import pytest
import yourdfpy

from assetpipe.errors import UsageError
from assetpipe.robot import Resolver, Robot, forward_kinematics, home, read_robot

TYPES = ["revolute", "prismatic", "continuous", "fixed"]


def chain(seed: int) -> str:
    rng = np.random.default_rng(seed)
    links = "".join(f'<link name="l{k}"/>' for k in range(9))
    joints = ""
    for k in range(1, 9):
        xyz, rpy, axis = (" ".join(map(repr, map(float, rng.normal(size=3)))) for _ in range(3))
        kind = TYPES[rng.integers(4)]
        mimic = '<mimic joint="j1" multiplier="0.5" offset="0.1"/>' if k == 5 else ""
        if k in (1, 5):
            kind = "continuous"
        joints += (
            f'<joint name="j{k}" type="{kind}"><parent link="l{rng.integers(k)}"/>'
            f'<child link="l{k}"/><origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{axis}"/>'
            f'<limit lower="0.25" upper="1" effort="1" velocity="1"/>{mimic}</joint>'
        )
    return f'<robot name="r">{links}{joints}</robot>'


def robot(tmp_path: Path, text: str) -> Robot:
    path = tmp_path / "r.urdf"
    path.write_text(text)
    return read_robot(path, resolver=Resolver()).robot


@pytest.mark.parametrize("seed", range(6))
def test_agrees_with_yourdfpy(tmp_path: Path, seed: int) -> None:
    text = chain(seed)
    ours = robot(tmp_path, text)
    rng = np.random.default_rng(seed + 100)
    positions = {name: float(rng.uniform(-2, 2)) for name in home(ours)}
    # yourdfpy takes the axis of a prismatic joint as a step, not as a direction
    theirs = yourdfpy.URDF.load(io.BytesIO(text.encode()), load_meshes=False)
    for joint in theirs.robot.joints:
        joint.axis = joint.axis / np.linalg.norm(joint.axis)
    theirs.update_cfg(positions)
    poses = forward_kinematics(ours, positions)
    for link in ours.links:
        np.testing.assert_allclose(
            poses[link.name], theirs.get_transform(link.name, "l0"), atol=1e-12
        )


def test_home_is_zero_clamped_into_the_limits(tmp_path: Path) -> None:
    text = """<robot name="r"><link name="a"/><link name="b"/><link name="c"/><link name="d"/>
    <joint name="up" type="revolute"><parent link="a"/><child link="b"/>
      <limit lower="0.5" upper="1"/></joint>
    <joint name="down" type="prismatic"><parent link="a"/><child link="c"/>
      <limit lower="-2" upper="-1"/></joint>
    <joint name="round" type="continuous"><parent link="a"/><child link="d"/>
      <limit lower="1" upper="2"/></joint></robot>"""
    assert dict(home(robot(tmp_path, text))) == {"up": 0.5, "down": -1.0, "round": 0.0}


def test_mimic_of_a_mimic_and_several_roots(tmp_path: Path) -> None:
    joint = '<joint name="{0}" type="prismatic"><parent link="a"/><child link="{0}"/>{1}</joint>'
    mimic = '<mimic joint="{}" multiplier="2" offset="1"/>'
    text = (
        '<robot name="r"><link name="alone"/><link name="a"/><link name="x"/><link name="y"/>'
        '<link name="z"/>'
        + joint.format("z", mimic.format("y"))
        + joint.format("y", mimic.format("x"))
        + joint.format("x", "")
        + "</robot>"
    )
    poses = forward_kinematics(robot(tmp_path, text), {"x": 3.0})
    assert [poses[n][0, 3] for n in ("alone", "a", "x", "y", "z")] == [0, 0, 3, 7, 15]


@pytest.mark.parametrize(
    ("name", "message"),
    [("none", "joint 'none' not found"), ("j5", "follows 'j1'"), ("fixed", "no number sets it")],
)
def test_joints_that_cannot_be_set(tmp_path: Path, name: str, message: str) -> None:
    fixed = (
        '<link name="e"/><joint name="fixed" type="fixed"><parent link="l0"/><child link="e"/>'
        "</joint></robot>"
    )
    ours = robot(tmp_path, chain(0).replace("</robot>", fixed))
    with pytest.raises(UsageError, match=message):
        forward_kinematics(ours, {name: 1.0})
