"""Answer a planned question with a physics engine, and read the answer from its states."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from assetpipe.errors import AssetpipeError
from assetpipe.geometry.mesh import FloatArray
from assetpipe.validation.dynamics.model import quaternion, write_model
from assetpipe.validation.dynamics.process import EngineName, run_worker
from assetpipe.validation.effects.motion import Motion
from assetpipe.validation.effects.plan import EFFECTS, Backend, Plan
from assetpipe.validation.runners.queries import Measured
from assetpipe.validation.scenes.assets import SceneAsset, SceneJoint, matrix_of

if TYPE_CHECKING:
    from assetpipe.validation.scenes.schema import Scene

GUARD = 0.01
"""Metres that a driven asset may lag behind its path before the path waits for it."""
MARGINS: Mapping[Backend, float] = {"bullet": 1e-3, "mujoco": 0.0, "fcl": 0.0, "none": 0.0}
"""Metres that an engine's URDF importer puts around every hull."""
MOTOR_FORCE = 1e3
"""Newtons or newton metres of a motor whose limit nobody states."""


class SimulationError(AssetpipeError):
    """The engine did not answer: it crashed, ran out of time, or refused the model."""


@dataclass(frozen=True)
class Simulated:
    """A physics run.

    Attributes:
        measured: the answer.
        build_seconds: CPU time to make the world.
        run_seconds: CPU time to step it.
    """

    measured: Measured
    build_seconds: float
    run_seconds: float


def run_dynamics(
    scene: Scene, assets: Mapping[str, SceneAsset], plan: Plan, *, timeout: float = 300.0
) -> Simulated:
    """Simulate a plan whose method is ``dynamics``.

    Raises:
        SimulationError: the engine crashed, refused or took too long.
    """
    engine: EngineName = "mujoco" if plan.backend == "mujoco" else "bullet"
    with tempfile.TemporaryDirectory(prefix="assetpipe-scene-") as folder:
        request = scene_request(scene, assets, plan, Path(folder))
        answer = run_worker(engine, request, timeout=timeout)
    if answer.outcome != "answered":
        said = "; ".join(t for t in (answer.signal, answer.log) if t)
        raise SimulationError(f"{engine} {answer.outcome}: {said}")
    told = answer.answer
    if not told.get("loaded"):
        raise SimulationError(f"{engine} refused the scene: {told.get('message')}")
    if not _finite(told):
        raise SimulationError(f"{engine}: the state is no longer finite, the simulation exploded")
    measured = _read(scene, assets, told)
    return Simulated(measured, float(told["build_seconds"]), float(told["run_seconds"]))


def scene_request(
    scene: Scene, assets: Mapping[str, SceneAsset], plan: Plan, folder: Path
) -> dict[str, Any]:
    """What a worker needs to know, JSON-ready; writes the models into ``folder``."""
    held = plan.idle_joints == "held"
    motion = Motion(scene, assets, held=held)
    bodies = []
    for asset in assets.values():
        active = {j.name: motion.active(asset, j) for j in asset.joints}
        roles = {plan.role(asset.name, item.name) for item in asset.links}
        if roles == {"left out"}:
            continue
        record = write_model(asset, plan, active, folder, margin=MARGINS[plan.backend])
        record |= _joint_records(scene, asset, active, held=held)
        record["material"] = asset.material.model_dump()
        bodies.append(record)
    loaded = {record["name"] for record in bodies}
    path = scene.drive.path
    return {
        "task": "scene",
        "step": plan.step.value,
        "iterations": plan.iterations.value,
        "steps": plan.steps,
        "effects": {
            name: {"on": plan.effect(name).is_on, "value": plan.effect(name).value}
            for name in EFFECTS
        },
        "bodies": bodies,
        "pairs": [[*a, *b] for a, b in plan.pairs],
        "path": _path_record(scene, assets) if path is not None and path.asset in loaded else None,
        "trajectory": _trajectory_record(scene, assets),
        "between": _between(scene, motion) if scene.between else [],
        "configurations": _configurations(scene, assets),
    }


