"""Does a robot stay where it is put? A URDF alone in a physics engine, held at home.

The question behind "it explodes in the simulator": overlapping links, slivers and lost
mass show as energy that nobody put in, as speeds that do not fade, and as drift.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

from assetpipe.errors import UsageError, unknown_name
from assetpipe.validation.contact.pairs import Pair
from assetpipe.validation.dynamics.load import rewrite
from assetpipe.validation.dynamics.process import (
    EngineName,
    engine_for,
    run_worker,
)

SettleBase = Literal["fixed", "free"]
SettleOutcome = Literal["settled", "not finite", "refused", "crashed", "timed out", "not available"]


@dataclass(frozen=True)
class Settling:
    """How a robot behaved while nothing but gravity, its motors and the floor acted on it.

    Attributes:
        engine: which simulated; ``None`` where none is installed.
        base: ``fixed`` to the world, or ``free`` on a floor.
        step, seconds: of the simulation.
        outcome: ``settled`` means that it ran to its end with finite numbers; how still
            it then was is told by the numbers below, ``nan`` for every other outcome.
        message: the engine's own words where it did not run.
        energy_gain: greatest total energy (kinetic and potential) above that at the start,
            as a share of ``m·g·size``; what motors and contacts put in from nowhere.
        residual_speed, residual_spin: m/s and rad/s, the fastest link's in the last
            quarter second.
        drift: metres that the farthest-moved link went in the last second.
        sag: radians or metres by which the farthest joint ends from where it is held.
        size: metres, diagonal of the robot's box.
        cpu_seconds: of stepping.
    """

    engine: EngineName | None
    base: SettleBase
    step: float
    seconds: float
    outcome: SettleOutcome
    message: str = ""
    energy_gain: float = math.nan
    residual_speed: float = math.nan
    residual_spin: float = math.nan
    drift: float = math.nan
    sag: float = math.nan
    size: float = math.nan
    cpu_seconds: float = math.nan

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready; numbers that do not exist are ``None``."""
        told = {
            "engine": self.engine,
            "base": self.base,
            "step": self.step,
            "seconds": self.seconds,
            "outcome": self.outcome,
            "message": self.message,
        }
        for name in _NUMBERS:
            value = getattr(self, name)
            told[name] = value if math.isfinite(value) else None
        return told


_NUMBERS = (
    "energy_gain",
    "residual_speed",
    "residual_spin",
    "drift",
    "sag",
    "size",
    "cpu_seconds",
)


def settle_in_engine(
    urdf: Path,
    *,
    base: SettleBase,
    step: float,
    seconds: float = 5.0,
    home: Mapping[str, float] | None = None,
    excluded: Sequence[Pair] = (),
    resolved: Mapping[str, Path] | None = None,
    engine: EngineName | None = None,
    timeout: float = 120.0,
) -> Settling:
    """Hold a robot at a pose under gravity and see what it does.

    Every joint is held by a motor; with a free base the robot starts just above a floor.
    Self-collision is on but for the pairs that are excluded. Runs in a process of its own.

    Args:
        urdf: the file; its visual elements are not loaded.
        base: fixed, or free on a floor with a friction coefficient of 0.8.
        step: seconds a step.
        seconds: simulated time.
        home: positions of joints by name, radians or metres; 0 for others.
        excluded: pairs of links that need not be asked, for example
            :func:`assetpipe.validation.adjacent_pairs` and what an SRDF disables.
        resolved: file of every mesh reference, as written in the URDF.
        engine: which; ``None`` takes the first that is installed.
        timeout: seconds of wall time.

    Raises:
        InputError: the file does not exist, is larger than 64 MiB or is not well-formed.
        UsageError: an engine that is not installed, a step that is not shorter than the run.
    """
    if base not in get_args(SettleBase):
        raise UsageError(unknown_name("base", base, get_args(SettleBase)))
    if not (0.0 < step < seconds < math.inf):
        raise UsageError(f"step ({step} s) must be positive and shorter than seconds ({seconds} s)")
    chosen = engine_for(urdf, engine)
    if chosen is None:
        return Settling(
            None, base, step, seconds, "not available", "no physics engine is installed"
        )
    with tempfile.TemporaryDirectory(prefix="assetpipe-urdf-") as folder:
        copy = Path(folder, "robot.urdf")
        rewrite(urdf, copy, resolved or {}, "removed")
        _free_continuous(copy)
        if chosen == "mujoco":
            from assetpipe.validation.dynamics.mujoco_worker import prepare

            prepare(copy)
        request = {
            "task": "settle",
            "urdf": str(copy),
            "base": base,
            "step": step,
            "steps": round(seconds / step),
            "home": dict(home or {}),
            "excluded": [list(pair) for pair in excluded],
        }
        answer = run_worker(chosen, request, timeout=timeout)
    if answer.outcome != "answered":
        said = "; ".join(t for t in (answer.signal, answer.log) if t)
        return Settling(chosen, base, step, seconds, answer.outcome, said)
    told = answer.answer
    if not told["loaded"]:
        return Settling(chosen, base, step, seconds, "refused", str(told["message"]))
    if not told["finite"]:
        return Settling(chosen, base, step, seconds, "not finite", str(told["message"]))
    return Settling(
        chosen,
        base,
        step,
        seconds,
        "settled",
        energy_gain=float(told["energy_gain"]),
        residual_speed=float(told["residual_speed"]),
        residual_spin=float(told["residual_spin"]),
        drift=float(told["drift"]),
        sag=float(told["sag"]),
        size=float(told["size"]),
        cpu_seconds=float(told["cpu_seconds"]),
    )


def _free_continuous(urdf: Path) -> None:
    """Take limits off joints that have none by their type, in place: URDF gives them no
    meaning there, PyBullet keeps the joint within them."""
    from lxml import etree

    parser = etree.XMLParser(resolve_entities=False, no_network=True, huge_tree=False)
    tree = etree.parse(str(urdf), parser)
    for joint in tree.getroot().iterchildren("joint"):
        if joint.get("type") == "continuous":
            for limit in joint.iterchildren("limit"):
                for key in ("lower", "upper"):
                    limit.attrib.pop(key, "")
    tree.write(str(urdf), encoding="utf-8", xml_declaration=True)
