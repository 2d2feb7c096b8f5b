"""Worker: hold a robot at home in PyBullet and watch. Runs in its own process."""

from __future__ import annotations

import math
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

MOTOR_FORCE = 1e3
"""Newtons or newton metres of a motor whose limit the URDF does not state."""


def settle(request: dict[str, Any]) -> dict[str, Any]:
    """Load, hold, step, and tell; see ``settle``."""
    import pybullet as b

    b.connect(b.DIRECT)
    flags = b.URDF_USE_INERTIA_FROM_FILE | b.URDF_USE_SELF_COLLISION
    try:
        body = b.loadURDF(request["urdf"], useFixedBase=request["base"] == "fixed", flags=flags)
    except b.error as error:
        return {"loaded": False, "finite": False, "message": str(error)}
    robot = _Robot(b, body)
    b.setGravity(0.0, 0.0, -GRAVITY)
    b.setPhysicsEngineParameter(
        fixedTimeStep=request["step"], numSubSteps=0, deterministicOverlappingPairs=1
    )
    robot.hold(request["home"])
    for first, second in request["excluded"]:
        if first in robot.link and second in robot.link:
            b.setCollisionFilterPair(body, body, robot.link[first], robot.link[second], 0)
    size, lowest = robot.box()
    if request["base"] == "free":
        at, turn = b.getBasePositionAndOrientation(body)
        b.resetBasePositionAndOrientation(body, (at[0], at[1], at[2] + CLEARANCE - lowest), turn)
        plane = b.createMultiBody(0.0, b.createCollisionShape(b.GEOM_PLANE))
        b.changeDynamics(plane, -1, lateralFriction=FLOOR_FRICTION)
        for index in robot.link.values():
            b.changeDynamics(body, index, lateralFriction=FLOOR_FRICTION)
    b.changeDynamics(body, -1, activationState=2)  # asleep it could not drift
    states = [robot.look(0.0)]
    spent = 0.0
    between = every(request["step"])
    for number in range(1, request["steps"] + 1):
        began = time.process_time()
        b.stepSimulation()
        spent += time.process_time() - began
        if number % between == 0 or number == request["steps"]:
            states.append(robot.look(number * request["step"]))
            if not states[-1].finite:
                break
    return summary(states, mass=robot.mass, size=size, sag=robot.sag(), cpu_seconds=spent)


class _Robot:
    def __init__(self, b: Any, body: int) -> None:
        self.b, self.body = b, body
        self.link = {b.getBodyInfo(body)[0].decode(): -1}
        self.joint: dict[str, int] = {}
        self.home: dict[int, float] = {}
        for index in range(b.getNumJoints(body)):
            info = b.getJointInfo(body, index)
            self.link[info[12].decode()] = index
            if info[2] in (b.JOINT_REVOLUTE, b.JOINT_PRISMATIC):
                self.joint[info[1].decode()] = index
        told = {index: b.getDynamicsInfo(body, index) for index in self.link.values()}
        self.inertia = {index: (info[0], info[2]) for index, info in told.items()}
        self.mass = sum(mass for mass, _ in self.inertia.values())

    def hold(self, home: dict[str, float]) -> None:
        """Put every joint at home and hold it there by a motor."""
        for name, index in self.joint.items():
            self.home[index] = float(home.get(name, 0.0))
            self.b.resetJointState(self.body, index, self.home[index])
            limit = self.b.getJointInfo(self.body, index)[10]
            self.b.setJointMotorControl2(
                self.body,
                index,
                self.b.POSITION_CONTROL,
                targetPosition=self.home[index],
                force=limit if limit > 0.0 else MOTOR_FORCE,
                positionGain=0.2,
                velocityGain=1.0,
            )

    def box(self) -> tuple[float, float]:
        """Diagonal of the robot's box, and its lowest height, metres."""
        boxes = [self.b.getAABB(self.body, index) for index in self.link.values()]
        low = [min(box[0][axis] for box in boxes) for axis in range(3)]
        high = [max(box[1][axis] for box in boxes) for axis in range(3)]
        return math.dist(low, high), low[2]

    def sag(self) -> float:
        """How far the farthest joint is from home."""
        places = {i: self.b.getJointState(self.body, i)[0] for i in self.home}
        return max((abs(places[i] - at) for i, at in self.home.items()), default=0.0)

    def look(self, at: float) -> Snapshot:
        """Energy, speeds and places now."""
        energy, speed, spin, places = 0.0, 0.0, 0.0, []
        for index, (mass, inertia) in self.inertia.items():
            if index < 0:
                place, turn = self.b.getBasePositionAndOrientation(self.body)
                linear, angular = self.b.getBaseVelocity(self.body)
            else:
                state = self.b.getLinkState(
                    self.body, index, computeLinkVelocity=1, computeForwardKinematics=1
                )
                place, turn, linear, angular = state[0], state[1], state[6], state[7]
            back = self.b.invertTransform((0, 0, 0), turn)[1]
            own = self.b.rotateVector(back, angular)
            energy += 0.5 * mass * sum(v * v for v in linear) + mass * GRAVITY * place[2]
            energy += 0.5 * sum(i * w * w for i, w in zip(inertia, own, strict=True))
            speed = max(speed, math.hypot(*linear))
            spin = max(spin, math.hypot(*angular))
            places.append((place[0], place[1], place[2]))
        return Snapshot(at, energy, speed, spin, tuple(places))
