"""Exact weld, and the faces that stand for nothing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from assetpipe.geometry.health.topology import Edges
from assetpipe.geometry.health.weld import degenerate, exact_duplicates, referenced
from assetpipe.geometry.mesh import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Cleaned:
    """Arrays after a cleaning step, and how many elements it took away."""

    vertices: FloatArray
    faces: IntArray
    welded: int = 0
    degenerate: int = 0
    duplicate: int = 0


def weld_exactly(vertices: FloatArray, faces: IntArray) -> Cleaned:
    """Join vertices with the same coordinates; drop faces that thereby lose a corner."""
    keep, to = exact_duplicates(vertices)
    if len(keep) < len(vertices):
        welded = len(vertices) - len(keep)
        vertices, faces = vertices[keep], to[faces]
    else:
        welded = 0
    bad = degenerate(faces)
    if len(bad):
        faces = np.delete(faces, bad, axis=0)
    vertices, faces = referenced(vertices, faces)
    return Cleaned(vertices, faces, welded=welded, degenerate=len(bad))


def drop_duplicates(vertices: FloatArray, faces: IntArray) -> Cleaned:
    """Keep one of the faces over the same three vertices.

    Faces of the same winding are copies: one stays. Faces of opposite windings enclose
    nothing between them: they cancel, unless the mesh is two-sided throughout (every
    face drawn from both sides), where cancelling would leave nothing; then the first
    of each pair stays.
    """
    order = np.sort(faces, axis=1)
    by_corners = np.lexsort((order[:, 2], order[:, 1], order[:, 0]))
    ordered = order[by_corners]
    new = np.ones(len(faces), dtype=bool)
    new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    if new.all():
        return Cleaned(vertices, faces)
    group = np.empty(len(faces), dtype=np.int64)
    group[by_corners] = np.cumsum(new) - 1
    # An even permutation of the sorted corners winds one way, an odd one the other.
    inversions = (
        (faces[:, 0] > faces[:, 1]).astype(np.int64)
        + (faces[:, 0] > faces[:, 2])
        + (faces[:, 1] > faces[:, 2])
    )
    winds = 1 - 2 * (inversions % 2)
    groups = int(new.sum())
    forward = np.bincount(group[winds > 0], minlength=groups)
    backward = np.bincount(group[winds < 0], minlength=groups)
    cancel = (forward > 0) & (backward > 0)
    # Of each group the first face that winds as the majority does (ties: the first face).
    majority = np.where(forward > backward, 1, np.where(backward > forward, -1, 0))
    candidate = np.flatnonzero((majority[group] == 0) | (majority[group] == winds))
    firsts = np.full(groups, len(faces), dtype=np.int64)
    np.minimum.at(firsts, group[candidate], candidate)
    singly = firsts[~(cancel & (majority == 0))]
    once = np.sort(firsts)
    both = np.sort(singly)
    kept = _more_closed(faces, len(vertices), both, once)
    result = faces[kept]
    vertices, result = referenced(vertices, result)
    return Cleaned(vertices, result, duplicate=len(faces) - len(kept))


def _more_closed(faces: IntArray, vertices: int, a: IntArray, b: IntArray) -> IntArray:
    """Of two choices of faces the one with fewer unbalanced edges; a tie goes to the first."""
    if not len(a):
        return b
    if len(a) == len(b):
        return a

    def open_edges(kept: IntArray) -> int:
        return int(np.count_nonzero(Edges.of(faces[kept], vertices).balance))

    return a if open_edges(a) <= open_edges(b) else b
