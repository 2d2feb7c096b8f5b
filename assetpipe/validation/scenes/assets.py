"""Assets as a scene sees them: links with shapes and mass, joints, where they are."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np
import numpy.typing as npt

from assetpipe.errors import ConfigError, unknown_name
from assetpipe.geometry.mesh import FloatArray, Mesh
from assetpipe.validation.contact.pairs import LinkBody
from assetpipe.validation.scenes.asset_spec import Base, Material, Pose

JointKind = Literal["fixed", "revolute", "continuous", "prismatic"]
RoundKind = Literal["sphere", "cylinder", "capsule"]


def matrix_of(xyz: Sequence[float], rpy: Sequence[float]) -> FloatArray:
    """(4, 4) matrix of a URDF origin: roll, pitch, yaw about fixed axes, radians."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a), math.sin(a)) for a in rpy)
    matrix = np.eye(4)
    matrix[:3, :3] = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    matrix[:3, 3] = xyz
    return matrix


def pose_matrix(pose: Pose) -> FloatArray:
    """(4, 4) matrix of a pose."""
    return matrix_of(pose.xyz, pose.rpy)


@dataclass(frozen=True)
class Inertial:
    """Mass (kg), centre of mass (3,) in the link's frame, inertia (3, 3) about it."""

    mass: float
    centre: FloatArray
    inertia: FloatArray

    @classmethod
    def uniform(cls, shapes: Sequence[Mesh], mass: float) -> Inertial:
        """Of a uniform solid; where shapes overlap, the overlap counts twice."""
        solids = [m.to_trimesh() for m in shapes]
        volumes = [abs(float(s.volume)) for s in solids]
        total = sum(volumes)
        if not total > 0.0:
            return cls(mass, np.zeros(3), np.eye(3) * 1e-6 * mass)
        parts = list(zip(solids, volumes, strict=True))
        centre = sum((np.asarray(s.center_mass) * v for s, v in parts), np.zeros(3)) / total
        inertia = np.zeros((3, 3))
        for solid, volume in parts:
            away = np.asarray(solid.center_mass) - centre
            shift = float(away @ away) * np.eye(3) - np.outer(away, away)
            inertia += np.asarray(solid.moment_inertia) + volume * shift
        return cls(mass, centre, inertia * (mass / total))


@dataclass(frozen=True)
class Round:
    """The true shape of a body that can roll, of which its mesh is a polyhedron.

    Attributes:
        kind: which.
        radius: metres.
    """

    kind: RoundKind
    radius: float


@dataclass(frozen=True, eq=False)
class SceneLink:
    """One rigid link.

    Attributes:
        name: link name.
        shapes: meshes in the link's frame, metres; each one becomes one convex hull in
            a physics engine, whether it is convex or not.
        certificate: metres by which they may reach beyond the original.
        inertial: ``None`` for a link without mass.
        round_shape: set for a body that can roll; engines get a sphere as a sphere.
        kind: ``hulls`` where every shape is convex.
    """

    name: str
    shapes: tuple[Mesh, ...]
    certificate: float = 0.0
    inertial: Inertial | None = None
    round_shape: Round | None = None
    kind: Literal["surface", "hulls"] = "surface"

    @cached_property
    def body(self) -> LinkBody:
        """The link for contact queries."""
        return LinkBody(self.name, self.shapes, self.certificate, self.kind)


@dataclass(frozen=True, eq=False)
class SceneJoint:
    """One joint; positions in radians or metres.

    Attributes:
        parent_from_joint: (4, 4) at position 0.
        axis: (3,) unit vector in the joint's frame.
        lower, upper: limits; infinite where there are none.
        velocity, effort: limits; infinite where there are none.
        damping: viscous, Nms or Ns/m.
        friction: Coulomb, Nm or N.
        mimic: (joint, multiplier, offset) that this one follows.
    """

    name: str
    kind: JointKind
    parent: str
    child: str
    parent_from_joint: FloatArray
    axis: FloatArray
    lower: float = -math.inf
    upper: float = math.inf
    velocity: float = math.inf
    effort: float = math.inf
    damping: float = 0.0
    friction: float = 0.0
    mimic: tuple[str, float, float] | None = None

    def moved(self, position: float) -> FloatArray:
        """(4, 4) parent from child at a position."""
        motion = np.eye(4)
        if self.kind == "prismatic":
            motion[:3, 3] = self.axis * position
        elif self.kind != "fixed":
            motion[:3, :3] = _about(self.axis, position)
        return self.parent_from_joint @ motion

    def moved_to(self, positions: FloatArray) -> FloatArray:
        """(n, 4, 4) parent from child at positions (n,)."""
        motion = np.broadcast_to(np.eye(4), (len(positions), 4, 4)).copy()
        if self.kind == "prismatic":
            motion[:, :3, 3] = positions[:, None] * self.axis
        elif self.kind != "fixed":
            cross = _cross(self.axis)
            sine, versine = np.sin(positions), 1.0 - np.cos(positions)
            motion[:, :3, :3] += sine[:, None, None] * cross
            motion[:, :3, :3] += versine[:, None, None] * (cross @ cross)
        return np.asarray(self.parent_from_joint @ motion)


def _cross(axis: FloatArray) -> FloatArray:
    x, y, z = axis
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def _about(axis: FloatArray, angle: float) -> FloatArray:
    """Rodrigues' rotation matrix."""
    cross = _cross(axis)
    turn: FloatArray = np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross
    return turn


