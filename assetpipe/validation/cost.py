"""What a collision geometry costs where it is used: in a query, and in a physics step.

CPU times, which depend on the machine and a little on what else it does: medians of several
rounds, to be compared with each other and only within one run.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from assetpipe.geometry.mesh import FloatArray, Mesh
from assetpipe.validation.contact.surface import (
    ConvexShape,
    Frame,
    bvh_geometry,
    convex_geometry,
)
from assetpipe.validation.dynamics.process import default_engine, run_worker

ROUNDS = 3


def query_microseconds(
    shapes: Sequence[ConvexShape | Mesh], *, convex: bool, probes: int = 200, seed: int = 0
) -> float:
    """Median time of one FCL distance query between a sphere and all shapes.

    The spheres (radius 2% of the diagonal) lie evenly in the bounding box grown by half.

    Args:
        shapes: convex hulls, or one mesh of any form.
        convex: whether they are asked as convex shapes behind a broad phase, as planners
            hold hulls, or as triangle meshes.
        probes: how many spheres.
        seed: of their places.
    """
    import fcl

    every = np.vstack([np.asarray(shape.vertices) for shape in shapes])
    frame = Frame.around(every)
    make = convex_geometry if convex else bvh_geometry
    world = fcl.DynamicAABBTreeCollisionManager()
    world.registerObjects(
        [
            fcl.CollisionObject(make(frame.points(shape.vertices), np.asarray(shape.faces)))
            for shape in shapes
        ]
    )
    world.setup()
    low, high = frame.points(every.min(axis=0)), frame.points(every.max(axis=0))
    rng = np.random.default_rng(seed)
    centres: FloatArray = (low + high) / 2 + (rng.random((probes, 3)) - 0.5) * 1.5 * (high - low)
    radius = 0.02 * float(np.linalg.norm(high - low))
    spheres = [
        fcl.CollisionObject(fcl.Sphere(radius), fcl.Transform(np.eye(3), centre))
        for centre in centres
    ]
    rounds = []
    for _ in range(ROUNDS):
        began = time.process_time()
        for sphere in spheres:
            data = fcl.DistanceData()
            world.distance(sphere, data, fcl.defaultDistanceCallback)
        rounds.append((time.process_time() - began) / probes * 1e6)
    return float(np.median(rounds))


def step_microseconds(urdf: Path, *, steps: int = 240, timeout: float = 120.0) -> float | None:
    """Median time of one PyBullet step with the robot on its base among falling balls.

    Args:
        urdf: a robot.
        steps: how many, of 1/240 s.
        timeout: seconds of wall time.

    Returns:
        Microseconds; ``None`` where the engine is absent or does not load the robot.
    """
    if default_engine() != "bullet":
        return None
    request: dict[str, Any] = {"task": "cost", "urdf": str(urdf), "steps": steps}
    reply = run_worker("bullet", request, timeout=timeout)
    value = reply.answer.get("microseconds")
    return None if value is None else float(value)
