"""Run a plan: queries (FCL) or a physics engine."""

from assetpipe.validation.runners.dynamics import SimulationError, run_dynamics
from assetpipe.validation.runners.queries import Measured, run_queries

__all__ = ["Measured", "SimulationError", "run_dynamics", "run_queries"]
