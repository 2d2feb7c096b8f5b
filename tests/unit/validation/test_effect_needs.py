"""For every effect a scene made to need it: without it the answer is another one."""

import pytest

from assetpipe.validation.dynamics import available_engines
from assetpipe.validation.effects import EFFECTS, plan
from assetpipe.validation.runners import SceneOptions, answer_scene
from assetpipe.validation.scenes import build_assets, parse_scene

pytestmark = pytest.mark.skipif(
    "bullet" not in available_engines(), reason="PyBullet has no wheel for this Python"
)

GROUND = {"body": "box", "size": [1, 1, 0.02], "pose": {"xyz": [0, 0, -0.01]}}


def link(name, boxes=(), mass=1.0, centre="0 0 0"):
    shapes = "".join(
        f'<collision><origin xyz="{at}"/><geometry><box size="{size}"/></geometry></collision>'
        for at, size in boxes
    )
    return (
        f'<link name="{name}"><inertial><origin xyz="{centre}"/><mass value="{mass}"/>'
        '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>'
        f"{shapes}</link>"
    )


def joint(name, kind, parent, child, axis, limit, *, xyz="0 0 0", damping=0):
    low, high = limit
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{xyz}"/><axis xyz="{axis}"/>'
        f'<limit lower="{low}" upper="{high}" effort="100" velocity="10"/>'
        f'<dynamics damping="{damping}"/></joint>'
    )


def slider(limit, damping=0):
    return (
        link("base", [("0 0 0.2", "0.1 0.1 0.1")])
        + link("carriage", [("0.2 0 0", "0.1 0.1 0.1")])
        + joint("down", "prismatic", "base", "carriage", "0 0 1", limit, damping=damping)
    )


PENDULUM = (
    link("base", [("0 0 -0.3", "0.1 0.1 0.1")])
    + link("bar", [("0.2 0 0", "0.3 0.04 0.04")], centre="0.2 0 0")
    + joint("turn", "revolute", "base", "bar", "0 1 0", (-1.5, 1.5))
)

TWO_CARRIAGES = (
    link("base", [("0.2 0 -0.4", "0.3 0.3 0.02")])
    + link("upper", [("0 0 0", "0.05 0.05 0.05")])
    + link("lower", [("0.2 0 0", "0.1 0.1 0.1")])
    + joint("first", "prismatic", "base", "upper", "0 0 1", (-2, 2))
    + joint("second", "prismatic", "upper", "lower", "0 0 1", (-2, 2))
)


def opening(robot, limit, **more):
    drive = {"gravity": 9.81, **more.pop("drive", {})}
    asset = {"urdf": "robot.urdf", "moving": more.pop("moving")}
    return robot, {
        "question": "open",
        "subject": "robot/" + more.pop("joint"),
        "limit": limit,
        "assets": {"robot": asset},
        "drive": drive,
        **more,
    }


def settling(assets, limit, seconds=1.0, **more):
    drive = {"gravity": 9.81, **more}
    scene = {"question": "settle", "limit": limit, "assets": assets, "drive": drive}
    return None, {**scene, "seconds": seconds}


def tilted(body, angle, **material):
    plane = {"body": "box", "size": [2, 1, 0.02], "pose": {"rpy": [0, angle, 0]}}
    return {
        "plane": {**plane, "material": material},
        "body": {**body, "mass": 0.2, "base": "free", "material": material},
    }


BLOCK = {"body": "box", "size": [0.1, 0.1, 0.04]}

