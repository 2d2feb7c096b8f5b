"""Which physical effects a dynamic scene needs, each decided by numbers."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from assetpipe.validation.effects.motion import Motion
from assetpipe.validation.effects.plan import Effect, Ref
from assetpipe.validation.scenes.asset_spec import Material
from assetpipe.validation.scenes.assets import SceneAsset, SceneJoint
from assetpipe.validation.scenes.schema import EffectName

DEFAULT_FRICTION = 0.5
"""Coulomb coefficient where a scene needs friction and states none."""

MARGIN = 5e-3
"""Metres up to which contacts are looked for at least, where bodies rest on each other."""


@dataclass(frozen=True, eq=False)
class Physics:
    """A dynamic scene's facts, computed once and used by every rule."""

    motion: Motion
    pairs: tuple[tuple[Ref, Ref], ...]

    @cached_property
    def touching(self) -> set[Ref]:
        """Links in any pair."""
        return {ref for pair in self.pairs for ref in pair}

    @cached_property
    def free(self) -> tuple[SceneAsset, ...]:
        """Assets whose base is free."""
        return tuple(a for a in self.motion.assets.values() if a.base == "free")

    @cached_property
    def joints(self) -> tuple[tuple[SceneAsset, SceneJoint], ...]:
        """Joints that are simulated."""
        return tuple(
            (a, j)
            for a in self.motion.assets.values()
            for j in a.joints
            if self.motion.active(a, j)
        )

    @cached_property
    def limit(self) -> float:
        """Metres (or radians) that decide the answer; a millimetre where none is stated."""
        return self.motion.scene.limit or 1e-3

    @cached_property
    def speed(self) -> float:
        """Largest speed in the scene, m/s."""
        refs = {r for r in self.touching if self.motion.moves(r)}
        return max((self.motion.speed(r) for r in refs), default=0.0)

    @cached_property
    def thinnest(self) -> tuple[float, Ref] | None:
        """The least in-sphere diameter of what may touch."""
        return self.motion.thinnest(self.touching)

    def materials(self) -> dict[str, Material]:
        """Material by asset, of assets that may touch."""
        names = {ref[0] for ref in self.touching}
        return {n: a.material for n, a in self.motion.assets.items() if n in names}

    def driven_by_motor(self, asset: SceneAsset, joint: SceneJoint) -> bool:
        """Whether a motor has a target for a joint, itself or through mimic."""
        motors = self.motion.scene.drive.motors.get(asset.name)
        leader = joint.mimic[0] if joint.mimic else joint.name
        return motors is not None and leader in motors.targets


def decide(name: EffectName, physics: Physics, step: float, travel: float) -> Effect:
    """Decide one effect.

    Args:
        name: which.
        physics: the scene's facts.
        step: seconds a step.
        travel: metres that the fastest point moves in a step.
    """
    if name == "continuous_collision":
        return _continuous_collision(physics, step, travel)
    if name == "contact_margin":
        return _contact_margin(physics, step)
    return _RULES[name](physics)


def _on(name: EffectName, reason: str, value: float | None = None) -> Effect:
    return Effect(name, "on", reason, value)


def _off(name: EffectName, reason: str, value: float | None = None) -> Effect:
    return Effect(name, "off", reason, value)


def _gravity(p: Physics) -> Effect:
    g = p.motion.scene.drive.gravity
    standard = g or 9.81
    if not g:
        return _off("gravity", "the scene has none", standard)
    if p.free:
        return _on("gravity", f"'{p.free[0].name}' is free to fall", g)
    for asset, joint in p.joints:
        if _worked_by_gravity(asset, joint):
            return _on("gravity", f"it works on joint '{joint.name}' of '{asset.name}'", g)
    return _off("gravity", "nothing free: every moving joint runs across gravity", standard)


def _worked_by_gravity(asset: SceneAsset, joint: SceneJoint) -> bool:
    """Whether gravity can push a joint where it starts."""
    frames = asset.frames()
    axis = (frames[joint.parent] @ joint.parent_from_joint)[:3, :3] @ joint.axis
    if joint.kind == "prismatic":
        return abs(float(axis[2])) > 1e-6
    return float(np.linalg.norm(axis[:2])) > 1e-6


def _friction(p: Physics) -> Effect:
    stated = {n: m.friction for n, m in p.materials().items() if m.friction is not None}
    value = max(stated.values(), default=DEFAULT_FRICTION)
    if not p.pairs:
        return _off("friction", "nothing touches", value)
    if stated and not any(stated.values()):
        return _off("friction", "every stated coefficient is 0", value)
    question = p.motion.scene.question
    if question in ("settle", "hold") and p.free:
        what = f"what rests on or between others {question}s by friction"
        return _on("friction", what, value)
    if stated:
        name = next(n for n, v in stated.items() if v)
        return _on("friction", f"'{name}' states a coefficient", value)
    return _off("friction", "no surface states it, and the motion is pushed, not dragged", value)


def _stated(p: Physics, key: str) -> dict[str, float]:
    found = {n: getattr(m, key) for n, m in p.materials().items()}
    return {n: v for n, v in found.items() if v}


