"""Outlines: polygons with holes, as shapely polygons or as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from assetpipe.errors import UsageError

if TYPE_CHECKING:
    import shapely

Outline: TypeAlias = (
    "shapely.Polygon | shapely.MultiPolygon | ArrayLike | tuple[ArrayLike, Sequence[ArrayLike]]"
)
"""A shapely polygon, an (n, 2) array, or ``(outer, [hole, …])`` arrays. A point belongs to it
when an odd number of rings goes around it."""


def load_shapely() -> Any:
    """The shapely module.

    Raises:
        UsageError: it is not installed; it comes with the extra ``polygon``.
    """
    try:
        import shapely
        import shapely.affinity
    except ImportError as error:
        raise UsageError(
            "polygons need shapely, which is not installed: pip install 'assetpipe[polygon]'"
        ) from error
    return shapely


def as_rings(outline: Outline) -> list[NDArray[np.float64]]:
    """The rings of an outline, each of shape (n, 2), without closing repetition.

    Raises:
        UsageError: it is no outline.
    """
    if hasattr(outline, "geom_type"):
        return _shapely_rings(outline)
    if isinstance(outline, list) and outline and all(np.ndim(r) == 2 for r in outline):
        return [_ring(ring) for ring in outline]
    if (
        isinstance(outline, tuple)
        and len(outline) == 2
        and np.ndim(outline[0]) == 2
        and not isinstance(outline[1], np.ndarray)
    ):
        outer, holes = outline
        return [_ring(outer), *(_ring(hole) for hole in holes)]
    return [_ring(outline)]


def _shapely_rings(shape: Any) -> list[NDArray[np.float64]]:
    if shape.geom_type == "Polygon":
        polygons = [shape]
    elif shape.geom_type == "MultiPolygon":
        polygons = list(shape.geoms)
    else:
        raise UsageError(f"an outline is a Polygon or MultiPolygon, not a {shape.geom_type}")
    rings = [
        _ring(ring.coords)
        for polygon in polygons
        if not polygon.is_empty
        for ring in (polygon.exterior, *polygon.interiors)
    ]
    if not rings:
        raise UsageError("the outline is empty")
    return rings


def _ring(points: Any) -> NDArray[np.float64]:
    try:
        ring = np.array(points, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise UsageError(f"a ring is an array of shape (n, 2): {error}") from error
    if ring.ndim != 2 or ring.shape[0] < 3 or ring.shape[1] not in (2, 3):
        raise UsageError(f"a ring is an array of shape (n, 2), n >= 3, not {ring.shape}")
    ring = ring[:, :2]
    if np.array_equal(ring[0], ring[-1]):
        ring = ring[:-1]
    return np.ascontiguousarray(ring)


def as_shapely(rings: Sequence[NDArray[np.float64]]) -> Any:
    """A shapely polygon from its outer ring and its holes."""
    return load_shapely().Polygon(rings[0], rings[1:])


def even_odd(rings: Sequence[NDArray[np.float64]]) -> Any:
    """The region of all points with an odd number of rings around them, as shapely geometry."""
    shapely = load_shapely()
    region = shapely.Polygon()
    for ring in rings:
        region = region.symmetric_difference(shapely.make_valid(shapely.Polygon(ring)))
    return region
