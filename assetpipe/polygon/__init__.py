"""Polygons in the plane: approximate convex decomposition, and convex sets inside."""

from assetpipe.polygon.decomposition import (
    Concavity,
    HoleAxis,
    PolygonDecomposition,
    decompose,
)
from assetpipe.polygon.inclusion import Method, largest_convex_subset
from assetpipe.polygon.outline import Outline

__all__ = [
    "Concavity",
    "HoleAxis",
    "Method",
    "Outline",
    "PolygonDecomposition",
    "decompose",
    "largest_convex_subset",
]
