"""Simulate a planned scene in PyBullet. Runs in the worker's process only.

What the plan switches off is switched off here explicitly: PyBullet's own habits (motors
on every joint, damping of 0.04, friction of 0.5, contacts kept up to 20 mm) would simulate
more than was planned. The 1 mm that Bullet puts around every hull cannot be switched off
for links of several hulls; the model's hulls are shrunk by it instead.
"""

from __future__ import annotations

import math
import time
from typing import Any

NO_MARGIN = 1e-5
"""Metres up to which contacts are kept where the plan has no contact margin; Bullet keeps
them up to 20 mm unless told otherwise."""
SAMPLES = 200
"""States recorded over a run."""


class _Body:
    """A loaded asset."""

    def __init__(self, b: Any, record: dict[str, Any], request: dict[str, Any]) -> None:
        self.b, self.record = b, record
        self.name: str = record["name"]
        continuous = request["effects"]["continuous_collision"]["on"]
        own = any(p[0] == p[2] == self.name for p in request["pairs"])
        flags = b.URDF_USE_INERTIA_FROM_FILE
        if own:
            flags |= b.URDF_USE_SELF_COLLISION
        swept = continuous and record["base"] != "driven"
        # Bullet moves only rigid bodies in maximal coordinates continuously, and of those
        # only convex ones; its URDF importer makes a compound even of a single hull.
        maximal = bool(swept and record["single"])
        self.id: int = -1
        if maximal and record["convex"] is not None:
            self.id = self._convex(record["convex"])
        else:
            self.id = b.loadURDF(
                record["urdf"],
                basePosition=record["position"],
                baseOrientation=record["quaternion"],
                useFixedBase=record["base"] == "fixed",
                useMaximalCoordinates=maximal,
                flags=flags,
            )
        self.link = {record["links"][0]: -1}
        self.joint: dict[str, int] = {}
        if not maximal:
            for i in range(b.getNumJoints(self.id)):
                info = b.getJointInfo(self.id, i)
                self.link[info[12].decode()] = i
                if info[2] != b.JOINT_FIXED:
                    self.joint[info[1].decode()] = i
        self._back = b.invertTransform(record["inertial_position"], record["inertial_quaternion"])

    def _convex(self, convex: dict[str, Any]) -> int:
        b, record = self.b, self.record
        if convex["ball"] is not None:
            shape = b.createCollisionShape(b.GEOM_SPHERE, radius=convex["ball"])
        else:
            shape = b.createCollisionShape(b.GEOM_MESH, fileName=convex["obj"])
        made = b.createMultiBody(
            0.0 if record["base"] == "fixed" else convex["mass"],
            shape,
            basePosition=record["position"],
            baseOrientation=record["quaternion"],
            useMaximalCoordinates=True,
        )
        if record["base"] != "fixed":
            # Without the mass beside it PyBullet makes the inertia of such a body NaN.
            b.changeDynamics(made, -1, mass=convex["mass"], localInertiaDiagonal=convex["inertia"])
        return int(made)

    def base_pose(self) -> list[float]:
        """Pose of the base link's frame: x, y, z and quaternion x, y, z, w."""
        at = self.b.getBasePositionAndOrientation(self.id)
        position, turn = self.b.multiplyTransforms(at[0], at[1], self._back[0], self._back[1])
        return [*position, *turn]

    def positions(self) -> dict[str, float]:
        """Joint positions."""
        return {n: self.b.getJointState(self.id, i)[0] for n, i in self.joint.items()}


def simulate(request: dict[str, Any]) -> dict[str, Any]:
    """Build the world, run it, and return what was recorded (see ``runners.dynamics``)."""
    import pybullet as b

    b.connect(b.DIRECT)
    started = time.process_time()
    try:
        bodies = {r["name"]: _Body(b, r, request) for r in request["bodies"]}
    except b.error as error:
        return {"loaded": False, "message": str(error)}
    world = _World(b, request, bodies)
    world.prepare()
    built = time.process_time()
    recorded = world.ask_configurations() if request["configurations"] is not None else world.run()
    ended = time.process_time()
    return {
        "loaded": True,
        "message": "",
        "build_seconds": built - started,
        "run_seconds": ended - built,
        **recorded,
    }


