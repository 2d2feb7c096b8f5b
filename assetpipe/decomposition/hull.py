"""Hulls: the convex polytopes that a simulator gets."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from assetpipe.decomposition.certificate import Certificate
from assetpipe.decomposition.polytope import Polytope

if TYPE_CHECKING:
    from assetpipe.decomposition.primitives import Primitive


@dataclass(frozen=True, eq=False)
class Hull(Polytope):
    """A convex polytope that covers one part of the solid.

    Attributes:
        vertices, faces, volume: as every :class:`Polytope` has them.
        certificate: what is proved about it.
        primitive: the simple shape to write in its place; the polytope is around it, and the
            certificate holds for both. ``None``: the polytope itself.
    """

    certificate: Certificate
    primitive: Primitive | None = None

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready, lengths in metres."""
        return {
            **super().as_dict(),
            "certificate": self.certificate.as_dict(),
            "primitive": self.primitive.as_dict() if self.primitive else None,
        }
