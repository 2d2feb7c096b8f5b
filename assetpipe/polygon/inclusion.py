"""Large convex sets inside an outline (Chassery & Coeurjolly 2005)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import NDArray

from assetpipe import _core
from assetpipe.errors import InputError, UsageError, unknown_name
from assetpipe.polygon.outline import Outline, as_rings, even_odd, load_shapely

if TYPE_CHECKING:
    import shapely

Method: TypeAlias = Literal["kernel", "discrete", "hv"]
"""Kernel dilatation (§5), shrinking of pixel shapes (§2), h-v convexity (§3)."""

Search: TypeAlias = Literal["heuristic", "complete", "stopped"]
"""How far a result is known to be the best: not at all; the best of its method, all choices
having been looked at; or the best of those looked at when the steps ran out."""

_RESOLUTION: dict[str, int] = {"discrete": 192, "hv": 40}
_FINEST = 1536
_HV_STEPS = 20_000


def largest_convex_subset(
    outline: Outline, method: Method = "kernel", *, resolution: int | None = None
) -> shapely.Polygon:
    """A convex polygon of large area inside an outline.

    ``kernel`` (§5): reflex vertices are taken in the order in which the
    growing kernel meets them; each gets the extremal, single-pivot or
    double-pivot chord that costs least. It is a heuristic: Theorem 4 says that
    the kernel lies in the optimum, nothing bounds the distance to it. Outlines
    that are not star-shaped, on which the paper is silent, are treated as
    follows: what a point sees is star-shaped, so the method runs on what the
    deepest point and the middles of the largest parts of an exact convex
    decomposition see, and the best result is kept; it is never smaller than
    the largest of those parts.

    ``discrete`` (§2): on pixels whose centres are inside; the result is the
    hull of the pixel centres found, cut to the outline.

    ``hv`` (§3): on pixels that are wholly inside; the result is a union of
    pixels that every horizontal and vertical line meets in one segment: h-v
    convex, not convex. The best union of regions within a bounded number of
    backtracking steps.

    Args:
        outline: a polygon, with or without holes.
        method: which of the three.
        resolution: pixels along the longest side, for the two pixel methods
            (default 192 and 40); doubled where the outline is too thin for it.

    Returns:
        A polygon that the outline contains, by shapely's exact predicate;
        :func:`convex_subset` says as well how good it is known to be.

    Raises:
        InputError: the outline is no polygon or too thin for the finest pixels.
        UsageError: an unknown method, or shapely is missing.
    """
    return convex_subset(outline, method, resolution=resolution).polygon


@dataclass(frozen=True)
class ConvexSubset:
    """A large convex set inside an outline.

    Attributes:
        polygon: what :func:`largest_convex_subset` returns.
        search: ``"heuristic"`` for ``kernel`` and ``discrete``, of which nothing is known;
            for ``hv``, at its resolution, ``"complete"`` if the backtracking of §3 ended, so
            that no union of its regions is larger, and ``"stopped"`` if its steps ran out.
    """

    polygon: shapely.Polygon
    search: Search


def convex_subset(
    outline: Outline, method: Method = "kernel", *, resolution: int | None = None
) -> ConvexSubset:
    """As :func:`largest_convex_subset`, with how far the result is known to be the best.

    Args:
        outline: a polygon, with or without holes.
        method: ``"kernel"``, ``"discrete"`` or ``"hv"``.
        resolution: pixels along the longest side, for the two pixel methods.

    Raises:
        InputError: the outline is no polygon or too thin for the finest pixels.
        UsageError: an unknown method, or shapely is missing.
    """
    if method not in get_args(Method):
        raise UsageError(unknown_name("method", method, get_args(Method)))
    load_shapely()
    rings = as_rings(outline)
    region = even_odd(rings)
    if method == "kernel":
        ring, _ = _core.convex_subset_polygon(rings)
        return ConvexSubset(_settled(region, ring), "heuristic")
    pixels = resolution or _RESOLUTION[method]
    if pixels < 2:
        raise UsageError(f"resolution must be at least 2, got {pixels}")
    while True:
        found = (_discrete if method == "discrete" else _hv)(region, pixels)
        if found is not None:
            return found
        if pixels >= _FINEST:
            raise InputError(f"the outline is too thin for {pixels} pixels along its longest side")
        pixels *= 2


def _settled(region: Any, ring: NDArray[np.float64]) -> Any:
    """The convex ``ring``, shrunk about its middle by as few ulps as make it lie inside."""
    shapely = load_shapely()
    shapely.prepare(region)
    polygon = shapely.Polygon(ring).convex_hull
    shrink = 0.0
    while not (polygon.geom_type == "Polygon" and region.contains(polygon)):
        shrink = 4.0 * shrink or 2.0**-52
        if shrink > 2.0**-20:
            raise InputError("no convex subset was found: the outline has parts without width")
        middle = ring.mean(axis=0)
        polygon = shapely.Polygon(middle + (1.0 - shrink) * (ring - middle)).convex_hull
    return polygon


def _grid(region: Any, pixels: int) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    x0, y0, x1, y1 = region.bounds
    side = max(x1 - x0, y1 - y0) / pixels
    columns = np.arange(max(1, round((x1 - x0) / side)))
    rows = np.arange(max(1, round((y1 - y0) / side)))
    return x0 + (columns + 0.5) * side, y0 + (rows + 0.5) * side, side


def _discrete(region: Any, pixels: int) -> ConvexSubset | None:
    shapely = load_shapely()
    x, y, _ = _grid(region, pixels)
    grid_x, grid_y = np.meshgrid(x, y)
    inside = np.ascontiguousarray(shapely.contains_xy(region, grid_x, grid_y), dtype=bool)
    if not inside.any():
        return None
    kept = _core.convex_pixels(inside, 8)
    centres = np.column_stack([grid_x[kept], grid_y[kept]])
    hull = shapely.MultiPoint(centres).convex_hull
    if hull.geom_type != "Polygon":
        return None
    if region.contains(hull):
        return ConvexSubset(hull, "heuristic")
    # between the centres the outline may dip into the hull by less than a pixel
    common = region.intersection(hull)
    pieces = [g for g in getattr(common, "geoms", [common]) if g.geom_type == "Polygon"]
    if not pieces:
        return None
    found = largest_convex_subset(max(pieces, key=lambda piece: piece.area))
    inner = _settled(region, np.array(found.exterior.coords[:-1]))
    return ConvexSubset(inner, "heuristic")


def _hv(region: Any, pixels: int) -> ConvexSubset | None:
    shapely = load_shapely()
    x, y, side = _grid(region, pixels)
    # edges are shared to the bit between neighbours, so that the union has no cracks
    left, low = x[0] - side / 2, y[0] - side / 2
    at_x = left + side * np.arange(len(x) + 1)
    at_y = low + side * np.arange(len(y) + 1)
    cells = shapely.box(*np.meshgrid(at_x[:-1], at_y[:-1]), *np.meshgrid(at_x[1:], at_y[1:]))
    shapely.prepare(region)
    inside = np.ascontiguousarray(shapely.contains(region, cells), dtype=bool)
    if not inside.any():
        return None
    found, _, optimal = _core.hv_convex_pixels(inside, _HV_STEPS)
    return ConvexSubset(shapely.union_all(cells[found]), "complete" if optimal else "stopped")
