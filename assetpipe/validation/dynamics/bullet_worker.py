"""Worker: load a URDF into PyBullet and answer about it. Runs in its own process."""

from __future__ import annotations

import sys
from typing import Any

from assetpipe.validation.dynamics.process import serve

REACH = 10.0
"""Metres up to which distances are asked."""


def answer(request: dict[str, Any]) -> dict[str, Any]:
    """Answer a request: load and ask distances, or simulate a scene.

    Args:
        request: ``task`` "load": ``urdf`` path and ``probes``, a list of ``{link,
            centre (link frame), radius}``; ``task`` "scene": see ``runners.dynamics``; "cost": see
            ``bullet_cost``; "settle": see ``settle``.
    """
    if request["task"] == "scene":
        from assetpipe.validation.dynamics.bullet_scene import simulate

        return simulate(request)
    if request["task"] == "cost":
        from assetpipe.validation.dynamics.bullet_cost import measure

        return measure(request)
    if request["task"] == "settle":
        from assetpipe.validation.dynamics.bullet_settle import settle

        return settle(request)
    import pybullet

    client = pybullet.connect(pybullet.DIRECT)
    try:
        body = pybullet.loadURDF(request["urdf"], useFixedBase=True, physicsClientId=client)
    except pybullet.error as error:
        return {"loaded": False, "message": str(error)}
    index = {pybullet.getBodyInfo(body)[0].decode(): -1}
    for joint in range(pybullet.getNumJoints(body)):
        index[pybullet.getJointInfo(body, joint)[12].decode()] = joint
    shapes = {name: len(pybullet.getCollisionShapeData(body, i) or ()) for name, i in index.items()}
    distances: list[float | None] = []
    margins: list[float] = []
    for probe in request["probes"]:
        link = index.get(probe["link"])
        if link is None:
            distances.append(None)
            margins.append(0.0)
            continue
        position, rotation = _link_frame(pybullet, body, link)
        at, _ = pybullet.multiplyTransforms(position, rotation, probe["centre"], (0, 0, 0, 1))
        shape = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=probe["radius"])
        ball = pybullet.createMultiBody(0.0, shape, basePosition=at)
        points = pybullet.getClosestPoints(body, ball, REACH, linkIndexA=link)
        distances.append(min(point[8] for point in points) if points else None)
        margins.append(float(pybullet.getDynamicsInfo(body, link)[11]))
        pybullet.removeBody(ball)
    return {
        "loaded": True,
        "message": "",
        "shapes": shapes,
        "distances": distances,
        "margins": margins,
    }


def _link_frame(pybullet: Any, body: int, link: int) -> tuple[Any, Any]:
    """World pose of a link's URDF frame.

    The base's reported pose is that of its centre of mass, other links tell both.
    """
    if link >= 0:
        state = pybullet.getLinkState(body, link, computeForwardKinematics=True)
        return state[4], state[5]
    inertial = pybullet.getDynamicsInfo(body, -1)
    back = pybullet.invertTransform(inertial[3], inertial[4])
    at = pybullet.getBasePositionAndOrientation(body)
    return pybullet.multiplyTransforms(at[0], at[1], back[0], back[1])  # type: ignore[no-any-return]


if __name__ == "__main__":
    serve(sys.argv[1:], answer)
