"""Hulls: the convex polytopes that a simulator gets."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from assetpipe.decomposition.certificate import Certificate
from assetpipe.geometry.mesh import FloatArray, IntArray, Mesh, locked

if TYPE_CHECKING:
    from assetpipe.decomposition.primitives import Primitive


@dataclass(frozen=True, eq=False)
class Hull:
    """A convex polytope that covers one part of the solid.

    Attributes:
        vertices: (k, 3) float64, metres, only extreme points.
        faces: (f, 3) int64, counter-clockwise seen from outside.
        volume: m³.
        certificate: what is proved about it.
        primitive: the simple shape to write in its place; the polytope is around it, and the
            certificate holds for both. ``None``: the polytope itself.
    """

    vertices: FloatArray
    faces: IntArray
    volume: float
    certificate: Certificate
    primitive: Primitive | None = None

    def __post_init__(self) -> None:
        locked(self.vertices)
        locked(self.faces)

    @property
    def mesh(self) -> Mesh:
        """The hull as a mesh."""
        return Mesh(self.vertices, self.faces)

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready, lengths in metres."""
        return {
            "vertices": len(self.vertices),
            "faces": len(self.faces),
            "volume": self.volume,
            "certificate": self.certificate.as_dict(),
            "primitive": self.primitive.as_dict() if self.primitive else None,
        }
