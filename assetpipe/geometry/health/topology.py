"""Edges, components and umbrellas of a triangle mesh, all at once in numpy.

A *half-edge* ``3 f + k`` runs from corner ``k`` of face ``f`` to the next corner.
All half-edges over the same two vertices form one undirected *edge*.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from assetpipe.errors import EngineError
from assetpipe.geometry.mesh import FloatArray, IntArray

BoolArray = npt.NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Edges:
    """Half-edges of ``faces`` grouped by undirected edge.

    Attributes:
        faces: (m, 3) vertex indices.
        vertices: how many vertices the mesh has.
        order: (3 m,) half-edges, those of one edge side by side.
        first: (e + 1,) where each edge's half-edges begin in ``order``.
        ends: (e, 2) vertex indices of each edge, the smaller first.
        balance: (e,) half-edges that run from the smaller to the larger vertex,
            less those that run back. Zero everywhere: the mesh is a closed chain.
    """

    faces: IntArray
    vertices: int
    order: IntArray
    first: IntArray
    ends: IntArray
    balance: IntArray

    @classmethod
    def of(cls, faces: IntArray, vertices: int) -> Edges:
        """Group the half-edges of (m, 3) ``faces``; degenerate faces must be gone."""
        start = faces.ravel()
        end = np.roll(faces, -1, axis=1).ravel()
        low, high = np.minimum(start, end), np.maximum(start, end)
        key = low * np.int64(max(vertices, 1)) + high
        order = np.argsort(key, kind="stable")
        ordered = key[order]
        new = np.ones(len(key), dtype=bool)
        new[1:] = ordered[1:] != ordered[:-1]
        first = np.append(np.flatnonzero(new), len(key)).astype(np.int64)
        lead = order[first[:-1]]
        ends = np.stack([low[lead], high[lead]], axis=1)
        sign = np.where(start < end, 1, -1)[order]
        balance = np.add.reduceat(sign, first[:-1]) if len(lead) else np.zeros(0, dtype=np.int64)
        return cls(faces, vertices, order, first, ends, balance)

    @cached_property
    def count(self) -> IntArray:
        """(e,) how many half-edges each edge has."""
        return np.diff(self.first)

    @cached_property
    def edge_of(self) -> IntArray:
        """(3 m,) the edge of each half-edge."""
        result = np.empty(len(self.order), dtype=np.int64)
        result[self.order] = np.repeat(np.arange(len(self.count)), self.count)
        return result

    @cached_property
    def forward(self) -> BoolArray:
        """(3 m,) whether each half-edge runs from the smaller to the larger vertex."""
        result: BoolArray = (self.faces < np.roll(self.faces, -1, axis=1)).ravel()
        return result

    @cached_property
    def boundary(self) -> IntArray:
        """Edges with one face only."""
        return np.flatnonzero(self.count == 1)

    @cached_property
    def nonmanifold(self) -> IntArray:
        """Edges with more than two faces."""
        return np.flatnonzero(self.count > 2)

    @cached_property
    def inconsistent(self) -> IntArray:
        """Edges whose two faces run along them in the same direction."""
        return np.flatnonzero((self.count == 2) & (self.balance != 0))

    @cached_property
    def regular(self) -> IntArray:
        """Edges with two faces of consistent winding."""
        return np.flatnonzero((self.count == 2) & (self.balance == 0))

    def apex(self, half: IntArray) -> IntArray:
        """The corner of each half-edge's face that is not on it."""
        result: IntArray = self.faces.ravel()[np.where(half % 3 == 0, half + 2, half - 1)]
        return result

    def pair(self, edges: IntArray) -> tuple[IntArray, IntArray]:
        """The two half-edges of each of ``edges``, which must have exactly two."""
        at = self.first[edges]
        return self.order[at], self.order[at + 1]


def distinct(values: IntArray) -> IntArray:
    """The different values in ascending order; numpy's own hashing is slow for indices."""
    ordered = np.sort(values, axis=None)
    new = np.ones(len(ordered), dtype=bool)
    new[1:] = ordered[1:] != ordered[:-1]
    result: IntArray = ordered[new]
    return result


def missing(values: IntArray, known: IntArray) -> IntArray:
    """The different values that are not among ``known``, which ascend."""
    candidates = distinct(values)
    if not len(known):
        return candidates
    at = np.minimum(np.searchsorted(known, candidates), len(known) - 1)
    result: IntArray = candidates[known[at] != candidates]
    return result