@dataclass(frozen=True, eq=False)
class SceneAsset:
    """An asset placed in a scene.

    Attributes:
        name: as in the scene.
        links: the base first.
        joints: parents before children.
        world_from_base: (4, 4).
        base: ``fixed``, ``free`` or ``driven``.
        start: joint positions to start from; those not named are at home.
        moving: joints that may move.
        resistance: by moving joint, the force or torque that holds it.
        material: of all surfaces.
    """

    name: str
    links: tuple[SceneLink, ...]
    joints: tuple[SceneJoint, ...] = ()
    world_from_base: FloatArray = field(default_factory=lambda: np.eye(4))
    base: Base = "fixed"
    start: Mapping[str, float] = field(default_factory=dict)
    moving: tuple[str, ...] = ()
    resistance: Mapping[str, float] = field(default_factory=dict)
    material: Material = field(default_factory=Material)

    def __post_init__(self) -> None:
        for name in (*self.start, *self.moving):
            if name not in self.joint:
                where = f"asset '{self.name}': "
                raise ConfigError(where + unknown_name("joint", name, self.joint))
        for name, position in self.start.items():
            self.check_position(name, position)

    def check_position(self, name: str, position: float) -> None:
        """Whether a joint can be put somewhere.

        Raises:
            ConfigError: it follows another one, or its limits are elsewhere.
        """
        joint = self.joint[name]
        if joint.mimic is not None:
            raise ConfigError(
                f"joint '{name}' of '{self.name}' follows '{joint.mimic[0]}': set that one"
            )
        bounded = joint.lower <= joint.upper
        if bounded and not joint.lower - 1e-9 <= position <= joint.upper + 1e-9:
            unit = "m" if joint.kind == "prismatic" else "rad"
            raise ConfigError(
                f"joint '{name}' of '{self.name}' cannot be at {position:g} {unit}; its limits "
                f"are {joint.lower:g} to {joint.upper:g} {unit}"
            )

    @cached_property
    def link(self) -> Mapping[str, SceneLink]:
        """Links by name."""
        return {item.name: item for item in self.links}

    @cached_property
    def joint(self) -> Mapping[str, SceneJoint]:
        """Joints by name."""
        return {item.name: item for item in self.joints}

    @cached_property
    def joint_above(self) -> Mapping[str, SceneJoint]:
        """The joint that carries a link, by link name; the base has none."""
        return {item.child: item for item in self.joints}

    def chain(self, link: str) -> tuple[SceneJoint, ...]:
        """Joints from the base to a link, the nearest to the base first."""
        found: list[SceneJoint] = []
        while link in self.joint_above:
            found.append(self.joint_above[link])
            link = found[-1].parent
        return tuple(reversed(found))

    def moves_with(self, joint: SceneJoint) -> bool:
        """Whether a joint may move, itself or following another."""
        leader = joint.mimic[0] if joint.mimic else joint.name
        return joint.kind != "fixed" and (joint.name in self.moving or leader in self.moving)

    def positions(self, given: Mapping[str, float] | None = None) -> dict[str, float]:
        """Position of every joint: given ones, else the start, else home; mimic followed.

        Home is 0, or the nearest limit where 0 is out of range.
        """
        values: dict[str, float] = {}
        asked = {**self.start, **(given or {})}
        for joint in self.joints:
            if joint.kind == "fixed" or joint.mimic:
                continue
            home = min(max(0.0, joint.lower), joint.upper)
            values[joint.name] = float(asked.get(joint.name, home))
        for joint in self.joints:
            values.setdefault(joint.name, self._follow(joint, values))
        return values

    def _follow(self, joint: SceneJoint, values: Mapping[str, float]) -> float:
        scale, shift = 1.0, 0.0
        for _ in range(len(self.joints)):
            if joint.mimic is None:
                return scale * values.get(joint.name, 0.0) + shift
            leader, multiplier, offset = joint.mimic
            scale, shift = scale * multiplier, scale * offset + shift
            if leader not in self.joint:
                return shift
            joint = self.joint[leader]
        return shift

    def frames(
        self,
        positions: Mapping[str, float] | None = None,
        world_from_base: npt.ArrayLike | None = None,
    ) -> dict[str, FloatArray]:
        """World-from-link matrices (4, 4) of all links."""
        base = self.world_from_base if world_from_base is None else np.asarray(world_from_base)
        values = self.positions(positions)
        frames = {self.links[0].name: np.asarray(base, dtype=np.float64)}
        for joint in self.joints:
            frames[joint.child] = frames[joint.parent] @ joint.moved(values[joint.name])
        return frames

    def frames_of(self, configurations: Sequence[Mapping[str, float]]) -> dict[str, FloatArray]:
        """World-from-link matrices (n, 4, 4) of all links in many configurations."""
        values = [self.positions(given) for given in configurations]
        base = np.broadcast_to(self.world_from_base, (len(values), 4, 4))
        frames = {self.links[0].name: base}
        for joint in self.joints:
            at = np.array([v[joint.name] for v in values])
            frames[joint.child] = frames[joint.parent] @ joint.moved_to(at)
        return frames

    def configurations(self, count: int, seed: int) -> list[dict[str, float]]:
        """The start, then ``count`` seeded configurations, uniform within limits.

        Joints without limits turn through a whole circle, or slide a metre each way.
        """
        rng = np.random.default_rng(seed)
        drawn = [dict(self.start)]
        own = [j for j in self.joints if j.kind != "fixed" and j.mimic is None]
        for _ in range(count):
            values = {}
            for joint in own:
                reach = 1.0 if joint.kind == "prismatic" else math.pi
                low = joint.lower if math.isfinite(joint.lower) else -reach
                high = joint.upper if math.isfinite(joint.upper) else reach
                values[joint.name] = float(low + (high - low) * rng.random())
            drawn.append(values)
        return drawn
