"""Convex polytopes: what hulls and inner hulls have in common."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from assetpipe.geometry.mesh import FloatArray, IntArray, Mesh, locked


@dataclass(frozen=True, eq=False)
class Polytope:
    """A convex polytope.

    Attributes:
        vertices: (k, 3) float64, metres, only extreme points.
        faces: (f, 3) int64, counter-clockwise seen from outside.
        volume: m³.
    """

    vertices: FloatArray
    faces: IntArray
    volume: float

    def __post_init__(self) -> None:
        locked(self.vertices)
        locked(self.faces)

    @property
    def mesh(self) -> Mesh:
        """The polytope as a mesh."""
        return Mesh(self.vertices, self.faces)

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready, lengths in metres."""
        return {
            "vertices": len(self.vertices),
            "faces": len(self.faces),
            "volume": self.volume,
        }
