"""Solids from dirty meshes: a ladder of steps, each measured in metres."""

from assetpipe.geometry.repair.check import defect, is_solid
from assetpipe.geometry.repair.ladder import repair
from assetpipe.geometry.repair.policy import RepairLimits, RepairPolicy
from assetpipe.geometry.repair.result import Deviation, Repaired, Rung, Step

__all__ = [
    "Deviation",
    "RepairLimits",
    "RepairPolicy",
    "Repaired",
    "Rung",
    "Step",
    "defect",
    "is_solid",
    "repair",
]