def _joint_records(
    scene: Scene, asset: SceneAsset, active: Mapping[str, bool], *, held: bool
) -> dict[str, Any]:
    start = asset.positions()
    moving = [j for j in asset.joints if active[j.name]]
    return {
        "start": {j.name: start[j.name] for j in moving},
        "damping": {j.name: j.damping for j in moving},
        "resistance": {j.name: asset.resistance.get(j.name, 0.0) + j.friction for j in moving},
        "motors": {
            j.name: motor
            for j in moving
            for motor in [_motor(scene, asset, j, start, held=held)]
            if motor is not None
        },
        "mimic": {
            j.name: list(j.mimic)
            for j in moving
            if j.mimic and _motor(scene, asset, j, start, held=held) is None
        },
        "follow_force": {j.name: _effort(j) for j in moving if j.mimic},
    }


def _motor(
    scene: Scene, asset: SceneAsset, joint: SceneJoint, start: Mapping[str, float], *, held: bool
) -> dict[str, float] | None:
    """The motor of a joint, if it has one; a follower gets the target that follows."""
    drive = scene.drive.motors.get(asset.name)
    targets = dict(drive.targets) if drive is not None else {}
    # Friction-like resistance is no motor; such joints stay passive.
    passive = joint.name in asset.resistance or joint.name in asset.moving
    if joint.name in targets:
        target = targets[joint.name]
    elif joint.mimic is not None and joint.mimic[0] in targets:
        target = joint.mimic[1] * targets[joint.mimic[0]] + joint.mimic[2]
    elif held and not passive:
        target = start[joint.name]
    else:
        return None
    force = drive.force if drive is not None and drive.force is not None else _effort(joint)
    velocity = joint.velocity if math.isfinite(joint.velocity) else 1e3
    return {"target": target, "force": force, "velocity": velocity}


def _effort(joint: SceneJoint) -> float:
    return joint.effort if math.isfinite(joint.effort) else MOTOR_FORCE


def _path_record(scene: Scene, assets: Mapping[str, SceneAsset]) -> dict[str, Any] | None:
    path = scene.drive.path
    if path is None:
        return None
    base = assets[path.asset].world_from_base

    def stop(matrix: FloatArray, at: float) -> dict[str, Any]:
        return {
            "at": at,
            "position": matrix[:3, 3].tolist(),
            "quaternion": quaternion(matrix[:3, :3]),
        }

    return {
        "body": path.asset,
        "force": path.force,
        "guard": GUARD,
        "start": stop(base, 0.0),
        "waypoints": [stop(base @ matrix_of(w.xyz, w.rpy), w.at) for w in path.waypoints],
    }


def _trajectory_record(scene: Scene, assets: Mapping[str, SceneAsset]) -> dict[str, Any] | None:
    trajectory = scene.drive.trajectory
    if trajectory is None:
        return None
    joints = assets[trajectory.asset].joint
    return {
        "body": trajectory.asset,
        "seconds": trajectory.seconds,
        "joints": {
            name: {"positions": list(values), "force": _effort(joints[name])}
            for name, values in trajectory.joints.items()
        },
    }


def _between(scene: Scene, motion: Motion) -> list[list[str]]:
    if scene.between is None:
        return []
    first, second = (motion.parts(r) for r in scene.between)
    return [[*a, *b] for a, b in product(first, second) if a != b]


def _configurations(scene: Scene, assets: Mapping[str, SceneAsset]) -> dict[str, Any] | None:
    if scene.question != "self_collision":
        return None
    asset, sampling = assets[str(scene.subject)], scene.sampling
    drawn = asset.configurations(
        sampling.configurations if sampling else 0, sampling.seed if sampling else 0
    )
    return {"body": asset.name, "positions": [asset.positions(values) for values in drawn]}


# -- reading the answer -------------------------------------------------------


def _finite(value: Any) -> bool:
    """Whether every number in an answer is finite."""
    if isinstance(value, dict):
        return all(_finite(v) for v in value.values())
    if isinstance(value, list):
        return all(_finite(v) for v in value)
    return not isinstance(value, float) or math.isfinite(value)