def _rolling(p: Physics) -> Effect:
    stated = _stated(p, "rolling_friction")
    value = max(stated.values(), default=1e-3)
    rollers = [r for r in sorted(p.touching) if _is_round(p, r) and p.motion.moves(r)]
    if not stated:
        return _off("rolling_friction", "no surface states it", value)
    if not rollers:
        return _off("rolling_friction", "nothing round moves", value)
    return _on("rolling_friction", f"'{rollers[0][0]}' can roll", value)


def _spinning(p: Physics) -> Effect:
    stated = _stated(p, "spinning_friction")
    value = max(stated.values(), default=1e-3)
    if not stated:
        return _off("spinning_friction", "no surface states it", value)
    if not p.free:
        return _off("spinning_friction", "no body is free to spin on a contact", value)
    return _on("spinning_friction", f"'{p.free[0].name}' is free to spin", value)


def _is_round(p: Physics, ref: Ref) -> bool:
    return p.motion.assets[ref[0]].link[ref[1]].round_shape is not None


def _restitution(p: Physics) -> Effect:
    stated = _stated(p, "restitution")
    value = max(stated.values(), default=0.0)
    if not stated:
        return _off("restitution", "no surface states it", value)
    g = p.motion.scene.drive.gravity
    impact = p.speed
    rebound = (value * impact) ** 2 / (2.0 * g) if g else value * impact * p.motion.seconds
    if rebound < 0.1 * p.limit:
        said = f"a rebound of {rebound * 1000:.2g} mm is below a tenth of the limit"
        return _off("restitution", said, value)
    said = f"an impact at {impact:.2g} m/s rebounds {rebound * 1000:.3g} mm"
    return _on("restitution", said, value)


def _joint_limits(p: Physics) -> Effect:
    if not p.joints:
        return _off("joint_limits", "no joint moves")
    for asset, joint in p.joints:
        if not (math.isfinite(joint.lower) or math.isfinite(joint.upper)):
            continue
        now = asset.positions()[joint.name]
        motors = p.motion.scene.drive.motors.get(asset.name)
        if p.driven_by_motor(asset, joint):
            target = motors.targets.get(joint.name, now) if motors else now
            if joint.lower < target < joint.upper or joint.mimic:
                continue
            return _on("joint_limits", f"the motor drives '{joint.name}' to its limit")
        if p.motion.held and joint.name not in asset.moving:
            continue
        way = p.motion.joint_speed(asset, joint) * p.motion.seconds
        if now - way <= joint.lower or now + way >= joint.upper:
            return _on("joint_limits", f"'{joint.name}' can get to its limit")
    return _off("joint_limits", "no joint gets near its limit")


def _motors(p: Physics) -> Effect:
    if p.motion.scene.drive.motors:
        joints = sum(p.driven_by_motor(a, j) for a, j in p.joints)
        return _on("motors", f"the scene drives {joints} joints by motors")
    return _off("motors", "the scene has none; joints that do not move are frozen")


def _self_collision(p: Physics) -> Effect:
    own = [(a, b) for a, b in p.pairs if a[0] == b[0]]
    if not own:
        return _off("self_collision", "no two links of one asset can meet")
    (asset, first), (_, second) = own[0]
    return _on(
        "self_collision",
        f"{len(own)} pairs can meet, such as '{first}' and '{second}' of '{asset}'",
    )


def _continuous_collision(p: Physics, step: float, travel: float) -> Effect:
    thin = p.thinnest
    if thin is None or not p.pairs:
        return _off("continuous_collision", "nothing touches")
    width, (asset, link) = thin
    # The swept ball must fit into what moves; the thinner part is what it must not miss.
    radius = 0.4 * _smallest_mover(p, width)
    said = (
        f"{travel * 1000:.3g} mm a step of {step * 1000:.3g} ms against the thinnest part, "
        f"{width * 1000:.3g} mm ('{asset}/{link}')"
    )
    if travel > width:
        return _on("continuous_collision", said, radius)
    return _off("continuous_collision", said, radius)


def _smallest_mover(p: Physics, default: float) -> float:
    moving = {r for r in p.touching if p.motion.moves(r)}
    found = p.motion.thinnest(moving)
    return found[0] if found else default


def _damping(p: Physics) -> Effect:
    damped = [(a, j) for a, j in p.joints if j.damping > 0.0]
    if not damped:
        return _off("damping", "no moving joint states it")
    asset, joint = damped[0]
    return _on("damping", f"joint '{joint.name}' of '{asset.name}' states {joint.damping:g}")


def _contact_margin(p: Physics, step: float) -> Effect:
    thin = p.thinnest
    if thin is None or not p.pairs:
        return _off("contact_margin", "nothing touches", 0.0)
    value = max(MARGIN, 2.0 * p.speed * step)
    if p.motion.scene.question in ("reach", "clearance", "contact"):
        return _off("contact_margin", "nothing is meant to rest on anything", value)
    question = p.motion.scene.question
    if question in ("settle", "hold", "slide"):
        return _on("contact_margin", "contacts that last need to be found a step ahead", value)
    return _off("contact_margin", "contacts push and need no resting margin", value)


_RULES: Mapping[EffectName, Callable[[Physics], Effect]] = {
    "gravity": _gravity,
    "friction": _friction,
    "rolling_friction": _rolling,
    "spinning_friction": _spinning,
    "restitution": _restitution,
    "joint_limits": _joint_limits,
    "motors": _motors,
    "self_collision": _self_collision,
    "damping": _damping,
}
