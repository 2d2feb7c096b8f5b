"""Approximate convex decomposition of polygons (Lien & Amato 2006)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, TypeAlias, get_args

from assetpipe import _core
from assetpipe.errors import UsageError, unknown_name
from assetpipe.polygon.outline import Outline, as_rings, as_shapely, load_shapely

if TYPE_CHECKING:
    import shapely

Concavity: TypeAlias = Literal["sl", "sp", "h1", "h2"]
"""How concavity is measured (§5.1): straight line, shortest path, hybrid 1, hybrid 2."""

HoleAxis: TypeAlias = Literal["principal", "medial"]
"""How the antipodal pair of a hole is found (§5.2.2)."""


@dataclass(frozen=True)
class PolygonDecomposition:
    """Parts of an outline: pairwise interior-disjoint, their union is the outline.

    Parts share the outline's vertices to the bit; no vertex is added. A part
    has holes only where the tolerance leaves them in.

    Attributes:
        parts: the parts.
        concavities: the concavity of each part, in the outline's unit.
        concavity: the largest of them.
        convexity: area of the parts over the area of their convex hulls (Eq. 9).
        tolerance: the tolerance they were asked for.
        measure: how concavity was measured.
    """

    parts: tuple[shapely.Polygon, ...]
    concavities: tuple[float, ...]
    concavity: float
    convexity: float
    tolerance: float
    measure: Concavity
    _levels: _core.PolygonHierarchy = field(repr=False, compare=False)
    _finest: float = field(repr=False, compare=False)

    def at(self, tolerance: float) -> PolygonDecomposition:
        """The decomposition at a coarser tolerance, read from the hierarchy.

        It equals what :func:`decompose` gives for that tolerance, except with
        ``h2``, whose measure itself depends on the tolerance.

        Raises:
            UsageError: the tolerance is finer than the one computed.
        """
        if not tolerance >= self._finest:
            raise UsageError(
                f"tolerance {tolerance} is finer than {self._finest}, for which this was computed"
            )
        return _read(self._levels, tolerance, self.measure, self._finest)


def decompose(
    outline: Outline,
    tolerance: float,
    *,
    concavity: Concavity = "sp",
    hole_axis: HoleAxis | None = None,
    s_c: float = 0.1,
    s_d: float = 1.0,
) -> PolygonDecomposition:
    """Decompose an outline into parts of concavity at most ``tolerance`` (Algorithm 4.1).

    Args:
        outline: a simple polygon with holes. Duplicate vertices, collinear
            runs, and rings that touch each other are fine; edges may not cross.
        tolerance: τ in the outline's unit; 0 gives an exact convex
            decomposition (Lemma 6.3, Theorem 6.4).
        concavity: the measure. ``sp`` and ``h1`` never grow while parts are
            cut (Lemma 5.3); ``sl`` and ``h2`` may.
        hole_axis: how holes are measured; by default the principal axis for
            ``sl`` and the medial axis otherwise, as §5.2.2 advises.
        s_c: weight of the far end's concavity in Eq. 8.
        s_d: weight of the diagonal's length in Eq. 8.

    Raises:
        InputError: edges cross, a coordinate is not finite, or there is no area.
        UsageError: an unknown name or a parameter out of range, or shapely is missing.
    """
    load_shapely()
    if concavity not in get_args(Concavity):
        raise UsageError(unknown_name("concavity", concavity, get_args(Concavity)))
    if hole_axis is not None and hole_axis not in get_args(HoleAxis):
        raise UsageError(unknown_name("hole axis", hole_axis, get_args(HoleAxis)))
    axis = hole_axis or ("principal" if concavity == "sl" else "medial")
    levels = _core.decompose_polygon(
        as_rings(outline), float(tolerance), concavity, axis, (float(s_c), float(s_d))
    )
    return _read(levels, float(tolerance), concavity, float(tolerance))


def _read(
    levels: _core.PolygonHierarchy, tolerance: float, measure: Concavity, finest: float
) -> PolygonDecomposition:
    parts, convexity = levels.at(tolerance)
    concavities = tuple(value for _, value in parts)
    return PolygonDecomposition(
        parts=tuple(as_shapely(rings) for rings, _ in parts),
        concavities=concavities,
        concavity=max(concavities),
        convexity=convexity,
        tolerance=tolerance,
        measure=measure,
        _levels=levels,
        _finest=finest,
    )