def _read(scene: Scene, assets: Mapping[str, SceneAsset], told: Mapping[str, Any]) -> Measured:
    if scene.question == "self_collision":
        return _self_collision(told["configurations"])
    states, path = told["states"], told["path"]
    evidence = {"path": path, "touching": told["touching"], "simulated": states[-1]["time"]}
    if told.get("notes"):
        evidence["notes"] = told["notes"]
    limit = scene.limit if scene.limit is not None else math.inf
    if scene.question == "reach":
        free = not path["touched"] and path["progress"] >= 1.0 - 1e-6
        return Measured(free, path["progress"], "share of the path", evidence)
    if scene.question == "contact":
        return Measured(
            any(d <= 0.0 for d in told["distances"]),
            min(told["distances"], default=None),
            "m",
            evidence,
        )
    if scene.question == "clearance":
        least = max(0.0, min(told["distances"], default=math.inf))
        answer = None if scene.limit is None else least >= limit
        return Measured(answer, least, "m", evidence)
    if scene.question == "open":
        asset, _, joint = str(scene.subject).partition("/")
        ends = [state["joints"].get(asset, {}).get(joint) for state in (states[0], states[-1])]
        way = abs(ends[1] - ends[0]) if None not in ends else 0.0
        unit = "m" if assets[asset].joint[joint].kind == "prismatic" else "rad"
        return Measured(way >= limit, way, unit, evidence)
    if scene.question == "slide":
        return _slide(scene, assets, states, limit, evidence)
    if scene.question == "hold":
        watched = [str(scene.subject)]
    else:
        watched = [name for name, asset in assets.items() if asset.base == "free"]
    moved = {name: _displacement(assets, name, states[0], states[-1]) for name in watched}
    worst = max(moved.values())
    return Measured(worst <= limit, worst, "m", {**evidence, "moved": moved})


def _frames(asset: SceneAsset, state: Mapping[str, Any]) -> dict[str, FloatArray]:
    pose = state["bases"].get(asset.name)
    base = None
    if pose is not None:
        from scipy.spatial.transform import Rotation

        base = np.eye(4)
        base[:3, :3] = Rotation.from_quat(pose[3:]).as_matrix()
        base[:3, 3] = pose[:3]
    return asset.frames(state["joints"].get(asset.name), base)


def _displacement(
    assets: Mapping[str, SceneAsset],
    reference: str,
    first: Mapping[str, Any],
    last: Mapping[str, Any],
) -> float:
    """Metres that the farthest-moved corner of the links' boxes went; turning counts."""
    name, _, only = reference.partition("/")
    asset = assets[name]
    before, after = _frames(asset, first), _frames(asset, last)
    worst = 0.0
    for link in asset.links:
        if not link.shapes or (only and link.name != only):
            continue
        low, high = link.body.vertices.min(axis=0), link.body.vertices.max(axis=0)
        corners = np.array(list(product(*zip(low, high, strict=True))))
        ends = [corners @ m[link.name][:3, :3].T + m[link.name][:3, 3] for m in (before, after)]
        worst = max(worst, float(np.linalg.norm(ends[1] - ends[0], axis=1).max()))
    return worst


def _slide(
    scene: Scene,
    assets: Mapping[str, SceneAsset],
    states: list[dict[str, Any]],
    limit: float,
    evidence: dict[str, Any],
) -> Measured:
    """How far the subject strays from moving along with the path.

    Across the path it counts at every moment, along it at the end only, less the way
    that the pusher had to go before it touched.
    """
    path = scene.drive.path
    subject = assets[str(scene.subject).partition("/")[0]]
    if path is None:
        return Measured(None, 0.0, "m", evidence)
    driver = assets[path.asset]
    way = driver.world_from_base[:3, :3] @ np.asarray(path.waypoints[-1].xyz)
    length = float(np.linalg.norm(way))
    along = way / length if length > 0.0 else np.zeros(3)
    at = np.array([state["bases"][subject.name][:3] for state in states])
    gone = at - at[0]
    across = float(np.linalg.norm(gone - np.outer(gone @ along, along), axis=1).max())
    travelled = float(gone[-1] @ along)
    pushed = np.asarray(states[-1]["bases"][driver.name][:3]) - np.asarray(
        states[0]["bases"][driver.name][:3]
    )
    lost = length - float(pushed @ along)
    strayed = max(across, abs(lost))
    said = {**evidence, "across": across, "pusher_lost": lost, "travelled": travelled}
    moved = travelled > 0.5 * length
    return Measured(strayed <= limit and moved, strayed, "m", said)


def _self_collision(configurations: list[list[list[str]]]) -> Measured:
    counts: dict[str, int] = {}
    for touching in configurations:
        for a, b in touching:
            name = f"{a} - {b}"
            counts[name] = counts.get(name, 0) + 1
    share = sum(bool(t) for t in configurations) / len(configurations)
    return Measured(
        bool(configurations[0]),
        share,
        "share of configurations",
        {
            "configurations": len(configurations),
            "at_start": [" - ".join(p) for p in configurations[0]],
            "pairs": dict(sorted(counts.items())),
        },
    )
