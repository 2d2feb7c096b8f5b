"""Time step and solver iterations: from speeds, sizes and masses, not by habit."""

from __future__ import annotations

import math
from collections.abc import Iterable

from assetpipe.validation.effects.physics import Physics
from assetpipe.validation.effects.plan import Setting
from assetpipe.validation.scenes.assets import SceneAsset

COARSEST = 1.0 / 120.0
"""Seconds; coarser steps make contact solvers soft."""
FINEST = 1.0 / 2000.0
"""Seconds; below that continuous collision is cheaper than smaller steps."""

CORRECTION = 0.2
"""Share of an error that a constraint takes back in a step (Bullet's ERP)."""
HABIT = 50.0
"""Iterations that PyBullet takes when nobody says otherwise."""


def time_step(physics: Physics) -> tuple[Setting, float]:
    """The largest step that is small enough, and how far the fastest point goes in it.

    Five bounds: what gravity adds in one step must sink less than a tenth of the limit,
    g·h² ≤ limit/10; where a light free body can carry a heavy one the solver leaves over a
    part of the heavy one's weight, which pushes the light one, so M/m·g·h² ≤ limit (smaller
    steps mend this, more iterations hardly: Macklin et al. 2019, Small Steps in Physics
    Simulation); the fastest point should not pass the thinnest part, v·h ≤ width; a
    driven joint must not turn more than a twentieth of a radian, ω·h ≤ 0.05; and a driven
    asset, which lags v·h/ERP behind its path, must lag less than half the limit.
    """
    motion = physics.motion
    bounds = [(COARSEST, "no faster process asks for less than 1/120 s")]
    gravity = motion.scene.drive.gravity
    if gravity and (physics.free or physics.joints):
        # No asked precision is finer than a tenth of a millimetre in an engine.
        allowed = max(0.1 * physics.limit, 1e-4)
        bounds.append(
            (
                math.sqrt(allowed / gravity),
                f"gravity sinks {allowed * 1000:.3g} mm in it, a tenth of the limit",
            )
        )
        ratio = mass_ratio([asset_mass(asset) for asset in physics.free])
        if ratio > 1.0:
            bounds.append(
                (
                    math.sqrt(max(physics.limit, 1e-3) / (gravity * ratio)),
                    f"a free body may carry one {ratio:.3g} times as heavy",
                )
            )
    thin = physics.thinnest
    if thin is not None and physics.speed > 0.0:
        width, (asset, link) = thin
        safe = width / physics.speed
        if safe >= FINEST:
            bounds.append(
                (
                    safe,
                    f"{physics.speed:.3g} m/s must not pass {width * 1000:.3g} mm of "
                    f"'{asset}/{link}' in it",
                )
            )
    if motion.path_speed > 0.0:
        bounds.append(
            (
                0.5 * physics.limit * CORRECTION / motion.path_speed,
                f"the path at {motion.path_speed:.3g} m/s is followed to half the limit",
            )
        )
    for asset_, joint in physics.joints:
        rate = motion.joint_speed(asset_, joint) if joint.kind != "prismatic" else 0.0
        if rate > 0.0:
            bounds.append((0.05 / rate, f"joint '{joint.name}' turns 0.05 rad in it"))
    wanted, reason = min(bounds)
    step = 1.0 / math.ceil(1.0 / max(wanted, FINEST) - 1e-9)
    return Setting(step, reason), physics.speed * step


def iterations(physics: Physics) -> Setting:
    """Iterations of a projected Gauss-Seidel contact solver.

    Contact forces travel one body an iteration and shrink by the mass ratio, so the
    number grows with the longest stack or chain and the square root of that ratio.
    """
    free = len(physics.free)
    chain = max(
        (
            sum(physics.motion.active(a, j) for j in a.chain(link.name))
            for a in physics.motion.assets.values()
            for link in a.links
        ),
        default=0,
    )
    ratio = mass_ratio(
        link.inertial.mass
        for a in physics.motion.assets.values()
        for link in a.links
        if link.inertial is not None and physics.motion.moves((a.name, link.name))
    )
    depth = max(1, free + chain)
    count = min(200, math.ceil(10 + 5 * depth * math.sqrt(min(ratio, 100.0))))
    return Setting(
        float(count), f"{free} free bodies, joint chain of {chain}, mass ratio {ratio:.3g}"
    )


def asset_mass(asset: SceneAsset) -> float:
    """Kilograms of all links."""
    return sum(link.inertial.mass for link in asset.links if link.inertial is not None)


def mass_ratio(masses: Iterable[float]) -> float:
    """The heaviest over the lightest that has a mass; 1 where there are not two."""
    real = [mass for mass in masses if mass > 0.0]
    return max(real) / min(real) if real else 1.0
