"""Non-manifold edges and vertices taken apart."""

from __future__ import annotations

import numpy as np

from assetpipe.geometry.health.topology import Edges, umbrellas
from assetpipe.geometry.mesh import FloatArray, IntArray
from assetpipe.geometry.repair.subdivide import insert_on_edges


def pair_half_edges(vertices: FloatArray, edges: Edges) -> tuple[IntArray, IntArray]:
    """Pair half-edges over each edge so that material lies between the two faces.

    Edges with two faces of consistent winding have one pairing. Around an edge with
    more, going with the right hand about its direction, a face running *against* the
    direction opens material and one running *with* it closes it; these are matched
    like brackets. What finds no partner stays boundary.
    """
    first, second = edges.pair(edges.regular)
    if not len(edges.nonmanifold):
        return first, second
    more = _brackets(vertices, edges)
    return np.concatenate([first, more[:, 0]]), np.concatenate([second, more[:, 1]])


def by_angle(vertices: FloatArray, edges: Edges, chosen: IntArray) -> tuple[IntArray, IntArray]:
    """Half-edges around each of ``chosen`` edges, by angle.

    The angle is the right-hand one about the direction from the edge's first to its
    second end. A face whose half-edge runs that way has its outside ahead.

    Returns:
        Half-edges, those of one edge side by side, and the index in ``chosen`` of each.
    """
    counts = edges.count[chosen]
    owner = np.repeat(np.arange(len(chosen)), counts)
    offset = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    half = edges.order[edges.first[chosen][owner] + offset]
    low, high = edges.ends[chosen].T
    axis = vertices[high] - vertices[low]
    axis /= np.maximum(np.linalg.norm(axis, axis=1), np.finfo(float).tiny)[:, None]
    helper = np.eye(3)[np.argmin(np.abs(axis), axis=1)]
    u = np.cross(axis, helper)
    u /= np.maximum(np.linalg.norm(u, axis=1), np.finfo(float).tiny)[:, None]
    v = np.cross(axis, u)
    arm = vertices[edges.apex(half)] - vertices[low][owner]
    angle = np.arctan2((arm * v[owner]).sum(axis=1), (arm * u[owner]).sum(axis=1))
    # At equal angles an opening face comes first: material of no thickness between them.
    order = np.lexsort((half, edges.forward[half], angle, owner))
    return half[order], owner[order]


def _brackets(vertices: FloatArray, edges: Edges) -> IntArray:
    """(k, 2) pairs of half-edges over the edges with more than two faces."""
    many = edges.nonmanifold
    half, owner = by_angle(vertices, edges, many)
    closes = edges.forward[half]
    starts = np.searchsorted(owner, np.arange(len(many) + 1))
    pairs: list[tuple[int, int]] = []
    for i in range(len(many)):
        run = slice(int(starts[i]), int(starts[i + 1]))
        pairs.extend(_match(half[run].tolist(), closes[run].tolist()))
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


def _match(half: list[int], closes: list[bool]) -> list[tuple[int, int]]:
    """Match opening with closing brackets around a circle."""
    pairs: list[tuple[int, int]] = []
    waiting: list[int] = []
    untouched = [True] * len(half)
    # Twice around, so that an opening late in the circle meets a closing early in it.
    for i in (*range(len(half)), *range(len(half))):
        if not untouched[i]:
            continue
        if not closes[i]:
            waiting.append(i)
            untouched[i] = False
        elif waiting:
            pairs.append((half[waiting.pop()], half[i]))
            untouched[i] = False
    return pairs


def split_nonmanifold(vertices: FloatArray, faces: IntArray) -> tuple[FloatArray, IntArray, int]:
    """Copy vertices until every edge has at most two faces and every vertex one umbrella.

    Where two surfaces touch along an edge and go together around both its ends, copies
    of the ends are not enough: one of them gets a vertex at the middle of the edge. Only
    that moves the surface, by rounding.

    Returns:
        Vertices, faces, and how many vertices were added.
    """
    edges = Edges.of(faces, len(vertices))
    first, second = pair_half_edges(vertices, edges)
    number, corners = umbrellas(faces, first, second)
    if number == len(vertices) and not len(edges.nonmanifold):
        return vertices, faces, 0
    source = np.zeros(number, dtype=np.int64)
    source[corners.ravel()] = faces.ravel()
    # Vertices keep their place in the order; copies come last.
    _, lead = np.unique(source, return_index=True)
    original = np.zeros(number, dtype=bool)
    original[lead] = True
    rank = np.empty(number, dtype=np.int64)
    rank[lead] = np.arange(len(lead))
    rank[~original] = len(lead) + np.arange(number - len(lead))
    order = np.argsort(rank, kind="stable")
    apart, faces = vertices[source[order]], rank[corners]
    apart, faces = _halve_touching(apart, faces, first, second)
    return apart, faces, len(apart) - len(vertices)


def _halve_touching(
    vertices: FloatArray, faces: IntArray, first: IntArray, second: IntArray
) -> tuple[FloatArray, IntArray]:
    """Give surfaces that still share an edge with others a middle vertex of their own."""
    edges = Edges.of(faces, len(vertices))
    if not len(edges.nonmanifold):
        return vertices, faces
    partner = np.full(faces.size, -1, dtype=np.int64)
    partner[first], partner[second] = second, first
    points: dict[int, list[int]] = {}
    new: list[FloatArray] = []
    for edge in edges.nonmanifold.tolist():
        half = edges.order[edges.first[edge] : edges.first[edge + 1]].tolist()
        stays = {half[0], int(partner[half[0]])}
        middle = vertices[edges.ends[edge]].mean(axis=0)
        for h in half:
            if h in stays or h in points:
                continue
            points[h] = [len(vertices) + len(new)]
            if partner[h] >= 0:
                points[int(partner[h])] = points[h]
            new.append(middle)
    return np.concatenate([vertices, np.array(new)]), insert_on_edges(faces, points)
