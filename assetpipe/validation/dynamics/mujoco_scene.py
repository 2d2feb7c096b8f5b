"""Simulate a planned scene in MuJoCo. Runs in the worker's process only.

The same request as for Bullet, and the same records back. What MuJoCo has no switch for
is said in the record's ``notes``: it has no restitution coefficient and no continuous
collision, its contacts are soft by design, and its margin would lift bodies by as much.
"""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import Any

SAMPLES = 200
"""States recorded over a run."""
GIVE = 1e-3
"""Metres (radians) by which a motor gives way before it pushes with all its force."""


def simulate(request: dict[str, Any]) -> dict[str, Any]:
    """Build the world, run it, and return what was recorded (see ``runners.dynamics``)."""
    import mujoco

    started = time.process_time()
    try:
        world = _World(mujoco, request)
    except (ValueError, mujoco.FatalError) as error:
        return {"loaded": False, "message": str(error)}
    built = time.process_time()
    asked = request["configurations"]
    recorded = world.ask_configurations(asked) if asked is not None else world.run()
    ended = time.process_time()
    return {
        "loaded": True,
        "message": "",
        "build_seconds": built - started,
        "run_seconds": ended - built,
        "notes": world.notes,
        **recorded,
    }


class _World:
    def __init__(self, mujoco: Any, request: dict[str, Any]) -> None:
        from assetpipe.validation.dynamics.mujoco_worker import prepare

        self.m, self.request = mujoco, request
        self.records = {r["name"]: r for r in request["bodies"]}
        self.notes = [
            f"{name} is not simulated by this engine"
            for name in ("restitution", "continuous_collision", "contact_margin")
            if self.on(name)
        ]
        spec = mujoco.MjSpec()
        spec.option.timestep = request["step"]
        spec.option.iterations = int(request["iterations"])
        spec.option.gravity = [0, 0, -self.value("gravity") if self.on("gravity") else 0.0]
        spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        # Without it two meshes get a single contact point, and nothing can stand.
        many = getattr(mujoco.mjtEnableBit, "mjENBL_MULTICCD", None)
        if many is not None:
            spec.option.enableflags |= int(many)
        for record in request["bodies"]:
            prepare(Path(record["urdf"]))
            self._add(spec, record)
        self._pairs(spec)
        if request["path"] is not None:
            self._anchor(spec, request["path"])
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self._start()
        self.path_time = 0.0

    def on(self, effect: str) -> bool:
        return bool(self.request["effects"][effect]["on"])

    def value(self, effect: str) -> float:
        return float(self.request["effects"][effect]["value"] or 0.0)

    # -- building -------------------------------------------------------------

    def _add(self, spec: Any, record: dict[str, Any]) -> None:
        mujoco, name = self.m, record["name"]
        child = mujoco.MjSpec.from_file(record["urdf"])
        for mesh in child.meshes:
            mesh.file = str(Path(record["urdf"]).parent / Path(mesh.file).name)
        for body in child.bodies:
            for number, geom in enumerate(body.geoms):
                geom.name = f"{body.name}#{number}"
                geom.contype = geom.conaffinity = 0  # only planned pairs meet
        for joint in child.joints:
            damped = record["damping"].get(joint.name, 0.0) if self.on("damping") else 0.0
            motor = record["motors"].get(joint.name) if self.on("motors") else None
            if motor is not None:
                damped += 2.0 * motor["force"] / GIVE * self.request["step"]
            # The element is a polynomial's coefficients in newer releases.
            try:
                joint.damping = damped
            except TypeError:
                joint.damping = [damped, 0.0, 0.0]
            joint.frictionloss = record["resistance"].get(joint.name, 0.0)
        x, y, z, w = record["quaternion"]
        frame = spec.worldbody.add_frame(pos=record["position"], quat=[w, x, y, z])
        spec.attach(child, prefix=f"{name}/", frame=frame)
        if record["base"] != "fixed":
            root = spec.body(f"{name}/{record['links'][0]}")
            root.add_freejoint(name=f"{name}/")

    def _anchor(self, spec: Any, path: dict[str, Any]) -> None:
        """Tie the driven asset to a point that is moved along the path."""
        self.notes.append("the path's force is bounded by how far the asset may lag, only")
        record = self.records[path["body"]]
        x, y, z, w = record["quaternion"]
        spec.worldbody.add_body(name="path", mocap=True, pos=record["position"], quat=[w, x, y, z])
        step = self.request["step"]
        # Anchor (3), relative position (3) and rotation (4), weight of the rotation; newer
        # releases have one number more.
        weld = [0.0] * 6 + [1.0, 0.0, 0.0, 0.0, 1.0]
        weld += [0.0] * (self.m.mjNEQDATA - len(weld))
        spec.add_equality(
            type=self.m.mjtEq.mjEQ_WELD,
            objtype=self.m.mjtObj.mjOBJ_BODY,
            name1="path",
            name2=f"{path['body']}/{record['links'][0]}",
            data=weld,
            solref=[2.0 * step, 1.0],
            solimp=[0.95, 0.99, 1e-4, 0.5, 2.0],
        )

    def _pairs(self, spec: Any) -> None:
        for a, la, c, lc in self.request["pairs"]:
            friction = self._friction(a, c)
            for first in spec.body(f"{a}/{la}").geoms:
                for second in spec.body(f"{c}/{lc}").geoms:
                    spec.add_pair(
                        geomname1=first.name,
                        geomname2=second.name,
                        friction=friction,
                        # As stiff as the step allows; the default would sink by centimetres.
                        solref=[2.0 * self.request["step"], 1.0, 0.0, 0.0, 0.0][:2],
                        solimp=[0.95, 0.99, 1e-4, 0.5, 2.0],
                        condim=6 if friction[2] or friction[3] else 3,
                    )

    def _friction(self, a: str, c: str) -> list[float]:
        found = []
        for key in ("friction", "spinning_friction", "rolling_friction"):
            both = []
            for name in (a, c):
                stated = self.records[name]["material"].get(key)
                both.append(self.value(key) if stated is None else float(stated))
            # MuJoCo takes the larger of two; a geometric mean is what Bullet does.
            mixed = math.sqrt(both[0] * both[1]) if self.on(key) else 0.0
            found.append(max(mixed, 1e-5))
        slide, spin, roll = found
        keep = self.on("spinning_friction") or self.on("rolling_friction")
        return [slide, slide, spin if keep else 0.0, roll if keep else 0.0, roll if keep else 0.0]

    def _start(self) -> None:
        for name, record in self.records.items():
            for joint, position in record["start"].items():
                self.data.qpos[self._joint(name, joint).qposadr[0]] = position
        self.m.mj_forward(self.model, self.data)

    def _joint(self, name: str, joint: str) -> Any:
        return self.model.joint(f"{name}/{joint}")

    # -- running --------------------------------------------------------------

    def run(self) -> dict[str, Any]:
        steps = int(self.request["steps"])
        every = max(1, steps // SAMPLES)
        states, worst, touched = [self._state(0.0)], 0.0, False
        nearest = self._distances()
        for step in range(1, steps + 1):
            self.data.qfrc_applied[:] = 0.0
            self.data.xfrc_applied[:] = 0.0
            worst = max(worst, self._drive())
            self._motors(step * self.request["step"])
            self.m.mj_step(self.model, self.data)
            touched = touched or self._touched()
            if step % every == 0 or step == steps:
                states.append(self._state(step * self.request["step"]))
                nearest = [min(p) for p in zip(nearest, self._distances(), strict=True)]
        path = self.request["path"]
        length = path["waypoints"][-1]["at"] if path else 0.0
        return {
            "states": states,
            "path": {
                "progress": min(1.0, self.path_time / length) if length else 1.0,
                "worst_error": worst,
                "touched": touched,
            },
            "touching": self._touching(),
            "distances": nearest,
        }

    def _motors(self, at: float) -> None:
        """Joints under motors, trajectories and mimic: critically damped, force-limited."""
        trajectory = self.request["trajectory"]
        for name, record in self.records.items():
            wanted: dict[str, tuple[float, float]] = {}
            if self.on("motors"):
                wanted |= {j: (m["target"], m["force"]) for j, m in record["motors"].items()}
            if trajectory is not None and trajectory["body"] == name:
                for joint, way in trajectory["joints"].items():
                    place = min(at / trajectory["seconds"], 1.0) * (len(way["positions"]) - 1)
                    index = min(int(place), len(way["positions"]) - 2)
                    low, high = way["positions"][index : index + 2]
                    wanted[joint] = (low + (place - index) * (high - low), way["force"])
            for joint, (leader, multiplier, offset) in record["mimic"].items():
                now = float(self.data.qpos[self._joint(name, leader).qposadr[0]])
                force = record["follow_force"].get(joint, 1e3)
                wanted[joint] = (multiplier * now + offset, force)
            for joint, (target, force) in wanted.items():
                self._push(self._joint(name, joint), target, force)

    def _push(self, joint: Any, target: float, limit: float) -> None:
        """A spring that reaches its limit at :data:`GIVE`; its damper is in the model, where
        it is integrated implicitly and so keeps the stiff spring stable."""
        index = joint.dofadr[0]
        error = target - float(self.data.qpos[joint.qposadr[0]])
        force = limit / GIVE * error + float(self.data.qfrc_bias[index])
        self.data.qfrc_applied[index] = max(-limit, min(limit, force))

    def _drive(self) -> float:
        """Pull the driven asset along its path; it waits while the asset lags behind."""
        import numpy as np

        path = self.request["path"]
        if path is None:
            return 0.0
        record = self.records[path["body"]]
        body = self.model.body(f"{path['body']}/{record['links'][0]}").id
        target, turn = _on_path(path, self.path_time)
        error = float(np.linalg.norm(target - self.data.xpos[body]))
        if error <= path["guard"]:
            self.path_time = min(self.path_time + self.request["step"], path["waypoints"][-1]["at"])
            target, turn = _on_path(path, self.path_time)
        self.data.mocap_pos[0], self.data.mocap_quat[0] = target, turn
        return error

    # -- looking --------------------------------------------------------------

    def _name(self, geom: int) -> tuple[str, str]:
        asset, _, link = self.model.body(self.model.geom_bodyid[geom]).name.partition("/")
        return asset, link

    def _touching(self) -> list[list[str]]:
        found = set()
        for contact in self.data.contact[: self.data.ncon]:
            if contact.dist <= 0.0:
                pair = sorted((self._name(contact.geom[0]), self._name(contact.geom[1])))
                found.add((pair[0], pair[1]))
        return [[*a, *b] for a, b in sorted(found)]

    def _touched(self) -> bool:
        path = self.request["path"]
        if path is None:
            return False
        return any(
            contact.dist < 0.0
            and path["body"] in (self._name(contact.geom[0])[0], self._name(contact.geom[1])[0])
            for contact in self.data.contact[: self.data.ncon]
        )

    def _distances(self) -> list[float]:
        import numpy as np

        between, found = np.zeros(6), []
        for a, la, c, lc in self.request["between"]:
            ends = []
            for name in (f"{a}/{la}", f"{c}/{lc}"):
                body = self.model.body(name).id
                start = int(self.model.body_geomadr[body])
                ends.append(range(start, start + int(self.model.body_geomnum[body])))
            found.append(
                min(
                    self.m.mj_geomDistance(self.model, self.data, i, j, 10.0, between)
                    for i in ends[0]
                    for j in ends[1]
                )
            )
        return found

    def _state(self, at: float) -> dict[str, Any]:
        bases, joints = {}, {}
        for name, record in self.records.items():
            body = self.model.body(f"{name}/{record['links'][0]}").id
            w, x, y, z = (float(v) for v in self.data.xquat[body])
            bases[name] = [*(float(v) for v in self.data.xpos[body]), x, y, z, w]
            if record["start"]:
                joints[name] = {
                    j: float(self.data.qpos[self._joint(name, j).qposadr[0]])
                    for j in record["start"]
                }
        return {"time": at, "bases": bases, "joints": joints}

    def ask_configurations(self, asked: dict[str, Any]) -> dict[str, Any]:
        """Which planned pairs touch, configuration by configuration."""
        name, record = asked["body"], self.records[asked["body"]]
        touching = []
        for positions in asked["positions"]:
            for joint in record["start"]:
                self.data.qpos[self._joint(name, joint).qposadr[0]] = positions[joint]
            self.m.mj_forward(self.model, self.data)
            pairs = {tuple(sorted((p[1], p[3]))) for p in self._touching()}
            touching.append(sorted([a, c] for a, c in pairs))
        return {"configurations": touching}


def _on_path(path: dict[str, Any], at: float) -> tuple[Any, Any]:
    """Target position (3,) and quaternion (w, x, y, z)."""
    import numpy as np
    from scipy.spatial.transform import Rotation, Slerp

    before = path["start"]
    for point in path["waypoints"]:
        if at <= point["at"]:
            share = (at - before["at"]) / (point["at"] - before["at"])
            ends = np.asarray(before["position"]), np.asarray(point["position"])
            if before["quaternion"] == point["quaternion"]:
                x, y, z, w = point["quaternion"]
            else:
                turns = Rotation.from_quat([before["quaternion"], point["quaternion"]])
                x, y, z, w = Slerp([0.0, 1.0], turns)(share).as_quat()
            return ends[0] + share * (ends[1] - ends[0]), np.array([w, x, y, z])
        before = point
    x, y, z, w = before["quaternion"]
    return np.asarray(before["position"]), np.array([w, x, y, z])
