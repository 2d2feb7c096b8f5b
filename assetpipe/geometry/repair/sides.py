"""Both sides of every face, joined around edges by angle.

Going around an edge, the side of one face that looks at the next is joined to that one's
side that looks back. Joined sides look into the same region of space, so that connected
sides bound a *cell*; at a rim the two sides of one face are in the same cell.
"""

from __future__ import annotations

import numpy as np

from assetpipe.geometry.health.topology import Edges
from assetpipe.geometry.mesh import FloatArray, IntArray
from assetpipe.geometry.repair.split import by_angle

_REVERSED = np.array([1, 0, 2])
"""Half-edge k of [a, b, c] is half-edge ``_REVERSED[k]`` of [c, b, a]."""


def two_sided(faces: IntArray) -> IntArray:
    """(2 m, 3): the faces as they are, then all of them reversed."""
    return np.concatenate([faces, faces[:, ::-1]])


def other_side(half: IntArray, faces: int) -> IntArray:
    """The half-edges of the reversed faces over half-edges of the faces as they are."""
    result: IntArray = 3 * (half // 3 + faces) + _REVERSED[half % 3]
    return result


def joined_sides(vertices: FloatArray, faces: IntArray, edges: Edges) -> tuple[IntArray, IntArray]:
    """Pairs of half-edges of ``two_sided(faces)`` that meet around edges.

    Every edge with two or more faces contributes; rims are left out. Paired half-edges run
    in opposite directions.
    """
    several = np.flatnonzero(edges.count > 1)
    half, owner = by_angle(vertices, edges, several)
    if not len(half):
        return half, half
    new = np.append(True, owner[1:] != owner[:-1])
    last = np.append(new[1:], True)
    # The next half-edge around the same edge, the first after the last.
    following = np.append(half[1:], half[0])
    following[last] = half[new]
    m = len(faces)
    ahead = np.where(edges.forward[half], half, other_side(half, m))
    behind = np.where(edges.forward[following], other_side(following, m), following)
    return ahead, behind


def rims(edges: Edges) -> IntArray:
    """Half-edges that are alone on their edge."""
    return edges.order[edges.first[edges.boundary]]
