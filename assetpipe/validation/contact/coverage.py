"""Coverage: is every point of the solid in some hull?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from assetpipe.geometry.mesh import FloatArray
from assetpipe.validation.contact.flaps import beside_solid
from assetpipe.validation.contact.probes import surface_samples
from assetpipe.validation.contact.surface import ConvexShape, Surface, outside_hulls
from assetpipe.validation.statistics import Rate


@dataclass(frozen=True)
class Coverage:
    """What of the solid lies outside every hull.

    Attributes:
        surface: share of the surface samples (all vertices, and points spread by area); those
            on flaps without thickness, next to which there is no solid, may lie outside.
        interior: share of the points drawn inside the solid.
        gap: metres, the largest distance from an uncovered sample to the hulls.
        witness: (x, y, z) of that sample; ``None`` where all is covered.
        band: metres, the rounding that is let pass.
    """

    surface: Rate
    interior: Rate
    gap: float
    witness: tuple[float, float, float] | None
    band: float

    @property
    def complete(self) -> bool:
        """Whether no sample lies outside."""
        return self.surface.count == 0 and self.interior.count == 0

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {
            "surface_outside": self.surface.as_dict(),
            "interior_outside": self.interior.as_dict(),
            "gap": self.gap,
            "witness": self.witness,
            "band": self.band,
        }


def cover(
    solid: Surface,
    hulls: Sequence[ConvexShape],
    *,
    samples: int,
    band: float,
    rng: np.random.Generator,
) -> Coverage:
    """Look for points of the solid outside all hulls.

    Args:
        solid: closed surface.
        hulls: convex shapes, same frame.
        samples: surface points by area, beside all vertices; as many interior points.
        band: metres; a point this near to a hull counts as covered.
        rng: seeded generator.
    """
    spread, _ = surface_samples(solid.vertices, solid.faces, samples, rng)
    used = np.unique(solid.faces)
    surface = np.vstack([solid.vertices[used], spread])
    interior = _inside(solid, samples, rng)
    joined = Surface.of_hulls(hulls, solid.frame)
    counts, gap, witness = [], 0.0, None
    for points in (surface, interior):
        outside = points[outside_hulls(points, hulls) > band]
        away = joined.distances(outside)
        # The facet excess is a lower bound of the distance, so nothing is counted wrongly.
        outside, away = outside[away > band], away[away > band]
        if points is surface:
            solidly = beside_solid(solid, outside, away)
            outside, away = outside[solidly], away[solidly]
        counts.append(Rate.wilson(len(outside), len(points)))
        if away.size and float(away.max()) > gap:
            gap = float(away.max())
            x, y, z = outside[int(np.argmax(away))]
            witness = (float(x), float(y), float(z))
    return Coverage(counts[0], counts[1], gap, witness if gap > band else None, band)


def _inside(solid: Surface, count: int, rng: np.random.Generator) -> FloatArray:
    """Up to ``count`` points inside the solid, by rejection from its bounding box."""
    low, high = solid.vertices.min(axis=0), solid.vertices.max(axis=0)
    drawn = low + (high - low) * rng.random((4 * count, 3))
    inside: FloatArray = drawn[solid.winding(drawn) > 0.5]
    return inside[:count]
