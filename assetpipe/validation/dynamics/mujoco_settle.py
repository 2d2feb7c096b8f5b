"""Worker: hold a robot at home in MuJoCo and watch. Runs in its own process."""

from __future__ import annotations

import time
from typing import Any

from assetpipe.validation.dynamics.settle_record import (
    CLEARANCE,
    FLOOR_FRICTION,
    GRAVITY,
    Snapshot,
    every,
    summary,
)


def settle(request: dict[str, Any]) -> dict[str, Any]:
    """Load, hold, step, and tell; see ``settle``."""
    import mujoco

    try:
        model, free = _model(mujoco, request)
    except (ValueError, mujoco.FatalError) as error:
        return {"loaded": False, "finite": False, "message": str(error)}
    data = mujoco.MjData(model)
    home = [(model.joint(i), request["home"].get(model.joint(i).name, 0.0)) for i in _held(model)]
    for joint, position in home:
        data.qpos[joint.qposadr[0]] = position
    mujoco.mj_forward(model, data)
    size, lowest = _box(mujoco, model, data)
    if free:
        data.qpos[2] += CLEARANCE - lowest
    mujoco.mj_forward(model, data)
    states, spent = [_look(mujoco, model, data)], 0.0
    between = every(request["step"])
    for number in range(1, request["steps"] + 1):
        began = time.process_time()
        mujoco.mj_step(model, data)
        spent += time.process_time() - began
        # MuJoCo resets what explodes and only warns; to us that is an explosion.
        bad = any(data.warning[w].number for w in (
            mujoco.mjtWarning.mjWARN_BADQPOS,
            mujoco.mjtWarning.mjWARN_BADQVEL,
            mujoco.mjtWarning.mjWARN_BADQACC,
        ))  # fmt: skip
        if bad:
            return {
                "loaded": True,
                "finite": False,
                "message": f"unstable after {number * request['step']:.4g} s",
            }
        if number % between == 0 or number == request["steps"]:
            states.append(_look(mujoco, model, data))
    sag = max((abs(float(data.qpos[j.qposadr[0]]) - at) for j, at in home), default=0.0)
    return summary(states, mass=float(model.body_mass.sum()), size=size, sag=sag, cpu_seconds=spent)


def _model(mujoco: Any, request: dict[str, Any]) -> tuple[Any, bool]:
    spec = mujoco.MjSpec.from_file(request["urdf"])
    spec.option.timestep = request["step"]
    spec.option.gravity = [0.0, 0.0, -GRAVITY]
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    # Without it two meshes get a single contact point, and nothing can stand.
    many = getattr(mujoco.mjtEnableBit, "mjENBL_MULTICCD", None)
    if many is not None:
        spec.option.enableflags |= int(many)
    bodies = {body.name for body in spec.bodies}
    for first, second in request["excluded"]:
        if first in bodies and second in bodies:
            spec.add_exclude(bodyname1=first, bodyname2=second)
    for joint in spec.joints:
        # A motor that holds: a soft constraint, which is integrated implicitly.
        data = [float(request["home"].get(joint.name, 0.0))] + [0.0] * (mujoco.mjNEQDATA - 1)
        spec.add_equality(
            type=mujoco.mjtEq.mjEQ_JOINT,
            objtype=mujoco.mjtObj.mjOBJ_JOINT,
            name1=joint.name,
            data=data,
        )
    free = request["base"] == "free"
    if free:
        root = spec.worldbody.first_body()
        root.add_freejoint(name="assetpipe-free")
        spec.worldbody.add_geom(
            name="assetpipe-floor",
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=[0.0, 0.0, 1.0],
            friction=[FLOOR_FRICTION, 0.005, 0.0001],
        )
    return spec.compile(), free


def _held(model: Any) -> list[int]:
    """Joints that turn or slide (MuJoCo's types 2 and 3)."""
    return [i for i in range(model.njnt) if int(model.jnt_type[i]) in (2, 3)]


def _box(mujoco: Any, model: Any, data: Any) -> tuple[float, float]:
    """Diagonal of the robot's box, and its lowest height, metres."""
    import numpy as np

    # Links without a shape still have a place.
    points = [data.xipos[1:]]
    for geom in range(model.ngeom):
        if int(model.geom_type[geom]) == int(mujoco.mjtGeom.mjGEOM_PLANE):
            continue
        mesh = int(model.geom_dataid[geom])
        if mesh >= 0:
            first = int(model.mesh_vertadr[mesh])
            own = model.mesh_vert[first : first + int(model.mesh_vertnum[mesh])]
        else:
            centre, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
            signs = np.stack(np.meshgrid(*[[-1, 1]] * 3), axis=-1).reshape(-1, 3)
            own = centre + signs * half
        points.append(own @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom])
    every_point = np.vstack(points)
    low, high = every_point.min(axis=0), every_point.max(axis=0)
    return float(np.linalg.norm(high - low)), float(low[2])


def _look(mujoco: Any, model: Any, data: Any) -> Snapshot:
    import numpy as np

    velocity = np.zeros(6)
    speed = spin = 0.0
    for body in range(1, model.nbody):
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_BODY, body, velocity, 0)
        spin = max(spin, float(np.linalg.norm(velocity[:3])))
        speed = max(speed, float(np.linalg.norm(velocity[3:])))
    mujoco.mj_energyPos(model, data)
    mujoco.mj_energyVel(model, data)
    places = tuple((float(x), float(y), float(z)) for x, y, z in data.xipos[1:])
    return Snapshot(float(data.time), float(data.energy.sum()), speed, spin, places)