def face_components(edges: Edges) -> tuple[int, IntArray]:
    """Components of faces that share an edge: how many, and (m,) labels.

    Labels count up in the order of each component's first face.
    """
    faces = len(edges.faces)
    ordered = edges.order // 3
    inner = np.ones(len(ordered), dtype=bool)
    inner[edges.first[:-1]] = False
    there = np.flatnonzero(inner)
    return components(faces, ordered[there - 1], ordered[there])


def components(nodes: int, a: IntArray, b: IntArray) -> tuple[int, IntArray]:
    """Components of a graph with links ``a[i] – b[i]``, labelled by first appearance."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    if nodes == 0:
        return 0, np.zeros(0, dtype=np.int64)
    graph = coo_array((np.ones(len(a), dtype=np.int8), (a, b)), shape=(nodes, nodes)).tocsr()
    number, labels = connected_components(graph, directed=False)
    _, seen = np.unique(labels, return_index=True)
    rank = np.empty(number, dtype=np.int64)
    rank[np.argsort(seen, kind="stable")] = np.arange(number)
    return int(number), rank[labels]


def umbrellas(faces: IntArray, a: IntArray, b: IntArray) -> tuple[int, IntArray]:
    """Corners glued along paired half-edges ``a[i] – b[i]``: how many, and (m, 3) labels.

    Two faces glued along an edge share its two corners and nothing else, so that the
    labels are the vertices of the surface which the pairing describes: non-manifold
    edges and vertices come apart. Paired half-edges may run either way.
    """
    following_a, following_b = _following(a), _following(b)
    same_way = faces.ravel()[a] == faces.ravel()[b]
    number, labels = components(
        faces.size,
        np.concatenate([a, following_a]),
        np.concatenate([np.where(same_way, b, following_b), np.where(same_way, following_b, b)]),
    )
    return number, labels.reshape(faces.shape)


def _following(half_edges: IntArray) -> IntArray:
    """The next half-edge of the same face."""
    return np.where(half_edges % 3 == 2, half_edges - 2, half_edges + 1)


def boundary_loops(faces: IntArray, a: IntArray, b: IntArray) -> list[IntArray]:
    """Closed chains of half-edges that a pairing ``a[i] – b[i]`` leaves without partner.

    Each runs against the winding of its faces: a cap over a loop has the loop's own
    direction. Every half-edge without partner is in exactly one loop.

    Returns:
        For each loop the *ends* of its half-edges, as vertex indices.
    """
    alone = np.ones(faces.size, dtype=bool)
    alone[a] = False
    alone[b] = False
    half = np.flatnonzero(alone)
    if not len(half):
        return []
    number, corners = umbrellas(faces, a, b)
    start, end = corners.ravel()[half], corners.ravel()[_following(half)]
    # An umbrella that is not closed has one half-edge that leaves and one that arrives.
    arriving = np.full(number, -1, dtype=np.int64)
    arriving[end] = np.arange(len(half))
    before = arriving[start]
    _, label = components(len(half), np.arange(len(half)), before)
    _, heads = np.unique(label, return_index=True)
    vertex = faces.ravel()[_following(half)]
    loops = []
    for head in np.sort(heads):
        loop = [int(head)]
        while (at := int(before[loop[-1]])) != loop[0]:
            if at < 0 or len(loop) > len(half):
                raise EngineError("boundary half-edges do not form loops")
            loop.append(at)
        loops.append(vertex[loop])
    return loops


def face_areas(vertices: FloatArray, faces: IntArray) -> tuple[FloatArray, FloatArray]:
    """(m,) areas and (m, 3) area-weighted normals (twice the area long)."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    areas: FloatArray = np.linalg.norm(normals, axis=1) / 2.0
    return areas, normals


def unit_normals(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """(m, 3) unit normals; almost zero for faces without area."""
    areas, normals = face_areas(vertices, faces)
    result: FloatArray = normals / np.maximum(2.0 * areas, np.finfo(float).tiny)[:, None]
    return result


def groups(label: IntArray, number: int) -> list[IntArray]:
    """The indices with each label."""
    order = np.argsort(label, kind="stable")
    bounds = np.searchsorted(label[order], np.arange(number + 1))
    return [order[bounds[k] : bounds[k + 1]] for k in range(number)]
