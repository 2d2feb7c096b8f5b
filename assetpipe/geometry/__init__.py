"""Meshes as frozen values: files, units, health and repair."""

from assetpipe.geometry.files import (
    SUFFIXES,
    FileLimits,
    LoadedMesh,
    obj_text,
    read_mesh,
    write_obj,
)
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
from assetpipe.geometry.units import AxisPolicy

__all__ = [
    "SUFFIXES",
    "AxisPolicy",
    "Defect",
    "Deviation",
    "FileLimits",
    "Health",
    "LoadedMesh",
    "Mesh",
    "RepairLimits",
    "RepairPolicy",
    "Repaired",
    "Rung",
    "Soundness",
    "Step",
    "examine",
    "is_solid",
    "obj_text",
    "read_mesh",
    "repair",
    "write_obj",
]
