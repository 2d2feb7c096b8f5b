"""Polygons in the plane: approximate convex decomposition, and convex sets inside."""

from assetpipe.polygon.decomposition import (
    Concavity,
    HoleAxis,
    PolygonDecomposition,
    decompose,
)
from assetpipe.polygon.inclusion import (
    ConvexSubset,
    Method,
    Search,
    convex_subset,
    largest_convex_subset,
)
from assetpipe.polygon.outline import Outline

__all__ = [
    "Concavity",
    "ConvexSubset",
    "HoleAxis",
    "Method",
    "Outline",
    "PolygonDecomposition",
    "Search",
    "convex_subset",
    "decompose",
    "largest_convex_subset",
]
