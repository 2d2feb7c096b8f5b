"""Write an asset for a physics engine: only what its plan keeps, as a URDF and OBJ files.

The URDF is ours and temporary. What the plan freezes becomes a fixed joint, what it
leaves out loses its shapes, limits that are off are not written; so every engine that
reads URDF simulates the same plan.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np

from assetpipe.geometry import write_obj
from assetpipe.geometry.mesh import FloatArray
from assetpipe.validation.dynamics.erode import eroded
from assetpipe.validation.effects.plan import Plan
from assetpipe.validation.scenes.assets import Inertial, SceneAsset, SceneJoint

LEAST_INERTIA = 1e-9
"""kg·m² below which engines divide by rounding."""


def write_model(
    asset: SceneAsset, plan: Plan, active: Mapping[str, bool], folder: Path, *, margin: float
) -> dict[str, Any]:
    """Write ``folder/<asset>.urdf``.

    Args:
        asset: what to write.
        plan: decides shapes and limits.
        active: which joints are simulated, by name; others are welded where they start.
        margin: metres that the engine adds around every hull; hulls are shrunk by it.
        folder: exists; OBJ files are shared between assets by content.

    Returns:
        The worker's record of the body: path, base pose, inertial frame of the base.
    """
    start = asset.positions()
    limits = plan.effect("joint_limits").is_on
    parts = [f"<robot name={quoteattr(asset.name)}>"]
    for link in asset.links:
        role = plan.role(asset.name, link.name)
        shapes = link.shapes if role in ("moves", "frozen") else ()
        parts.append(f"<link name={quoteattr(link.name)}>")
        parts.append(_inertial_text(link.inertial))
        ball = link.round_shape
        if ball is not None and ball.kind == "sphere":
            # A polyhedron would rest on a facet, and roll to it first.
            parts += [
                f'<collision><geometry><sphere radius="{ball.radius!r}"/></geometry></collision>'
                for _ in shapes
            ]
            shapes = ()
        for shape in shapes:
            path = folder / f"{shape.digest[:24]}.obj"
            if not path.exists():
                write_obj(eroded(shape, margin), path)
            parts.append(
                f"<collision><geometry><mesh filename={quoteattr(path.name)}/>"
                "</geometry></collision>"
            )
        parts.append("</link>")
    for joint in asset.joints:
        parts.append(_joint_text(joint, start[joint.name], active[joint.name], limits))
    parts.append("</robot>")
    urdf = folder / f"{asset.name}.urdf"
    urdf.write_text("\n".join(parts), encoding="utf-8")
    inertial = asset.links[0].inertial
    centre, turn, principal = np.zeros(3), np.eye(3), np.full(3, LEAST_INERTIA)
    if inertial is not None:
        centre, turn, principal = _principal(inertial)
    convex = None
    centred = not centre.any() and bool((turn == np.eye(3)).all())
    touches = plan.role(asset.name, asset.links[0].name) in ("moves", "frozen")
    if len(asset.links) == 1 and len(asset.links[0].shapes) == 1 and centred and touches:
        convex = {
            "obj": str(folder / f"{asset.links[0].shapes[0].digest[:24]}.obj"),
            "mass": inertial.mass if inertial is not None else 0.0,
            "inertia": principal.tolist(),
            "ball": None,
        }
        ball = asset.links[0].round_shape
        if ball is not None and ball.kind == "sphere":
            convex["ball"] = ball.radius
    return {
        "name": asset.name,
        "urdf": str(urdf),
        "base": asset.base,
        "links": [link.name for link in asset.links],
        "single": len(asset.links) == 1,
        "convex": convex,
        "position": asset.world_from_base[:3, 3].tolist(),
        "quaternion": quaternion(asset.world_from_base[:3, :3]),
        "inertial_position": centre.tolist(),
        "inertial_quaternion": quaternion(turn),
    }


def _inertial_text(inertial: Inertial | None) -> str:
    if inertial is None or not inertial.mass > 0.0:
        return ""
    centre, turn, principal = _principal(inertial)
    xyz, rpy = _numbers(centre), _numbers(_rpy(turn))
    ixx, iyy, izz = (repr(float(v)) for v in principal)
    return (
        f'<inertial><origin xyz="{xyz}" rpy="{rpy}"/><mass value="{inertial.mass!r}"/>'
        f'<inertia ixx="{ixx}" iyy="{iyy}" izz="{izz}" ixy="0" ixz="0" iyz="0"/></inertial>'
    )


def _principal(inertial: Inertial) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Centre (3,), rotation (3, 3) to the principal axes, principal inertias (3,)."""
    values, axes = np.linalg.eigh((inertial.inertia + inertial.inertia.T) / 2.0)
    # Nearly diagonal tensors keep their axes: fewer turned frames, easier to read.
    scale = float(np.abs(inertial.inertia).max())
    off = inertial.inertia - np.diag(np.diag(inertial.inertia))
    if float(np.abs(off).max()) <= 1e-9 * scale:
        values, axes = np.diag(inertial.inertia).copy(), np.eye(3)
    elif np.linalg.det(axes) < 0:
        axes[:, 0] = -axes[:, 0]
    # Bullet keeps a single hull convex (and so able to move continuously) only where its
    # frame is the inertial frame exactly: rounding must not shift it.
    centre = np.where(np.abs(inertial.centre) < 1e-9, 0.0, inertial.centre)
    return centre, axes, np.maximum(values, LEAST_INERTIA)


def _joint_text(joint: SceneJoint, position: float, active: bool, limits: bool) -> str:
    kind = joint.kind if active else "fixed"
    origin = joint.parent_from_joint if active else joint.moved(position)
    text = (
        f'<joint name={quoteattr(joint.name)} type="{kind}">'
        f"<parent link={quoteattr(joint.parent)}/><child link={quoteattr(joint.child)}/>"
        f'<origin xyz="{_numbers(origin[:3, 3])}" rpy="{_numbers(_rpy(origin[:3, :3]))}"/>'
    )
    if active:
        text += f'<axis xyz="{_numbers(joint.axis)}"/>'
        # Lower above upper means free to both engines' importers.
        bounded = limits and math.isfinite(joint.lower) and math.isfinite(joint.upper)
        lower, upper = (joint.lower, joint.upper) if bounded else (1.0, -1.0)
        text += f'<limit lower="{lower!r}" upper="{upper!r}" effort="1e6" velocity="1e6"/>'
    return text + "</joint>"


def _numbers(values: FloatArray) -> str:
    return " ".join(repr(float(v)) for v in values)


def _rpy(turn: FloatArray) -> FloatArray:
    """Roll, pitch, yaw of a rotation matrix; yaw 0 where pitch is ±90°."""
    flat = math.hypot(turn[0, 0], turn[1, 0])
    pitch = math.atan2(-turn[2, 0], flat)
    if flat < 1e-9:
        return np.array([math.atan2(-turn[1, 2], turn[1, 1]), pitch, 0.0])
    return np.array([math.atan2(turn[2, 1], turn[2, 2]), pitch, math.atan2(turn[1, 0], turn[0, 0])])


def quaternion(turn: FloatArray) -> list[float]:
    """(x, y, z, w) of a rotation matrix."""
    from scipy.spatial.transform import Rotation

    return [float(v) for v in Rotation.from_matrix(turn).as_quat()]
