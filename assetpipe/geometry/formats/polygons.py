"""Polygons, strips and fans to triangles, right for concave ones too.

Most readers cut a polygon into a fan, which folds over where the polygon is concave.
Convex polygons become fans here as well; concave ones go through manifold3d's ear clipping
in the plane of their Newell normal.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from assetpipe.geometry.mesh import FloatArray, IntArray

_FLAT = 1e-9
"""Share of the squared size of a polygon below which a corner counts as straight."""


def triangulated(points: FloatArray, corners: IntArray, counts: IntArray) -> IntArray:
    """Cut polygons into triangles.

    Args:
        points: (n, 3) coordinates.
        corners: the polygons' point indices, one polygon after the other.
        counts: the number of corners of each polygon; those with fewer than three are dropped.

    Returns:
        (m, 3) triangles in the order of their polygons, winding kept.
    """
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]]) if len(counts) else counts
    keys: list[IntArray] = []
    triangles: list[IntArray] = []
    for size in np.unique(counts):
        if size < 3:
            continue
        where = np.flatnonzero(counts == size)
        loops = corners[starts[where, None] + np.arange(size)]
        fans = np.stack(
            [np.repeat(loops[:, :1], size - 2, axis=1), loops[:, 1:-1], loops[:, 2:]], axis=2
        )
        if size > 3:
            for row in np.flatnonzero(_concave(points[loops])):
                cut = _ears(points[loops[row]])
                if cut is not None:
                    fans[row] = loops[row][cut]
        keys.append(np.repeat(where, size - 2))
        triangles.append(fans.reshape(-1, 3))
    if not triangles:
        return np.zeros((0, 3), dtype=np.int64)
    order = np.argsort(np.concatenate(keys), kind="stable")
    return np.concatenate(triangles)[order].astype(np.int64)


def strip_triangles(corners: IntArray) -> IntArray:
    """(n - 2, 3) triangles of a strip; every second one is turned."""
    if len(corners) < 3:
        return np.zeros((0, 3), dtype=np.int64)
    rows = np.stack([corners[:-2], corners[1:-1], corners[2:]], axis=1)
    rows[1::2, :2] = rows[1::2, 1::-1]
    return rows


def fan_triangles(corners: IntArray) -> IntArray:
    """(n - 2, 3) triangles of a fan around its first corner."""
    if len(corners) < 3:
        return np.zeros((0, 3), dtype=np.int64)
    first = np.full(len(corners) - 2, corners[0])
    return np.stack([first, corners[1:-1], corners[2:]], axis=1)


def _newell(loops: FloatArray) -> FloatArray:
    """(p, 3) area vectors of (p, k, 3) polygons (Sutherland, Evans' polygon normal by Newell)."""
    local = loops - loops[:, :1]
    area: FloatArray = np.cross(local, np.roll(local, -1, axis=1)).sum(axis=1) / 2.0
    return area


def _concave(loops: FloatArray) -> npt.NDArray[np.bool_]:
    """Which of the (p, k, 3) polygons turn the other way at some corner."""
    normal = _newell(loops)
    ahead = np.roll(loops, -1, axis=1) - loops
    turn = np.einsum("pki,pi->pk", np.cross(np.roll(ahead, 1, axis=1), ahead), normal)
    size = np.ptp(loops, axis=1).max(axis=1) ** 2
    limit = -_FLAT * size * np.linalg.norm(normal, axis=1)
    result: npt.NDArray[np.bool_] = turn.min(axis=1) < limit
    return result


def _ears(loop: FloatArray) -> IntArray | None:
    """Triangles of one polygon by ear clipping, or ``None`` where it has no plane."""
    import manifold3d

    normal = _newell(loop[None])[0]
    length = float(np.linalg.norm(normal))
    if not np.isfinite(length) or length == 0.0:
        return None
    axis = int(np.abs(normal).argmax())
    u, v = (axis + 1) % 3, (axis + 2) % 3
    flat = loop[:, [u, v]] if normal[axis] > 0 else loop[:, [v, u]]
    cut = np.asarray(manifold3d.triangulate([np.ascontiguousarray(flat)]), dtype=np.int64)
    return cut if len(cut) == len(loop) - 2 else None
