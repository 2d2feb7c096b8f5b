"""What both engines' settling workers record, and the numbers that come of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

GRAVITY = 9.81
FLOOR_FRICTION = 0.8
CLEARANCE = 1e-3
"""Metres between the floor and the lowest point at the start."""
RATE = 100
"""States looked at in a simulated second, or every step if that is rarer."""


@dataclass(frozen=True)
class Snapshot:
    """One moment: seconds, total energy (J), fastest link (m/s, rad/s), places of links (m)."""

    time: float
    energy: float
    speed: float
    spin: float
    places: tuple[tuple[float, float, float], ...]

    @property
    def finite(self) -> bool:
        """Whether all numbers are."""
        numbers = (self.energy, self.speed, self.spin, *(v for p in self.places for v in p))
        return all(math.isfinite(v) for v in numbers)


def every(step: float) -> int:
    """Steps between two snapshots."""
    return max(1, round(1.0 / (RATE * step)))


def summary(
    states: Sequence[Snapshot], *, mass: float, size: float, sag: float, cpu_seconds: float
) -> dict[str, Any]:
    """The worker's answer, JSON-ready; see :class:`.settle.Settling`.

    Args:
        states: the first before the first step; the last may be the first that is not finite.
        mass: kilograms of all that moves; size: metres; sag: radians or metres.
        cpu_seconds: of stepping.
    """
    last = states[-1]
    if not all(state.finite for state in states) or not math.isfinite(sag):
        return {"loaded": True, "finite": False, "message": f"not finite after {last.time:.4g} s"}
    start = states[0].energy
    unit = max(mass * GRAVITY * size, 1e-12)
    late = [state for state in states if state.time >= last.time - 0.25]
    before = min(states, key=lambda state: abs(state.time - (last.time - 1.0)))
    return {
        "loaded": True,
        "finite": True,
        "message": "",
        "energy_gain": max(state.energy - start for state in states) / unit,
        "residual_speed": max(state.speed for state in late),
        "residual_spin": max(state.spin for state in late),
        "drift": max(math.dist(a, b) for a, b in zip(before.places, last.places, strict=True)),
        "sag": sag,
        "size": size,
        "cpu_seconds": cpu_seconds,
    }
