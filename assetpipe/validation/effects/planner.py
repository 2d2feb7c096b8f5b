"""The effect planner: the smallest simulation that answers a scene's question.

A pure function of the scene and its assets. Nothing is on by habit: every effect, link
and pair is decided for a reason that is kept beside it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from itertools import combinations
from typing import Literal

from assetpipe.validation.effects.check import check_references
from assetpipe.validation.effects.motion import Motion
from assetpipe.validation.effects.physics import Physics, decide
from assetpipe.validation.effects.plan import (
    EFFECTS,
    Backend,
    Effect,
    Method,
    Plan,
    Ref,
    Role,
    RoleName,
    Setting,
)
from assetpipe.validation.effects.settings import FINEST, HABIT, iterations, time_step
from assetpipe.validation.scenes.assets import SceneAsset
from assetpipe.validation.scenes.schema import EffectName, Scene, Switch
from assetpipe.validation.self_collision import adjacent_pairs

Pairs = tuple[tuple[Ref, Ref], ...]


Scope = Literal["needed", "everything"]


def plan(
    scene: Scene,
    assets: Mapping[str, SceneAsset],
    *,
    effects: Mapping[EffectName, Switch] | None = None,
    engine: Backend = "bullet",
    scope: Scope = "needed",
) -> Plan:
    """Plan a scene.

    Args:
        scene: the question and its situation.
        assets: by the scene's names, with their geometry.
        effects: overrules scene and planner, effect by effect.
        engine: the physics engine that a dynamic plan uses.
        scope: ``everything`` decides nothing: all effects on, every joint simulated,
            every pair, the finest step. It is what the planner is measured against.

    Raises:
        ConfigError: the scene names links or joints that its assets do not have.
    """
    overruled: dict[EffectName, Switch] = {**scene.effects, **(effects or {})}
    if scope == "everything":
        overruled = dict.fromkeys(EFFECTS, "on")
    asked_on = {name for name, state in overruled.items() if state == "on"}
    check_references(scene, assets)
    motion = Motion(scene, assets)
    method, why = _method(scene, motion)
    if asked_on and method != "dynamics":
        method = "dynamics"
        why = f"{_names(asked_on)} asked for: that needs a physics world"
    # With motors asked for, joints that nothing drives are held instead of frozen.
    held = method == "dynamics" and ("motors" in asked_on or scene.question == "self_collision")
    motion = Motion(scene, assets, held=held)
    pairs, skipped = _pairs(scene, motion, method, scope)
    if method != "dynamics":
        roles = _roles(motion, pairs, method)
        seconds = motion.seconds if method == "sweep" else 0.0
        quiet = tuple(
            Effect(name, "off", _quiet(name, method), overruled=name in overruled)
            for name in EFFECTS
        )
        still = Setting(0.0, "nothing steps")
        backend: Backend = "none" if method == "nothing" else "fcl"
        return Plan(
            question=scene.question,
            method=method,
            why=why,
            backend=backend,
            effects=quiet,
            roles=roles,
            pairs=pairs,
            skipped_pairs=skipped,
            seconds=seconds,
            step=still,
            iterations=still,
        )
    physics = Physics(motion, pairs)
    step, travel = time_step(physics)
    if scope == "everything":
        step = Setting(FINEST, "the finest: nothing is known")
    decided = tuple(
        _overrule(decide(name, physics, step.value, travel), overruled) for name in EFFECTS
    )
    kept = {e.name: e for e in decided}
    if not kept["self_collision"].is_on:
        before = len(pairs)
        pairs = tuple((a, b) for a, b in pairs if a[0] != b[0])
        if before != len(pairs):
            skipped = (*skipped, ("within one asset: self-collision is off", before - len(pairs)))
    return Plan(
        question=scene.question,
        method=method,
        why=why,
        backend=engine,
        effects=decided,
        roles=_roles(motion, pairs, method),
        pairs=pairs,
        skipped_pairs=skipped,
        seconds=motion.seconds,
        step=step,
        iterations=iterations(physics)
        if scope == "needed"
        else Setting(max(HABIT, iterations(physics).value), "at least the engine's default"),
        idle_joints="held" if held else "frozen",
    )


def _names(effects: set[EffectName]) -> str:
    shown = [name for name in EFFECTS if name in effects]
    return "every effect is" if len(shown) == len(EFFECTS) else f"{', '.join(shown)} is"


def _overrule(effect: Effect, overruled: Mapping[EffectName, Switch]) -> Effect:
    state = overruled.get(effect.name)
    if state is None or state == effect.state:
        return effect
    said = f"asked for; the planner says {effect.state}: {effect.reason}"
    return Effect(effect.name, state, said, effect.value, overruled=True)


def _quiet(name: EffectName, method: Method) -> str:
    if name == "self_collision" and method == "contact":
        return "pairs are asked one by one; nothing collides in time"
    return {
        "nothing": "nothing can move",
        "distance": "a distance has no forces",
        "contact": "whether shapes touch has no forces",
        "sweep": "the motion is given; where it is blocked is geometry",
    }.get(method, "nothing is simulated")


def _method(scene: Scene, motion: Motion) -> tuple[Method, str]:
    drive = scene.drive
    q = scene.question
    if q in ("clearance", "contact"):
        if drive.path is None and drive.trajectory is None:
            if q == "clearance":
                return "distance", "nothing moves: one distance query a pair"
            return "contact", "nothing moves: yes or no is one contact query a pair"
        return "sweep", "the motion is given: conservative advancement along it"
    if q == "self_collision":
        return "contact", "configurations are asked one by one, none depends on the one before"
    if q == "reach":
        return "sweep", "the path is given: whether it is free is geometry"
    movable = [
        (name, link.name)
        for name, asset in motion.assets.items()
        for link in asset.links
        if motion.moves((name, link.name))
    ]
    if not movable:
        return "nothing", "nothing can move, so nothing changes"
    reasons = {
        "settle": "where bodies come to rest is decided by forces",
        "hold": "whether it holds is a balance of forces",
        "open": "the joint is moved by contact forces",
        "slide": "whether it catches is decided by contact forces",
    }
    return "dynamics", reasons[q]


def _pairs(
    scene: Scene, motion: Motion, method: Method, scope: Scope
) -> tuple[Pairs, tuple[tuple[str, int], ...]]:
    """Pairs that matter, and how many others were left out, by reason."""
    if method == "nothing":
        return (), ()
    if scene.between is not None and method != "dynamics":
        first, second = (motion.parts(r) for r in scene.between)
        named = {tuple(sorted((a, b))) for a in first for b in second if a != b}
        return tuple(sorted((a, b) for a, b in named)), ()
    skipped: Counter[str] = Counter()
    kept = []
    adjacent = {
        name: set(adjacent_pairs((j.parent, j.child, j.kind) for j in asset.joints))
        for name, asset in motion.assets.items()
    }
    refs = [
        (name, link.name)
        for name, asset in motion.assets.items()
        for link in asset.links
        if link.shapes
    ]
    sampled = scene.question == "self_collision" and method == "contact"
    path = scene.drive.path
    regions = {} if sampled else {ref: motion.region(ref) for ref in refs}
    for a, b in combinations(refs, 2):
        if a[0] == b[0] and (min(a[1], b[1]), max(a[1], b[1])) in adjacent[a[0]]:
            skipped["adjacent"] += 1
        elif sampled:
            if a[0] == b[0] == scene.subject:
                kept.append((a, b))
            else:
                skipped["not of the subject"] += 1
        elif motion.together(a, b):
            skipped["never move relative to each other"] += 1
        elif method == "sweep" and path is not None and path.asset not in (a[0], b[0]):
            skipped["not on the path"] += 1
        elif scope == "needed" and not _meet(regions, a, b):
            skipped["swept volumes apart"] += 1
        else:
            kept.append((a, b))
    return tuple(kept), tuple(sorted(skipped.items()))


def _meet(regions: Mapping[Ref, object], a: Ref, b: Ref) -> bool:
    from assetpipe.validation.effects.motion import Region

    first, second = regions[a], regions[b]
    return isinstance(first, Region) and isinstance(second, Region) and first.meets(second)


def _roles(motion: Motion, pairs: Pairs, method: Method) -> tuple[Role, ...]:
    touching = {ref for pair in pairs for ref in pair}
    for reference in motion.scene.between or ():
        touching |= set(motion.parts(reference))
    roles = []
    for name, asset in motion.assets.items():
        for link in asset.links:
            ref = (name, link.name)
            role, reason = _role(ref, motion, touching, method)
            roles.append(Role(name, link.name, role, reason))
    return tuple(roles)


def _role(ref: Ref, motion: Motion, touching: set[Ref], method: Method) -> tuple[RoleName, str]:
    asset = motion.assets[ref[0]]
    moves = motion.moves(ref) and method in ("sweep", "dynamics")
    if ref in touching:
        if moves:
            return "moves", "it moves, and may touch what the answer depends on"
        if method in ("distance", "contact"):
            return "frozen", "asked where it is"
        return "frozen", "it is held where it is, and may be touched"
    if not asset.link[ref[1]].shapes:
        why = "it has no collision geometry"
    elif method in ("distance", "contact", "sweep"):
        why = "the question is not about it"
    elif method == "nothing":
        why = "nothing moves"
    else:
        why = "nothing that moves relative to it can get there"
    return ("moves without contact" if moves else "left out"), why
