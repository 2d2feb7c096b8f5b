"""What is wrong with a mesh, counted and located."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any

import numpy as np

from assetpipe.geometry.mesh import FloatArray

_EXAMPLES = 5


class Soundness(Enum):
    """The worst thing about a mesh, from good to bad."""

    SOLID = "solid"
    """Closed, manifold, outward; one component, or several that lie apart."""
    NEEDS_WELD = "needs weld"
    """A solid once coinciding vertices are joined (every STL file)."""
    INSIDE_OUT = "inside-out"
    """Closed and manifold, but wound inward."""
    SEVERAL = "several components"
    """Closed components that may overlap, or lie in one another."""
    SELF_INTERSECTING = "self-intersecting"
    """Closed, but the surface crosses itself."""
    INCONSISTENT = "inconsistent winding"
    """Closed, but neighbouring faces disagree about outside."""
    NON_MANIFOLD = "non-manifold"
    """No boundary, but edges with more than two faces or vertices joining several umbrellas."""
    OPEN = "open"
    """Edges with one face only."""
    FLAT = "flat"
    """Everything lies in a plane: no volume."""
    EMPTY = "empty"
    """No faces, or degenerate ones only."""


@dataclass(frozen=True)
class Defect:
    """How often something occurs, and where for the first few.

    Attributes:
        count: how often.
        at: points in metres, at most five.
    """

    count: int = 0
    at: tuple[tuple[float, float, float], ...] = ()

    def __bool__(self) -> bool:
        return self.count > 0

    @classmethod
    def of(cls, points: FloatArray) -> Defect:
        """One occurrence at each of (n, 3) points."""
        first = tuple((float(x), float(y), float(z)) for x, y, z in points[:_EXAMPLES])
        return cls(len(points), first)

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {"count": self.count, "at": [list(point) for point in self.at]}


@dataclass(frozen=True)
class Health:
    """The state of a mesh. Topology is that after joining coinciding vertices.

    Lengths are metres, volumes m³, shares are of the bounding box's diagonal.

    Attributes:
        soundness: the worst thing about it.
        vertices: as they are stored.
        faces: as they are stored.
        components: pieces connected over edges.
        duplicate_vertices: vertices that an exact weld would join.
        degenerate_faces: that name a vertex twice, after the weld.
        duplicate_faces: that repeat another one's vertices.
        zero_area_faces: with three vertices on a line.
        sliver_faces: higher than nothing, but less than a thousandth of their longest edge.
        boundary_edges: with one face only.
        openings: loops of edges that lack a face on one side, as at boundaries and fins.
        widest_opening: the largest one's extent, metres.
        nonmanifold_edges: with more than two faces.
        nonmanifold_vertices: that join several umbrellas.
        inconsistent_edges: whose two faces disagree about the winding.
        inverted_components: closed ones wound inward that lie in no other.
        cavities: closed ones wound inward that lie in another.
        self_intersections: pairs of faces that cross; ``None`` if it was not examined.
        closed: no boundary edge, and every edge is passed as often each way.
        convex_within: share: how deep the surface lies below its hull, at sampled points
            (0 for a convex mesh).
        volume: signed, of a closed mesh; ``None`` otherwise.
        area: of all faces, m².
        extents: of the bounding box.
        diagonal: of the bounding box.
        notes: what was not examined, and why.
    """

    soundness: Soundness
    vertices: int
    faces: int
    components: int
    duplicate_vertices: int
    degenerate_faces: int
    duplicate_faces: Defect
    zero_area_faces: Defect
    sliver_faces: Defect
    boundary_edges: Defect
    openings: Defect
    widest_opening: float
    nonmanifold_edges: Defect
    nonmanifold_vertices: Defect
    inconsistent_edges: Defect
    inverted_components: int
    cavities: int
    self_intersections: Defect | None
    closed: bool
    convex_within: float
    volume: float | None
    area: float
    extents: tuple[float, float, float]
    diagonal: float
    notes: tuple[str, ...] = ()

    @property
    def solid(self) -> bool:
        """Whether nothing needs repair but, at most, a weld."""
        return self.soundness in (Soundness.SOLID, Soundness.NEEDS_WELD)

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready; keys are always all there."""
        result: dict[str, Any] = {}
        for name, value in vars(self).items():
            if isinstance(value, Defect):
                result[name] = value.as_dict()
            elif isinstance(value, Soundness):
                result[name] = value.value
            elif isinstance(value, tuple):
                result[name] = list(value)
            elif isinstance(value, float):
                result[name] = value if np.isfinite(value) else None
            else:
                result[name] = value
        return result
