"""Vertices put onto edges."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from assetpipe.geometry.health.topology import distinct
from assetpipe.geometry.mesh import IntArray


def insert_on_edges(faces: IntArray, points: Mapping[int, Sequence[int]]) -> IntArray:
    """Put vertices onto half-edges and triangulate the faces anew.

    Args:
        faces: (m, 3).
        points: for a half-edge ``3 f + k`` the vertices to put onto it, in its direction.

    Returns:
        Faces; untouched ones first, in their order. Faces around the same point on
        several half-edges meet there.
    """
    touched = distinct(np.fromiter((half // 3 for half in points), dtype=np.int64))
    pieces: list[tuple[int, int, int]] = []
    for f in touched.tolist():
        a, b, c = faces[f].tolist()
        pieces += _fan((a, b, c), *(tuple(points.get(3 * f + k, ())) for k in range(3)))
    rest = np.delete(faces, touched, axis=0)
    return np.concatenate([rest, np.array(pieces, dtype=np.int64).reshape(-1, 3)])


def _fan(
    face: tuple[int, int, int], ab: tuple[int, ...], bc: tuple[int, ...], ca: tuple[int, ...]
) -> list[tuple[int, int, int]]:
    """Fan the points of one edge from the corner opposite, then the next edge's."""
    a, b, c = face
    if ab:
        chain = (a, *ab, b)
        result = []
        for i in range(len(chain) - 1):
            right = bc if i == len(chain) - 2 else ()
            left = ca if i == 0 else ()
            result += _fan((chain[i], chain[i + 1], c), (), right, left)
        return result
    if bc:
        return _fan((b, c, a), bc, ca, ab)
    if ca:
        return _fan((c, a, b), ca, ab, bc)
    return [face]
