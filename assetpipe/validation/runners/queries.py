"""Answer a planned question with queries alone: distance, contact, sweep."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from assetpipe.geometry.mesh import FloatArray
from assetpipe.validation.runners.swept import swept_gaps
from assetpipe.validation.runners.world import QueryWorld, key
from assetpipe.validation.scenes.assets import SceneAsset, matrix_of

if TYPE_CHECKING:
    from assetpipe.validation.effects.plan import Plan, Ref
    from assetpipe.validation.scenes.drive import PathDrive
    from assetpipe.validation.scenes.schema import Scene

TOUCHING = 1e-6
"""Metres below which a sweep counts as contact."""
LEAST_ADVANCE = 1e-4
"""Share of the sweep by which it advances at least, so that grazing ends."""


@dataclass(frozen=True)
class Measured:
    """What a run measured.

    Attributes:
        answer: yes or no; ``None`` where the question only measures.
        measure: the number behind it; ``None`` where there is nothing to measure.
        unit: of the measure.
        evidence: what else was seen, JSON-ready.
    """

    answer: bool | None
    measure: float | None
    unit: str
    evidence: Mapping[str, Any]


def run_queries(scene: Scene, assets: Mapping[str, SceneAsset], plan: Plan) -> Measured:
    """Answer a plan whose method is ``nothing``, ``distance``, ``contact`` or ``sweep``."""
    if plan.method == "nothing":
        return Measured(scene.question != "open", 0.0, "m", {"moved": 0.0})
    if plan.method == "sweep":
        return _sweep(scene, assets, plan)
    world = QueryWorld(assets, {ref for pair in plan.pairs for ref in pair})
    if scene.question == "self_collision":
        return _self_collision(scene, assets, plan, world)
    return _still(scene, plan, world)


def _still(scene: Scene, plan: Plan, world: QueryWorld) -> Measured:
    world.place()
    if plan.method == "contact":
        touching = [f"{key(a)} - {key(b)}" for a, b in plan.pairs if world.touch(a, b)]
        return Measured(bool(touching), float(len(touching)), "pairs", {"touching": touching})
    gaps = {(a, b): world.gap(a, b) for a, b in plan.pairs}
    return _clearance(scene, gaps)


def _clearance(scene: Scene, gaps: Mapping[tuple[Ref, Ref], float]) -> Measured:
    if not gaps:
        return Measured(None, None, "m", {})
    (a, b), least = min(gaps.items(), key=lambda item: item[1])
    answer = None if scene.limit is None else least >= scene.limit
    return Measured(answer, least, "m", {"nearest": [key(a), key(b)]})


def _self_collision(
    scene: Scene, assets: Mapping[str, SceneAsset], plan: Plan, world: QueryWorld
) -> Measured:
    asset = assets[str(scene.subject)]
    sampling = scene.sampling
    drawn = asset.configurations(
        sampling.configurations if sampling else 0, sampling.seed if sampling else 0
    )
    frames = {key((asset.name, n)): m for n, m in asset.frames_of(drawn).items()}
    answers = {
        f"{a[1]} - {b[1]}": found for (a, b), found in world.touching(plan.pairs, frames).items()
    }
    colliding = np.zeros(len(drawn), dtype=bool)
    for found in answers.values():
        colliding |= found
    at_start = [name for name, found in answers.items() if found[0]]
    return Measured(
        bool(at_start),
        float(colliding.mean()),
        "share of configurations",
        {
            "configurations": len(drawn),
            "at_start": at_start,
            "pairs": {n: int(f.sum()) for n, f in sorted(answers.items()) if f.any()},
        },
    )


# -- sweeps -------------------------------------------------------------------


def base_on_path(asset: SceneAsset, path: PathDrive, time: float) -> FloatArray:
    """World-from-base (4, 4) of the asset on the path, straight between waypoints."""
    before_xyz: FloatArray = np.zeros(3)
    before_rpy: FloatArray = np.zeros(3)
    since = 0.0
    for point in path.waypoints:
        xyz, rpy = np.asarray(point.xyz), np.asarray(point.rpy)
        if time <= point.at:
            share = (time - since) / (point.at - since)
            between = matrix_of(
                (before_xyz + share * (xyz - before_xyz)).tolist(),
                (before_rpy + share * (rpy - before_rpy)).tolist(),
            )
            moved: FloatArray = np.matmul(asset.world_from_base, between)
            return moved
        before_xyz, before_rpy, since = xyz, rpy, point.at
    last: FloatArray = asset.world_from_base.dot(
        matrix_of(before_xyz.tolist(), before_rpy.tolist())
    )
    return last


def joints_on_trajectory(scene: Scene, time: float) -> dict[str, float]:
    """Joint positions of the trajectory at a time, straight between its points."""
    trajectory = scene.drive.trajectory
    if trajectory is None:
        return {}
    positions = {}
    for name, values in trajectory.joints.items():
        at = min(max(time / trajectory.seconds, 0.0), 1.0) * (len(values) - 1)
        positions[name] = float(np.interp(at, np.arange(len(values)), values))
    return positions


def _sweep(scene: Scene, assets: Mapping[str, SceneAsset], plan: Plan) -> Measured:
    """Sweep the given motion: straight sweeps at once, everything else step by step.

    The steps are conservative advancement (Mirtich & Canny 1995).

    With d the least separation and v a bound of the closing speed, nothing can touch
    before d/v has passed; so that much is skipped, and contact is never jumped over.
    """
    from assetpipe.validation.effects.motion import Motion

    motion = Motion(scene, assets)
    stops = [_frames_at(scene, assets, time) for time in _corners(scene)]
    swept = swept_gaps(motion, list(plan.pairs), stops)
    blocked = [pair for pair, gap in swept.items() if gap <= TOUCHING]
    # Where a straight sweep meets something, stepping tells when.
    stepped = [p for p in plan.pairs if p not in swept or p in blocked]
    # A clearance is wanted to a tenth of its tolerance, contact only to the touch.
    fine = 0.1 * scene.expect.tolerance if scene.question == "clearance" else math.inf
    found = _Swept(None, -1.0, {"queries": 0})
    if stepped:
        world = QueryWorld(assets, {ref for pair in stepped for ref in pair})

        def place(time: float) -> None:
            world.place_links(_frames_at(scene, assets, time))

        speeds = {p: motion.speed(p[0]) + motion.speed(p[1]) for p in stepped}
        found = _advance(place, world, plan.seconds, speeds, fine)
    found = _joined(found, {p: g for p, g in swept.items() if p not in blocked}, plan.seconds)
    # Nothing that can get there leaves nothing to measure.
    least = found.least if found.least >= 0.0 else None
    if scene.question == "clearance":
        wide = least is None or scene.limit is None or least >= scene.limit
        return Measured(None if scene.limit is None else wide, least, "m", found.evidence)
    touched = found.touched is not None
    return Measured(touched == (scene.question == "contact"), least, "m", found.evidence)


@dataclass(frozen=True)
class _Swept:
    touched: tuple[Ref, Ref] | None
    least: float
    evidence: Mapping[str, Any]


def _joined(found: _Swept, swept: Mapping[tuple[Ref, Ref], float], seconds: float) -> _Swept:
    """Stepped and straight sweeps together."""
    asked = found.evidence["queries"] + len(swept)
    if found.touched is not None or not swept:
        return _Swept(found.touched, found.least, {**found.evidence, "queries": asked})
    pair, least = min(swept.items(), key=lambda item: item[1])
    if 0.0 <= found.least <= least:
        return _Swept(None, found.least, {**found.evidence, "queries": asked})
    said = {"touched": None, "nearest": [key(pair[0]), key(pair[1])], "at": seconds}
    return _Swept(None, least, {**said, "of": seconds, "queries": asked})


def _corners(scene: Scene) -> list[float]:
    """Times between which the given motion is straight."""
    times = {0.0}
    path, trajectory = scene.drive.path, scene.drive.trajectory
    if path is not None:
        times |= {w.at for w in path.waypoints}
    if trajectory is not None:
        count = len(next(iter(trajectory.joints.values())))
        times |= {trajectory.seconds * i / (count - 1) for i in range(count)}
    return sorted(times)


def _frames_at(
    scene: Scene, assets: Mapping[str, SceneAsset], time: float
) -> dict[str, FloatArray]:
    """World-from-link matrices of everything at a time of the given motion."""
    path, trajectory = scene.drive.path, scene.drive.trajectory
    frames: dict[str, FloatArray] = {}
    for name, asset in assets.items():
        base = base_on_path(asset, path, time) if path and path.asset == name else None
        follows = trajectory is not None and trajectory.asset == name
        joints = joints_on_trajectory(scene, time) if follows else None
        at = asset.frames(joints, base)
        frames |= {key((name, link)): matrix for link, matrix in at.items()}
    return frames


def _advance(
    place: Callable[[float], None],
    world: QueryWorld,
    seconds: float,
    speeds: Mapping[tuple[Ref, Ref], float],
    fine: float,
) -> _Swept:
    time, least, nearest, asked = 0.0, math.inf, None, 0
    # For every pair the time before which it cannot touch or beat the least gap.
    due = dict.fromkeys(speeds, 0.0)
    while due:
        place(time)
        for pair in [p for p, when in due.items() if when <= time]:
            # What starts outside cannot get inside without touching on the way.
            gap = world.gap(*pair) if time == 0.0 else world.surface_gap(*pair)
            asked += 1
            if gap < least:
                least, nearest = gap, pair
            if gap <= TOUCHING:
                return _Swept(
                    pair,
                    0.0,
                    {
                        "touched": [key(pair[0]), key(pair[1])],
                        "at": time,
                        "of": seconds,
                        "queries": asked,
                    },
                )
            pause = gap / speeds[pair] if speeds[pair] > 0.0 else math.inf
            if math.isfinite(fine) and speeds[pair] > 0.0:
                # It may come no nearer than the least before gap - least is used up.
                pause = max(gap - least, fine) / speeds[pair]
            due[pair] = time + max(pause, LEAST_ADVANCE * seconds)
        if time >= seconds:
            break
        time = min(*due.values(), seconds)
    told = [key(nearest[0]), key(nearest[1])] if nearest else None
    least = least if math.isfinite(least) else -1.0
    return _Swept(
        None,
        least,
        {
            "touched": None,
            "nearest": told,
            "at": seconds,
            "of": seconds,
            "queries": asked,
        },
    )
