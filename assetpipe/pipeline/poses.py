"""Joint configurations: home, and seeded ones within the joints' limits."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from assetpipe.robot import Joint, Robot, home


def configurations(robot: Robot, *, count: int, seed: int) -> Iterator[Mapping[str, float]]:
    """Home, then ``count`` uniform draws; joints that mimic follow by themselves.

    Args:
        robot: whose joints.
        count: draws besides home.
        seed: equal seeds, equal draws.
    """
    ranges = {
        joint.name: interval(joint)
        for joint in robot.joints
        if joint.movable and joint.mimic is None
    }
    yield home(robot)
    rng = np.random.default_rng(seed)
    for _ in range(count):
        yield {
            name: lower + (upper - lower) * float(rng.random())
            for name, (lower, upper) in ranges.items()
        }


def interval(joint: Joint) -> tuple[float, float]:
    """Where a movable joint may be, radians or metres.

    A continuous joint turns once around; what URDF leaves out is zero; limits that are
    no interval leave the joint where it is.
    """
    if joint.type == "continuous":
        return -math.pi, math.pi
    lower = (joint.limit.lower if joint.limit else None) or 0.0
    upper = (joint.limit.upper if joint.limit else None) or 0.0
    if not (math.isfinite(lower) and math.isfinite(upper)) or lower > upper:
        return 0.0, 0.0
    return lower, upper
