"""Where links are for given joint positions."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from assetpipe.errors import UsageError
from assetpipe.geometry.mesh import FloatArray, locked
from assetpipe.robot.model import Joint, Robot


def home(robot: Robot) -> Mapping[str, float]:
    """Positions of the joints that move on their own: zero, clamped into their limits.

    Joints that mimic others are not in it.
    """
    return MappingProxyType(
        {
            joint.name: _clamped(joint)
            for joint in robot.joints
            if joint.movable and joint.mimic is None
        }
    )


def forward_kinematics(
    robot: Robot, positions: Mapping[str, float] | None = None
) -> Mapping[str, FloatArray]:
    """The pose of every link in the world.

    Args:
        robot: roots (links that are no joint's child) stand at the world's origin.
        positions: radians or metres by joint name; joints left out are at :func:`home`.
            Joints that mimic others follow them and can't be set. Floating and planar joints
            stay at their origin.

    Returns:
        (4, 4) ``world_from_link`` by link name, in the order of the robot's links.

    Raises:
        UsageError: a joint that does not exist, does not move or mimics another.
    """
    values = dict(home(robot))
    for name, value in (positions or {}).items():
        joint = robot.joint(name)
        if joint.mimic is not None:
            raise UsageError(f"joint '{name}' follows '{joint.mimic.joint}': set that one")
        if not joint.movable:
            raise UsageError(f"joint '{name}' is {joint.type}: no number sets it")
        values[name] = float(value)
    parent_joint = {joint.child: joint for joint in robot.joints}
    poses: dict[str, FloatArray] = {}
    for link in robot.links:
        chain = []
        name = link.name
        while name not in poses and name in parent_joint:
            chain.append(parent_joint[name])
            name = parent_joint[name].parent
        pose = poses.setdefault(name, locked(np.eye(4)))
        for joint in reversed(chain):
            pose = locked(pose @ joint.parent_from_joint @ _motion(robot, joint, values))
            poses[joint.child] = pose
    return MappingProxyType({link.name: poses[link.name] for link in robot.links})


def _clamped(joint: Joint) -> float:
    if joint.type == "continuous" or joint.limit is None:
        return 0.0
    lower = -np.inf if joint.limit.lower is None else joint.limit.lower
    upper = np.inf if joint.limit.upper is None else joint.limit.upper
    return float(min(max(0.0, lower), upper)) if lower <= upper else 0.0


def _position(robot: Robot, joint: Joint, values: Mapping[str, float]) -> float:
    """A joint's position, through the joints that it mimics."""
    factor, offset = 1.0, 0.0
    # the reader has made sure that this ends
    while joint.mimic is not None:
        offset += factor * joint.mimic.offset
        factor *= joint.mimic.multiplier
        joint = robot.joint(joint.mimic.joint)
    return factor * values.get(joint.name, 0.0) + offset


def _motion(robot: Robot, joint: Joint, values: Mapping[str, float]) -> FloatArray:
    result = np.eye(4)
    if not joint.movable:
        return result
    value = _position(robot, joint, values)
    if joint.type == "prismatic":
        result[:3, 3] = value * joint.axis
        return result
    x, y, z = joint.axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    result[:3, :3] = np.eye(3) + np.sin(value) * cross + (1.0 - np.cos(value)) * cross @ cross
    return result
