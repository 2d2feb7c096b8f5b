"""Worker: how long PyBullet's step takes with a robot. Runs in its own process."""

from __future__ import annotations

import time
from typing import Any

BALLS = 27
"""Balls that fall on the robot, so that its collision shapes have work to do."""


def measure(request: dict[str, Any]) -> dict[str, Any]:
    """Step a robot on a fixed base, self-collision on, under a grid of falling balls.

    Args:
        request: ``urdf`` path and ``steps``.

    Returns:
        ``microseconds``: the median over the steps; ``None`` if the robot does not load.
    """
    import pybullet

    pybullet.connect(pybullet.DIRECT)
    flags = pybullet.URDF_USE_SELF_COLLISION | pybullet.URDF_USE_SELF_COLLISION_EXCLUDE_PARENT
    try:
        body = pybullet.loadURDF(request["urdf"], useFixedBase=True, flags=flags)
    except pybullet.error:
        return {"microseconds": None}
    pybullet.setGravity(0.0, 0.0, -9.81)
    boxes = [pybullet.getAABB(body, link) for link in range(-1, pybullet.getNumJoints(body))]
    low = [min(box[0][axis] for box in boxes) for axis in range(3)]
    high = [max(box[1][axis] for box in boxes) for axis in range(3)]
    radius = max(0.03 * max(h - w for h, w in zip(high, low, strict=True)), 1e-3)
    shape = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=radius)
    for k in range(BALLS):
        place = [k % 3, k // 3 % 3, k // 9]
        at = [low[axis] + (high[axis] - low[axis]) * (place[axis] + 0.5) / 3.0 for axis in range(2)]
        at.append(high[2] + radius * (1.0 + 3.0 * place[2]))
        pybullet.createMultiBody(0.05, shape, basePosition=at)
    times = []
    for _ in range(int(request["steps"])):
        began = time.process_time()
        pybullet.stepSimulation()
        times.append(time.process_time() - began)
    return {"microseconds": sorted(times)[len(times) // 2] * 1e6}
