"""Run a plan: queries (FCL) or a physics engine."""

from assetpipe.validation.runners.dynamics import SimulationError, run_dynamics
from assetpipe.validation.runners.queries import Measured, run_queries
from assetpipe.validation.runners.scene import (
    SceneOptions,
    SceneResult,
    answer_scene,
    explain_scene,
    run_scene,
)

__all__ = [
    "Measured",
    "SceneOptions",
    "SceneResult",
    "SimulationError",
    "answer_scene",
    "explain_scene",
    "run_dynamics",
    "run_queries",
    "run_scene",
]
