"""Meshes as frozen values: files, units, health and repair."""

from assetpipe.geometry.health import Defect, Health, Soundness, examine
from assetpipe.geometry.mesh import Mesh
from assetpipe.geometry.repair import (
    Deviation,
    Repaired,
    RepairLimits,
    RepairPolicy,
    Rung,
    Step,
    is_solid,
    repair,
)

__all__ = [
    "Defect",
    "Deviation",
    "Health",
    "Mesh",
    "RepairLimits",
    "RepairPolicy",
    "Repaired",
    "Rung",
    "Soundness",
    "Step",
    "examine",
    "is_solid",
    "repair",
]
