"""Pairs of faces that cross, and pairs of boxes that overlap."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from assetpipe.geometry.mesh import FloatArray, IntArray

_PAIRS = 12_000_000


def crossing_faces(
    vertices: FloatArray, faces: IntArray, *, pairs: int = _PAIRS, second: int | None = None
) -> IntArray | None:
    """(k, 2) pairs of faces that properly cross each other, the smaller index first.

    Faces that share an edge, touch, or overlap within one plane do not count: an edge of
    one must pass through the inside of the other. Faces that share one vertex count if
    the edge opposite to it does.

    Args:
        vertices: (n, 3).
        faces: (m, 3), none degenerate.
        pairs: how many pairs of overlapping boxes may be looked at.
        second: where the faces of a second surface begin: only pairs of both are looked for.

    Returns:
        The pairs, or ``None`` if more boxes overlap than ``pairs``.
    """
    from assetpipe import _core

    corners = vertices[faces]
    if not corners.size:
        return np.zeros((0, 2), dtype=np.int64)
    centre = (corners.min(axis=(0, 1)) + corners.max(axis=(0, 1))) / 2.0
    size = float(np.abs(corners - centre).max())
    if size == 0.0:
        return np.zeros((0, 2), dtype=np.int64)
    units = np.ascontiguousarray((vertices - centre) / size)
    return _core.crossings(units, np.ascontiguousarray(faces), pairs, second)


def overlapping_boxes(
    low: FloatArray, high: FloatArray, limit: int, second: int | None = None
) -> IntArray | None:
    """(k, 2) pairs of overlapping boxes, by a binary tree over the boxes in Morton order.

    Args:
        low: (n, 3) lowest corners.
        high: (n, 3) highest corners.
        limit: how many pairs may be looked at on one level of the tree.
        second: where a second set of boxes begins: only pairs of both are looked for.

    Returns:
        The pairs, or ``None`` if more boxes overlap than ``limit``.
    """
    number = len(low)
    order = _morton_order((low + high) / 2.0)
    depth = (max(1, number) - 1).bit_length()
    leaves = 1 << depth
    padded_low = np.full((leaves, 3), np.inf)
    padded_high = np.full((leaves, 3), -np.inf)
    padded_low[:number], padded_high[:number] = low[order], high[order]
    # Whether there are boxes of the first and of the second set below.
    sets = np.ones((leaves, 2), dtype=bool)
    if second is not None:
        sets[:number, 0] = order < second
        sets[:number, 1] = order >= second
    levels = [(padded_low, padded_high, sets)]
    while len(levels[-1][0]) > 1:
        a, b, below = levels[-1]
        levels.append(
            (np.minimum(a[::2], a[1::2]), np.maximum(b[::2], b[1::2]), below[::2] | below[1::2])
        )
    left = right = np.zeros(1, dtype=np.int64)
    for a, b, below in reversed(levels[:-1]):
        same = left == right
        pairs_left = np.concatenate([2 * left, 2 * left, 2 * left + 1, (2 * left + 1)[~same]])
        pairs_right = np.concatenate([2 * right, 2 * right + 1, 2 * right + 1, (2 * right)[~same]])
        if len(pairs_left) > limit:
            return None
        meet = (below[pairs_left] & below[pairs_right, ::-1]).any(axis=1)
        for axis in range(3):
            meet &= a[pairs_left, axis] <= b[pairs_right, axis]
            meet &= a[pairs_right, axis] <= b[pairs_left, axis]
        left, right = pairs_left[meet], pairs_right[meet]
    distinct = left != right
    return np.stack([order[left[distinct]], order[right[distinct]]], axis=1)


def _morton_order(points: FloatArray) -> IntArray:
    """Order along the Z curve."""
    low = points.min(axis=0)
    extent = max(float((points - low).max(initial=0.0)), np.finfo(float).tiny)
    cells = ((points - low) / extent * (2**20 - 1)).astype(np.uint64)
    code = np.zeros(len(points), dtype=np.uint64)
    for axis in range(3):
        code |= _spread(cells[:, axis]) << np.uint64(axis)
    return np.argsort(code, kind="stable")


def _spread(x: npt.NDArray[np.uint64]) -> npt.NDArray[np.uint64]:
    """Two zero bits between the bits of 21-bit numbers."""
    for shift, mask in (
        (32, 0x1F00000000FFFF),
        (16, 0x1F0000FF0000FF),
        (8, 0x100F00F00F00F00F),
        (4, 0x10C30C30C30C30C3),
        (2, 0x1249249249249249),
    ):
        x = (x | (x << np.uint64(shift))) & np.uint64(mask)
    return x
