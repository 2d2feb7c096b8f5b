"""Vertices that coincide exactly: finding and joining them."""

from __future__ import annotations

import numpy as np

from assetpipe.geometry.mesh import FloatArray, IntArray


def exact_duplicates(vertices: FloatArray) -> tuple[IntArray, IntArray]:
    """Bitwise equal points (0.0 equals -0.0): which to keep, and where each goes.

    Returns:
        ``keep``, the first index of each distinct point in ascending order, and ``to``,
        (n,) such that ``vertices[keep][to]`` are the same points.
    """
    bits = np.ascontiguousarray(vertices + 0.0).view(np.int64)
    order = np.lexsort((bits[:, 2], bits[:, 1], bits[:, 0]))
    ordered = bits[order]
    new = np.ones(len(vertices), dtype=bool)
    new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    # lexsort is stable: the first of a run is the smallest index.
    keep = np.sort(order[new])
    rank = np.empty(len(vertices), dtype=np.int64)
    rank[keep] = np.arange(len(keep))
    to = np.empty(len(vertices), dtype=np.int64)
    to[order] = rank[order[np.flatnonzero(new)]][np.cumsum(new) - 1]
    return keep, to


def degenerate(faces: IntArray) -> IntArray:
    """Indices of faces that name a vertex twice."""
    a, b, c = faces.T
    return np.flatnonzero((a == b) | (b == c) | (c == a))
