"""Exact weld, and the faces that stand for nothing."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from assetpipe.geometry.health.topology import Edges, components
from assetpipe.geometry.health.weld import degenerate, exact_duplicates, referenced
from assetpipe.geometry.mesh import FloatArray, IntArray
from assetpipe.geometry.repair.surface import Corners, no_corners


@dataclass(frozen=True, eq=False)
class Cleaned:
    """Arrays after a cleaning step, and how many elements it took away."""

    vertices: FloatArray
    faces: IntArray
    welded: int = 0
    degenerate: int = 0
    duplicate: int = 0
    gone: Corners = field(default_factory=no_corners)


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
    """Drop faces over the same vertices as others, where that leaves less open.

    Surplus faces (copies, or pairs of opposite winding) are judged by connected piece:
    a piece goes if fewer edges are unbalanced without it, and stays if it makes no
    difference, as where two closed bodies share a face.
    """
    group, groups, winds = _same_corners(faces)
    if groups == len(faces):
        return Cleaned(vertices, faces)
    first = np.full(groups, len(faces), dtype=np.int64)
    np.minimum.at(first, group, np.arange(len(faces)))
    copies = np.flatnonzero(first[group] != np.arange(len(faces)))
    # Alternatives, the gentlest first: drop what is surplus, drop pairs that cancel.
    same = copies[winds[copies] == winds[first[group[copies]]]]
    opposite = copies[winds[copies] != winds[first[group[copies]]]]
    gone = np.zeros(len(faces), dtype=bool)
    edges = Edges.of(faces, len(vertices))
    balance = edges.balance.copy()
    balance = _judge(edges, balance, gone, same)
    balance = _judge(edges, balance, gone, opposite)
    partners = np.unique(np.concatenate([opposite, first[group[opposite]]]))
    balance = _judge(edges, balance, gone, partners[~gone[partners]])
    if not gone.any():
        return Cleaned(vertices, faces)
    result = vertices[faces[gone]]
    kept, left = referenced(vertices, faces[~gone])
    return Cleaned(kept, left, duplicate=int(gone.sum()), gone=result)


def one_of_each(faces: IntArray) -> IntArray:
    """Faces, the first of those over the same vertices only."""
    group, groups, _ = _same_corners(faces)
    if groups == len(faces):
        return faces
    first = np.full(groups, len(faces), dtype=np.int64)
    np.minimum.at(first, group, np.arange(len(faces)))
    return faces[np.sort(first)]


def _same_corners(faces: IntArray) -> tuple[IntArray, int, IntArray]:
    """(m,) group of faces over the same vertices, how many, and (m,) winding, 1 or -1."""
    order = np.sort(faces, axis=1)
    by_corners = np.lexsort((order[:, 2], order[:, 1], order[:, 0]))
    ordered = order[by_corners]
    new = np.ones(len(faces), dtype=bool)
    new[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    group = np.empty(len(faces), dtype=np.int64)
    group[by_corners] = np.cumsum(new) - 1
    # An even permutation of the sorted corners winds one way, an odd one the other.
    inversions = (
        (faces[:, 0] > faces[:, 1]).astype(np.int64)
        + (faces[:, 0] > faces[:, 2])
        + (faces[:, 1] > faces[:, 2])
    )
    return group, int(new.sum()), 1 - 2 * (inversions % 2)


def _judge(
    edges: Edges, balance: IntArray, gone: npt.NDArray[np.bool_], surplus: IntArray
) -> IntArray:
    """Mark connected pieces of surplus faces as gone if that leaves fewer edges unbalanced."""
    if not len(surplus):
        return balance
    edge = edges.edge_of.reshape(-1, 3)[surplus]
    sign = np.where(edges.forward, 1, -1).reshape(-1, 3)[surplus]
    owner = np.repeat(np.arange(len(surplus)), 3)
    order = np.argsort(edge.ravel(), kind="stable")
    linked = np.flatnonzero(edge.ravel()[order][1:] == edge.ravel()[order][:-1])
    number, piece = components(len(surplus), owner[order][linked], owner[order][linked + 1])
    # The sum of each piece's half-edges over each of its edges.
    key = piece[owner] * np.int64(len(balance)) + edge.ravel()
    which, at = np.unique(key, return_inverse=True)
    change = np.bincount(at.ravel(), sign.ravel(), len(which)).astype(np.int64)
    of_piece, of_edge = which // len(balance), which % len(balance)
    before, after = np.abs(balance[of_edge]), np.abs(balance[of_edge] - change)
    gain = np.bincount(of_piece, before - after, number)
    go = gain > 0.0
    gone[surplus[go[piece]]] = True
    result: IntArray = balance.copy()
    np.subtract.at(result, of_edge[go[of_piece]], change[go[of_piece]])
    return result
