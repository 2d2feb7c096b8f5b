"""The effect planner: what a scene needs simulated, and why."""

from assetpipe.validation.effects.plan import EFFECTS, METHODS, Effect, Plan, Role, Setting
from assetpipe.validation.effects.planner import Scope, plan

__all__ = [
    "EFFECTS",
    "METHODS",
    "Effect",
    "Plan",
    "Role",
    "Scope",
    "Setting",
    "plan",
]