NEEDS = {
    "gravity": settling(
        {
            "ground": GROUND,
            "box": {**BLOCK, "mass": 1, "base": "free", "pose": {"xyz": [0, 0, 0.12]}},
        },
        0.01,
    ),
    # tan 15° = 0.27 is below the coefficient
    "friction": settling(
        tilted(
            {**BLOCK, "pose": {"xyz": [0.0078, 0, 0.029], "rpy": [0, 0.2618, 0]}},
            0.2618,
            friction=0.6,
        ),
        0.005,
    ),
    "rolling_friction": settling(
        tilted(
            {"body": "sphere", "radius": 0.05, "pose": {"xyz": [0.0063, 0, 0.0602]}},
            0.105,
            friction=1.0,
            rolling_friction=0.05,
        ),
        0.05,
    ),
    "spinning_friction": settling(
        {
            "ground": {**GROUND, "material": {"friction": 0.2, "spinning_friction": 0.2}},
            "box": {
                "body": "box",
                "size": [0.3, 0.06, 0.04],
                "mass": 1,
                "base": "free",
                "pose": {"xyz": [0, 0, 0.02]},
                "material": {"friction": 0.2, "spinning_friction": 0.2},
            },
            "pusher": {
                "body": "box",
                "size": [0.02, 0.02, 0.02],
                "base": "driven",
                "pose": {"xyz": [0.13, -0.06, 0.02]},
            },
        },
        0.12,
        path={"asset": "pusher", "force": 4, "waypoints": [{"xyz": [0, 0.1, 0], "at": 0.5}]},
    ),
    # at 0.4 s it is at the top of its first rebound
    "restitution": settling(
        {
            "ground": {**GROUND, "material": {"restitution": 0.9}},
            "ball": {
                "body": "sphere",
                "radius": 0.03,
                "mass": 0.1,
                "base": "free",
                "pose": {"xyz": [0, 0, 0.23]},
                "material": {"restitution": 0.9},
            },
        },
        0.1,
        seconds=0.4,
    ),
    "joint_limits": opening(slider((-0.1, 0.0)), 0.2, joint="down", moving=["down"], seconds=0.5),
    "motors": opening(
        PENDULUM,
        0.2,
        joint="turn",
        moving=["turn"],
        seconds=0.5,
        drive={"motors": {"robot": {"targets": {"turn": 0.0}}}},
    ),
    "self_collision": opening(
        TWO_CARRIAGES,
        0.5,
        joint="second",
        moving=["first", "second"],
        seconds=0.6,
        drive={"motors": {"robot": {"targets": {"first": 0.0}}}},
    ),
    "continuous_collision": settling(
        {
            "plate": {"body": "box", "size": [1, 1, 0.002], "pose": {"xyz": [0, 0, 0]}},
            "ball": {
                "body": "sphere",
                "radius": 0.01,
                "mass": 0.05,
                "base": "free",
                "pose": {"xyz": [0, 0, 3.011]},
            },
        },
        3.2,
        seconds=1.2,
    ),
    "damping": opening(slider((-9, 9), 50), 1.0, joint="down", moving=["down"], seconds=1.0),
    "contact_margin": settling(
        {
            "ground": GROUND,
            **{
                f"block{i}": {
                    "body": "box",
                    "size": [0.08 - 0.01 * i, 0.08 - 0.01 * i, 0.04],
                    "mass": 0.4 - 0.1 * i,
                    "base": "free",
                    "pose": {"xyz": [0.002 * (i % 2), 0, 0.02 + 0.04 * i]},
                }
                for i in range(4)
            },
        },
        0.002,
        seconds=2.0,
    ),
}


def answers(effect, folder):
    robot, values = NEEDS[effect]
    scene_file = None
    if robot is not None:
        (folder / "robot.urdf").write_text(f'<robot name="r">{robot}</robot>', encoding="utf-8")
        scene_file = folder / "scene.yaml"
    scene = parse_scene({"title": effect, **values})
    assets = build_assets(scene, scene_file)
    kept = answer_scene(scene, assets)
    without = answer_scene(scene, assets, options=SceneOptions(effects={effect: "off"}))
    return scene, assets, kept, without


def test_every_effect_has_its_scene():
    assert set(NEEDS) == set(EFFECTS)


@pytest.mark.parametrize("effect", EFFECTS)
def test_the_planner_keeps_it_and_without_it_the_answer_changes(effect, tmp_path):
    scene, assets, kept, without = answers(effect, tmp_path)
    assert plan(scene, assets).effect(effect).is_on
    assert kept.message == without.message == ""
    assert without.plan.effect(effect).overruled
    assert kept.answer is not without.answer, (
        f"{kept.measured.measure} with, {without.measured.measure} without"
    )
