"""What may move, how fast, and where it can get: bounds the planner reasons with."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from assetpipe.errors import ConfigError, unknown_name
from assetpipe.geometry.mesh import FloatArray
from assetpipe.validation.effects.plan import Ref
from assetpipe.validation.profiles import insphere_radius
from assetpipe.validation.scenes.assets import SceneAsset, SceneJoint
from assetpipe.validation.scenes.schema import Scene
from assetpipe.validation.shape_key import ByContent

REST = 1.0
"""Seconds that a scene lasts when neither it nor its drive says."""

SAG = 0.01
"""Metres that a motor may give way where the scene states no limit."""


@dataclass(frozen=True, eq=False)
class Region:
    """An axis-aligned box (3,), (3,) in the world that a link never leaves, metres."""

    low: FloatArray
    high: FloatArray

    def meets(self, other: Region) -> bool:
        """Whether two regions have a point in common."""
        return bool((self.low <= other.high).all() and (other.low <= self.high).all())

    def grown(self, by: float) -> Region:
        """Larger by a length on every side."""
        return Region(self.low - by, self.high + by)


@dataclass(frozen=True, eq=False)
class Motion:
    """A scene's assets in motion: bounds, no simulation.

    Attributes:
        scene: what is asked.
        assets: by name.
        held: all joints are simulated, those that do not move being held by motors.
    """

    scene: Scene
    assets: Mapping[str, SceneAsset]
    held: bool = False

    @cached_property
    def seconds(self) -> float:
        """How long the scene lasts."""
        drive = self.scene.drive
        if self.scene.seconds is not None:
            return self.scene.seconds
        ends = [0.0]
        if drive.path is not None:
            ends.append(drive.path.waypoints[-1].at)
        if drive.trajectory is not None:
            ends.append(drive.trajectory.seconds)
        return max(ends) or REST

    def active(self, asset: SceneAsset, joint: SceneJoint) -> bool:
        """Whether a joint is simulated."""
        return joint.kind != "fixed" and (self.held or asset.moves_with(joint))

    def moving_joints(self, asset: SceneAsset, link: str) -> tuple[SceneJoint, ...]:
        """Simulated joints between the base and a link."""
        return tuple(j for j in asset.chain(link) if self.active(asset, j))

    def moves(self, ref: Ref) -> bool:
        """Whether a link may move in the world."""
        asset = self.assets[ref[0]]
        return asset.base != "fixed" or bool(self.moving_joints(asset, ref[1]))

    def turns(self, ref: Ref) -> bool:
        """Whether a given motion (path or trajectory) may turn a link."""
        asset = self.assets[ref[0]]
        path = self.scene.drive.path
        if path is not None and path.asset == asset.name:
            return any(any(w.rpy) for w in path.waypoints)
        return any(j.kind != "prismatic" for j in self.moving_joints(asset, ref[1]))

    def together(self, a: Ref, b: Ref) -> bool:
        """Whether two links cannot move relative to each other."""
        if a[0] != b[0]:
            return not (self.moves(a) or self.moves(b))
        asset = self.assets[a[0]]
        return {j.name for j in self.moving_joints(asset, a[1])} == {
            j.name for j in self.moving_joints(asset, b[1])
        }

    # -- speeds ---------------------------------------------------------------

    @cached_property
    def path_speed(self) -> float:
        """Largest speed of any point of the asset on the path, m/s."""
        path = self.scene.drive.path
        if path is None:
            return 0.0
        radius = max((self.reach(path.asset, n) for n in self.assets[path.asset].link), default=0)
        speed, before, turned, since = 0.0, np.zeros(3), np.zeros(3), 0.0
        for point in path.waypoints:
            length = float(np.linalg.norm(np.asarray(point.xyz) - before))
            # The sum of angle differences bounds the angle of the rotation between.
            angle = float(np.abs(np.asarray(point.rpy) - turned).sum())
            speed = max(speed, (length + angle * radius) / (point.at - since))
            before, turned, since = np.asarray(point.xyz), np.asarray(point.rpy), point.at
        return speed

    def joint_speed(self, asset: SceneAsset, joint: SceneJoint) -> float:
        """Largest speed of a simulated joint, rad/s or m/s."""
        trajectory = self.scene.drive.trajectory
        if joint.mimic is not None and joint.mimic[0] in asset.joint:
            leader, multiplier, _ = joint.mimic
            return abs(multiplier) * self.joint_speed(asset, asset.joint[leader])
        if trajectory is not None and trajectory.asset == asset.name:
            values = trajectory.joints.get(joint.name)
            if values is None:
                return 0.0
            return float(np.abs(np.diff(values)).max()) * (len(values) - 1) / trajectory.seconds
        motors = self.scene.drive.motors.get(asset.name)
        way = 0.0
        if motors is not None and joint.name in motors.targets:
            way = abs(motors.targets[joint.name] - asset.positions()[joint.name])
        elif joint.name in asset.moving:
            span = joint.upper - joint.lower
            way = span if math.isfinite(span) else math.pi
        # A motor that has the whole time will hardly need more than twice the mean speed.
        return min(joint.velocity, 4.0 * way / self.seconds)

    def excursion(self, asset: SceneAsset, joint: SceneJoint) -> float | None:
        """How far a joint leaves its start, rad or m; ``None`` where nothing tells.

        Motors and trajectories tell; a joint that contact or gravity moves does not.
        """
        if joint.mimic is not None and joint.mimic[0] in asset.joint:
            leader, multiplier, _ = joint.mimic
            way = self.excursion(asset, asset.joint[leader])
            return None if way is None else abs(multiplier) * way
        start = asset.positions()[joint.name]
        trajectory = self.scene.drive.trajectory
        if trajectory is not None and trajectory.asset == asset.name:
            return max(abs(v - start) for v in trajectory.joints.get(joint.name, (start,)))
        motors = self.scene.drive.motors.get(asset.name)
        if motors is not None and joint.name in motors.targets:
            return abs(motors.targets[joint.name] - start)
        return 0.0 if self.held and joint.name not in asset.moving else None

    def reach(self, asset_name: str, link: str) -> float:
        """Radius of a ball around the base's origin that a link never leaves, metres."""
        asset = self.assets[asset_name]
        total = self._radius(asset, link)
        for joint in asset.chain(link):
            total += float(np.linalg.norm(joint.parent_from_joint[:3, 3]))
            total += self._slide(asset, joint)
        return total

    def _radius(self, asset: SceneAsset, link: str) -> float:
        vertices = asset.link[link].body.vertices
        return float(np.linalg.norm(vertices, axis=1).max()) if len(vertices) else 0.0

    def _slide(self, asset: SceneAsset, joint: SceneJoint) -> float:
        if joint.kind != "prismatic":
            return 0.0
        if not self.active(asset, joint):
            return abs(asset.positions()[joint.name])
        ends = [abs(v) for v in (joint.lower, joint.upper) if math.isfinite(v)]
        return max(ends) if len(ends) == 2 else 1.0

    def speed(self, ref: Ref) -> float:
        """Upper estimate of the speed of any point of a link, m/s."""
        asset = self.assets[ref[0]]
        path = self.scene.drive.path
        total = self.path_speed if path is not None and path.asset == asset.name else 0.0
        if asset.base == "free":
            total += self.fall_speed(asset) + self.path_speed
        moving = self.moving_joints(asset, ref[1])
        for joint in moving:
            lever = 1.0 if joint.kind == "prismatic" else self._lever(asset, joint, ref[1])
            total += self.joint_speed(asset, joint) * lever
        return total

    def _lever(self, asset: SceneAsset, joint: SceneJoint, link: str) -> float:
        """Radius around a joint that a link behind it never leaves."""
        chain = asset.chain(link)
        behind = chain[chain.index(joint) + 1 :]
        return (
            self._radius(asset, link)
            + sum(float(np.linalg.norm(j.parent_from_joint[:3, 3])) for j in behind)
            + sum(self._slide(asset, j) for j in behind)
        )

    def fall_speed(self, asset: SceneAsset) -> float:
        """Speed at which a free asset can arrive somewhere under gravity, m/s."""
        gravity = self.scene.drive.gravity
        height = self.drop(asset)
        fallen = gravity * self.seconds
        return fallen if height is None else min(fallen, math.sqrt(2.0 * gravity * height))

    def drop(self, asset: SceneAsset) -> float | None:
        """Metres from a free asset down to what lies below it; ``None`` for the void."""
        own = self.start_region(asset.name)
        gaps = []
        for name in self.assets:
            other = self.start_region(name)
            beside = (own.low[:2] >= other.high[:2]).any() or (other.low[:2] >= own.high[:2]).any()
            if name == asset.name or beside or other.low[2] >= own.low[2] + 1e-9:
                continue
            gap = float(own.low[2] - other.high[2])
            # Inside the other's box (a tray, a slot) it may fall to that box's bottom.
            gaps.append(gap if gap >= -1e-6 else float(own.low[2] - other.low[2]))
        return max(0.0, min(gaps)) if gaps else None

    # -- regions --------------------------------------------------------------

    def start_region(self, name: str) -> Region:
        """The box around an asset where it starts."""
        asset = self.assets[name]
        frames = asset.frames()
        points = [
            item.body.vertices @ frames[item.name][:3, :3].T + frames[item.name][:3, 3]
            for item in asset.links
            if item.shapes
        ]
        if not points:
            at = asset.world_from_base[:3, 3]
            return Region(at, at)
        every = np.vstack(points)
        return Region(every.min(axis=0), every.max(axis=0))

    def region(self, ref: Ref) -> Region | None:
        """A box that a link never leaves; ``None`` for a link without shapes."""
        asset = self.assets[ref[0]]
        link = asset.link[ref[1]]
        if not link.shapes:
            return None
        if asset.base == "free":
            way = self.speed(ref) * self.seconds
            return self.start_region(ref[0]).grown(way)
        path = self.scene.drive.path
        frames = asset.frames()
        if path is not None and path.asset == asset.name:
            radius = self.reach(asset.name, link.name)
            base = asset.world_from_base
            stops = [base[:3, 3]] + [
                base[:3, :3] @ np.asarray(w.xyz) + base[:3, 3] for w in path.waypoints
            ]
            return Region(np.min(stops, axis=0) - radius, np.max(stops, axis=0) + radius)
        moving = self.moving_joints(asset, link.name)
        points = link.body.vertices @ frames[link.name][:3, :3].T + frames[link.name][:3, 3]
        if not moving:
            return Region(points.min(axis=0), points.max(axis=0))
        if len(moving) == 1 and moving[0].kind == "prismatic":
            return self._slid(asset, moving[0], points, frames)
        ways = [(j, self.excursion(asset, j)) for j in moving]
        told = [
            way * (1.0 if j.kind == "prismatic" else self._lever(asset, j, link.name))
            for j, way in ways
            if way is not None
        ]
        still = Region(points.min(axis=0), points.max(axis=0))
        if len(told) == len(ways) and sum(told) < self.reach(asset.name, link.name):
            # A motor gives way under load before it is back: as much as decides the answer.
            return still.grown(sum(told) + (self.scene.limit or SAG))
        first = moving[0]
        origin = (frames[first.parent] @ first.parent_from_joint)[:3, 3]
        radius = self._lever(asset, first, link.name) + self._slide(asset, first)
        return Region(origin - radius, origin + radius)

    def _slid(
        self,
        asset: SceneAsset,
        joint: SceneJoint,
        points: FloatArray,
        frames: Mapping[str, FloatArray],
    ) -> Region:
        now = asset.positions()[joint.name]
        ends = [
            e if math.isfinite(e) else now + s for e, s in ((joint.lower, -1), (joint.upper, 1))
        ]
        along = (frames[joint.parent] @ joint.parent_from_joint)[:3, :3] @ joint.axis
        boxes = [points + along * (end - now) for end in ends]
        every = np.vstack(boxes)
        return Region(every.min(axis=0), every.max(axis=0))

    # -- shapes ---------------------------------------------------------------

    def thinnest(self, refs: set[Ref]) -> tuple[float, Ref] | None:
        """The least in-sphere diameter among the hulls of some links, and whose it is.

        A lower bound of the least width: what moves less than that in a step cannot
        pass through between two steps.
        """
        found: list[tuple[float, Ref]] = []
        for ref in sorted(refs):
            for shape in self.assets[ref[0]].link[ref[1]].shapes:
                found.append((2.0 * _radius(ByContent(shape)), ref))
        return min(found) if found else None

    def parts(self, reference: str) -> tuple[Ref, ...]:
        """Links meant by ``asset`` or ``asset/link``.

        Raises:
            ConfigError: there is no such link.
        """
        name, _, link = reference.partition("/")
        asset = self.assets[name]
        if not link:
            return tuple((name, item.name) for item in asset.links if item.shapes)
        if link not in asset.link:
            raise ConfigError(f"asset '{name}': " + unknown_name("link", link, asset.link))
        return ((name, link),)


@lru_cache(maxsize=4096)
def _radius(shape: ByContent) -> float:
    """In-sphere radius; plans of one scene ask for the same hulls again and again."""
    return insphere_radius(shape.mesh)
