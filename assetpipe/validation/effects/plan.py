"""What a plan is: a method, effects with reasons, roles, pairs and settings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from assetpipe.validation.scenes.schema import EffectName, Question, Switch

Method = Literal["nothing", "distance", "contact", "sweep", "dynamics"]
Backend = Literal["none", "fcl", "bullet", "mujoco"]
RoleName = Literal["moves", "moves without contact", "frozen", "left out"]

METHODS: tuple[Method, ...] = ("nothing", "distance", "contact", "sweep", "dynamics")
"""From cheap to dear."""

EFFECTS: tuple[EffectName, ...] = (
    "gravity",
    "friction",
    "rolling_friction",
    "spinning_friction",
    "restitution",
    "joint_limits",
    "motors",
    "self_collision",
    "continuous_collision",
    "damping",
    "contact_margin",
)
"""Every effect, in the order in which a plan tells them."""

Ref = tuple[str, str]
"""Asset name and link name."""


@dataclass(frozen=True)
class Effect:
    """One physical phenomenon, on or off.

    Attributes:
        name: which.
        state: on or off.
        reason: why, with the numbers that decided it.
        value: the number that goes with it (m/s², a radius, a margin), where there is one.
        overruled: the scene or the caller decided, not the planner.
    """

    name: EffectName
    state: Switch
    reason: str
    value: float | None = None
    overruled: bool = False

    @property
    def is_on(self) -> bool:
        """Whether it is simulated."""
        return self.state == "on"

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {
            "state": self.state,
            "reason": self.reason,
            "value": self.value,
            "overruled": self.overruled,
        }


@dataclass(frozen=True)
class Role:
    """What a link does in the plan, and why."""

    asset: str
    link: str
    role: RoleName
    reason: str

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {"asset": self.asset, "link": self.link, "role": self.role, "reason": self.reason}


@dataclass(frozen=True)
class Setting:
    """A number that the engine needs, and where it comes from."""

    value: float
    reason: str

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {"value": self.value, "reason": self.reason}


@dataclass(frozen=True)
class Plan:
    """The smallest simulation that answers a scene's question.

    Attributes:
        question: of the scene.
        method: how it is answered, and
        why: the reason.
        backend: who answers.
        effects: all of them, on or off, in the order of :data:`EFFECTS`.
        roles: of every link.
        pairs: pairs of links that are asked about, or may touch in the engine.
        skipped_pairs: how many pairs were left out, by reason.
        seconds: simulated or swept time; 0 for a static question.
        step: seconds a step; 0 where nothing steps.
        iterations: of the contact solver; 0 where nothing steps.
        idle_joints: whether joints that nothing drives are welded, or simulated and held
            by motors.
    """

    question: Question
    method: Method
    why: str
    backend: Backend
    effects: tuple[Effect, ...]
    roles: tuple[Role, ...]
    pairs: tuple[tuple[Ref, Ref], ...]
    skipped_pairs: tuple[tuple[str, int], ...]
    seconds: float
    step: Setting
    iterations: Setting
    idle_joints: Literal["frozen", "held"] = "frozen"

    def effect(self, name: EffectName) -> Effect:
        """One effect by name."""
        return next(e for e in self.effects if e.name == name)

    def role(self, asset: str, link: str) -> RoleName:
        """The role of a link."""
        return next(r.role for r in self.roles if (r.asset, r.link) == (asset, link))

    @property
    def steps(self) -> int:
        """How many steps are simulated."""
        return round(self.seconds / self.step.value) if self.step.value else 0

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {
            "question": self.question,
            "method": self.method,
            "why": self.why,
            "backend": self.backend,
            "effects": {e.name: e.as_dict() for e in self.effects},
            "roles": [r.as_dict() for r in self.roles],
            "pairs": [[list(a), list(b)] for a, b in self.pairs],
            "skipped_pairs": dict(self.skipped_pairs),
            "seconds": self.seconds,
            "step": self.step.as_dict(),
            "iterations": self.iterations.as_dict(),
            "steps": self.steps,
            "idle_joints": self.idle_joints,
        }

    def explain(self) -> str:
        """The plan in words, a line a decision."""
        lines = [f"{self.question}: {self.method} ({self.backend}) - {self.why}"]
        for effect in self.effects:
            mark = "on " if effect.is_on else "off"
            value = f" [{effect.value:.4g}]" if effect.value is not None else ""
            who = " (overruled)" if effect.overruled else ""
            lines.append(f"  {mark} {effect.name}{value}{who}: {effect.reason}")
        for role in ("moves", "moves without contact", "frozen", "left out"):
            members = [r for r in self.roles if r.role == role]
            reasons: dict[str, list[str]] = {}
            for r in members:
                reasons.setdefault(r.reason, []).append(f"{r.asset}/{r.link}")
            for reason, names in reasons.items():
                shown = ", ".join(names[:6]) + (f" and {len(names) - 6} more" if names[6:] else "")
                lines.append(f"  {role}: {shown} - {reason}")
        skipped = "; ".join(f"{count} {why}" for why, count in self.skipped_pairs)
        lines.append(f"  pairs: {len(self.pairs)}" + (f"; left out: {skipped}" if skipped else ""))
        if self.steps:
            lines.append(f"  step: {self.step.value:.6g} s - {self.step.reason}")
            lines.append(f"  iterations: {self.iterations.value:.0f} - {self.iterations.reason}")
            lines.append(f"  {self.steps} steps over {self.seconds:g} s")
        return "\n".join(lines)
