"""The state of a mesh: every defect counted and located."""

from assetpipe.geometry.health.examine import examine
from assetpipe.geometry.health.report import Defect, Health, Soundness

__all__ = ["Defect", "Health", "Soundness", "examine"]
