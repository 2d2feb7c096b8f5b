"""Worker: load a URDF into MuJoCo and answer about it. Runs in its own process."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from assetpipe.validation.dynamics.process import serve

REACH = 10.0
"""Metres up to which distances are asked."""


def answer(request: dict[str, Any]) -> dict[str, Any]:
    """Load and, where probes are given, ask distances.

    Args:
        request: ``task`` "load": ``urdf`` path and ``probes``, a list of ``{link,
            centre (link frame), radius}``; ``task`` "scene": see ``runners.dynamics``;
            "settle": see ``settle``.
    """
    if request["task"] == "scene":
        from assetpipe.validation.dynamics.mujoco_scene import simulate

        return simulate(request)
    if request["task"] == "settle":
        from assetpipe.validation.dynamics.mujoco_settle import settle

        return settle(request)
    import mujoco
    import numpy as np

    probes = request["probes"]
    try:
        spec = mujoco.MjSpec.from_file(request["urdf"])
        for number, radius in enumerate(sorted({p["radius"] for p in probes})):
            body = spec.worldbody.add_body(name=f"assetpipe-probe-{number}", mocap=True)
            body.add_geom(
                name=f"assetpipe-probe-{number}",
                type=mujoco.mjtGeom.mjGEOM_SPHERE,
                size=[radius, 0.0, 0.0],
            )
        model = spec.compile()
    except (ValueError, mujoco.FatalError) as error:
        return {"loaded": False, "message": str(error)}
    data = mujoco.MjData(model)
    names = {model.body(i).name: i for i in range(model.nbody)}
    shapes = {
        name: int(model.body_geomnum[i])
        for name, i in names.items()
        if name != "world" and not name.startswith("assetpipe-probe-")
    }
    mujoco.mj_forward(model, data)
    distances: list[float | None] = []
    radii = {r: k for k, r in enumerate(sorted({p["radius"] for p in probes}))}
    between = np.zeros(6)
    for probe in probes:
        body_id = names.get(probe["link"])
        if body_id is None:
            distances.append(None)
            continue
        ball = model.geom(f"assetpipe-probe-{radii[probe['radius']]}")
        at = data.xmat[body_id].reshape(3, 3) @ np.asarray(probe["centre"]) + data.xpos[body_id]
        data.mocap_pos[model.body_mocapid[ball.bodyid[0]]] = at
        mujoco.mj_kinematics(model, data)
        first, count = int(model.body_geomadr[body_id]), int(model.body_geomnum[body_id])
        found = [
            mujoco.mj_geomDistance(model, data, g, ball.id, REACH, between)
            for g in range(first, first + count)
        ]
        distances.append(min(found) if found else None)
    return {
        "loaded": True,
        "message": "",
        "shapes": shapes,
        "distances": distances,
        "margins": [0.0] * len(probes),
    }


def prepare(urdf: Path) -> None:
    """Add MuJoCo's compiler options to a URDF in place.

    Without them MuJoCo strips folders from mesh names, merges links behind fixed joints
    into their parents and refuses links without mass.
    """
    from lxml import etree

    parser = etree.XMLParser(resolve_entities=False, no_network=True, huge_tree=False)
    tree = etree.parse(str(urdf), parser)
    root = tree.getroot()
    extension = root.find("mujoco")
    if extension is None:
        extension = etree.SubElement(root, "mujoco")
    compiler = extension.find("compiler")
    if compiler is None:
        compiler = etree.SubElement(extension, "compiler")
    for key, value in (
        ("strippath", "false"),
        ("fusestatic", "false"),
        ("discardvisual", "true"),
        ("balanceinertia", "true"),
        ("boundmass", "1e-6"),
        ("boundinertia", "1e-12"),
    ):
        compiler.set(key, value)
    tree.write(str(urdf), encoding="utf-8", xml_declaration=True)


if __name__ == "__main__":
    serve(sys.argv[1:], answer)