class _World:
    def __init__(self, b: Any, request: dict[str, Any], bodies: dict[str, _Body]) -> None:
        self.b, self.request, self.bodies = b, request, bodies
        self.step: float = request["step"]
        self.path_time = 0.0
        self.anchor: int | None = None

    def on(self, effect: str) -> bool:
        return bool(self.request["effects"][effect]["on"])

    def value(self, effect: str) -> float:
        return float(self.request["effects"][effect]["value"] or 0.0)

    # -- preparation ----------------------------------------------------------

    def prepare(self) -> None:
        b = self.b
        b.setPhysicsEngineParameter(
            fixedTimeStep=self.step,
            numSolverIterations=int(self.request["iterations"]),
            numSubSteps=0,
            deterministicOverlappingPairs=1,
            allowedCcdPenetration=0.0,
            contactBreakingThreshold=self.value("contact_margin")
            if self.on("contact_margin")
            else NO_MARGIN,
        )
        b.setGravity(0.0, 0.0, -self.value("gravity") if self.on("gravity") else 0.0)
        for body in self.bodies.values():
            self._surfaces(body)
            self._joints(body)
        self._filter()
        path = self.request["path"]
        if path is not None:
            self._anchor(self.bodies[path["body"]], path)

    def _surfaces(self, body: _Body) -> None:
        material = body.record["material"]
        friction = self._coefficient(material, "friction") if self.on("friction") else 0.0
        rooted = math.sqrt(friction)
        # Bullet multiplies two bodies' coefficients, and mixes rolling with friction.
        mixed = 2.0 * max(rooted, 1e-6)
        rolling = spinning = bounce = 0.0
        if self.on("rolling_friction"):
            rolling = self._coefficient(material, "rolling_friction") / mixed
        if self.on("spinning_friction"):
            spinning = self._coefficient(material, "spinning_friction") / mixed
        if self.on("restitution"):
            bounce = math.sqrt(self._coefficient(material, "restitution"))
        for index in body.link.values():
            settings = {
                "lateralFriction": rooted,
                "rollingFriction": rolling,
                "spinningFriction": spinning,
                "restitution": bounce,
                "linearDamping": 0.0,
                "angularDamping": 0.0,
            }
            if self.on("continuous_collision") and body.record["base"] != "fixed":
                settings["ccdSweptSphereRadius"] = self.value("continuous_collision")
            self.b.changeDynamics(body.id, index, **settings)
        # Bodies asleep would hide a drift; nobody sleeps.
        self.b.changeDynamics(body.id, -1, activationState=2)

    def _coefficient(self, material: dict[str, Any], name: str) -> float:
        stated = material.get(name)
        return float(stated) if stated is not None else self.value(name)

    def _joints(self, body: _Body) -> None:
        record, b = body.record, self.b
        for name, index in body.joint.items():
            b.resetJointState(body.id, index, record["start"][name])
            damping = record["damping"].get(name, 0.0) if self.on("damping") else 0.0
            b.changeDynamics(body.id, index, jointDamping=damping)
            # PyBullet brakes every joint unless told otherwise.
            b.setJointMotorControl2(
                body.id,
                index,
                b.VELOCITY_CONTROL,
                targetVelocity=0.0,
                force=record["resistance"].get(name, 0.0),
            )
        self._motors(body)

    def _motors(self, body: _Body) -> None:
        if not self.on("motors"):
            return
        for name, motor in body.record["motors"].items():
            index = body.joint[name]
            self.b.setJointMotorControl2(
                body.id,
                index,
                self.b.POSITION_CONTROL,
                targetPosition=motor["target"],
                targetVelocity=0.0,
                force=motor["force"],
                maxVelocity=motor["velocity"],
                positionGain=0.2,
                velocityGain=1.0,
            )

    def _filter(self) -> None:
        """Let only planned pairs meet."""
        allowed = {(p[0], p[1], p[2], p[3]) for p in self.request["pairs"]}
        bodies = list(self.bodies.values())
        for i, first in enumerate(bodies):
            for second in bodies[i:]:
                for la, ia in first.link.items():
                    for lb, ib in second.link.items():
                        if first is second and ia >= ib:
                            continue
                        names = (first.name, la, second.name, lb)
                        swapped = (second.name, lb, first.name, la)
                        yes = names in allowed or swapped in allowed
                        self.b.setCollisionFilterPair(first.id, second.id, ia, ib, int(yes))

    def _anchor(self, body: _Body, path: dict[str, Any]) -> None:
        record = body.record
        self.anchor = self.b.createConstraint(
            body.id,
            -1,
            -1,
            -1,
            self.b.JOINT_FIXED,
            [0, 0, 0],
            [0, 0, 0],
            [0, 0, 0],
            childFrameOrientation=[0, 0, 0, 1],
        )
        position, turn = self.b.multiplyTransforms(
            record["position"],
            record["quaternion"],
            record["inertial_position"],
            record["inertial_quaternion"],
        )
        self.b.changeConstraint(self.anchor, position, turn, maxForce=path["force"])

    # -- running --------------------------------------------------------------

    def run(self) -> dict[str, Any]:
        steps = int(self.request["steps"])
        every = max(1, steps // SAMPLES)
        states = [self._state(0.0)]
        nearest = self._nearest([])
        error = worst = 0.0
        touched = False
        for step in range(1, steps + 1):
            error = self._drive()
            self._trace(step * self.step)
            self._follow()
            self.b.stepSimulation()
            worst = max(worst, error)
            if self.anchor is not None and not touched:
                touched = self._touched()
            if step % every == 0 or step == steps:
                states.append(self._state(step * self.step))
                nearest = self._nearest(nearest)
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

    def _trace(self, at: float) -> None:
        """Joints on a trajectory are driven to where they should be at a time."""
        trajectory = self.request["trajectory"]
        if trajectory is None:
            return
        body = self.bodies[trajectory["body"]]
        for name, joint in trajectory["joints"].items():
            values = joint["positions"]
            place = min(at / trajectory["seconds"], 1.0) * (len(values) - 1)
            index = min(int(place), len(values) - 2)
            target = values[index] + (place - index) * (values[index + 1] - values[index])
            self.b.setJointMotorControl2(
                body.id,
                body.joint[name],
                self.b.POSITION_CONTROL,
                targetPosition=target,
                force=joint["force"],
                positionGain=0.5,
                velocityGain=1.0,
            )

    def _nearest(self, before: list[float]) -> list[float]:
        now = self._distances()
        return [min(a, b) for a, b in zip(before, now, strict=True)] if before else now

    def _drive(self) -> float:
        """Advance the driven asset's target; it waits while the asset lags behind."""
        path = self.request["path"]
        if path is None or self.anchor is None:
            return 0.0
        body = self.bodies[path["body"]]
        target = _on_path(self.b, path, self.path_time)
        now = body.base_pose()
        error = math.dist(target[0], now[:3])
        if error <= path["guard"]:
            self.path_time = min(self.path_time + self.step, path["waypoints"][-1]["at"])
            target = _on_path(self.b, path, self.path_time)
        record = body.record
        position, turn = self.b.multiplyTransforms(
            target[0], target[1], record["inertial_position"], record["inertial_quaternion"]
        )
        self.b.changeConstraint(self.anchor, position, turn, maxForce=path["force"])
        return error

    def _follow(self) -> None:
        """Joints that mimic another one follow where that one is."""
        for body in self.bodies.values():
            for name, (leader, multiplier, offset) in body.record["mimic"].items():
                if name not in body.joint or leader not in body.joint:
                    continue
                at = self.b.getJointState(body.id, body.joint[leader])[0]
                self.b.setJointMotorControl2(
                    body.id,
                    body.joint[name],
                    self.b.POSITION_CONTROL,
                    targetPosition=multiplier * at + offset,
                    force=body.record["follow_force"].get(name, 1e3),
                    positionGain=0.5,
                    velocityGain=1.0,
                )

    def _touched(self) -> bool:
        body = self.bodies[self.request["path"]["body"]]
        return any(point[9] > 1e-6 for point in self.b.getContactPoints(bodyA=body.id))

    def _state(self, at: float) -> dict[str, Any]:
        return {
            "time": at,
            "bases": {n: x.base_pose() for n, x in self.bodies.items()},
            "joints": {n: x.positions() for n, x in self.bodies.items() if x.joint},
        }

    def _touching(self) -> list[list[str]]:
        found = set()
        for point in self.b.getContactPoints():
            if point[8] <= 0.0:
                found.add((self._name(point[1], point[3]), self._name(point[2], point[4])))
        return [[*a, *b] for a, b in sorted(tuple(sorted(pair)) for pair in found)]

    def _name(self, body_id: int, index: int) -> tuple[str, str]:
        for name, body in self.bodies.items():
            if body.id == body_id:
                return name, next(n for n, i in body.link.items() if i == index)
        return "", ""

    def _distances(self) -> list[float]:
        found = []
        for a, la, c, lc in self.request["between"]:
            first, second = self.bodies[a], self.bodies[c]
            points = self.b.getClosestPoints(
                first.id, second.id, 10.0, first.link[la], second.link[lc]
            )
            found.append(min((point[8] for point in points), default=10.0))
        return found

    # -- configurations -------------------------------------------------------

    def ask_configurations(self) -> dict[str, Any]:
        """Which planned pairs touch, configuration by configuration, each for one step."""
        asked = self.request["configurations"]
        body = self.bodies[asked["body"]]
        touching = []
        for positions in asked["positions"]:
            for name, index in body.joint.items():
                self.b.resetJointState(body.id, index, positions[name])
            self.b.stepSimulation()
            pairs = {
                tuple(sorted((self._name(p[1], p[3])[1], self._name(p[2], p[4])[1])))
                for p in self.b.getContactPoints(bodyA=body.id, bodyB=body.id)
                if p[8] <= 0.0
            }
            touching.append(sorted([a, c] for a, c in pairs))
        return {"configurations": touching}


def _on_path(b: Any, path: dict[str, Any], at: float) -> tuple[Any, Any]:
    before = path["start"]
    for point in path["waypoints"]:
        if at <= point["at"]:
            share = (at - before["at"]) / (point["at"] - before["at"])
            position = [
                p + share * (q - p)
                for p, q in zip(before["position"], point["position"], strict=True)
            ]
            turn = b.getQuaternionSlerp(before["quaternion"], point["quaternion"], share)
            return position, turn
        before = point
    return before["position"], before["quaternion"]
