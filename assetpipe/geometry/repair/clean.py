"""Exact weld, and the faces that stand for nothing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from assetpipe.geometry.health.weld import degenerate, exact_duplicates
from assetpipe.geometry.mesh import FloatArray, IntArray
from assetpipe.geometry.strays import referenced


@dataclass(frozen=True, eq=False)
class Cleaned:
    """Arrays after a cleaning step, and how many elements it took away."""

    vertices: FloatArray
    faces: IntArray
    welded: int = 0
    degenerate: int = 0
    repeated: int = 0


def weld_exactly(vertices: FloatArray, faces: IntArray) -> Cleaned:
    """Join vertices with the same coordinates; drop faces that lose a corner or are repeated."""
    keep, to = exact_duplicates(vertices)
    if len(keep) < len(vertices):
        welded = len(vertices) - len(keep)
        vertices, faces = vertices[keep], to[faces]
    else:
        welded = 0
    bad = degenerate(faces)
    if len(bad):
        faces = np.delete(faces, bad, axis=0)
    once = _without_repeats(faces)
    repeated = len(faces) - len(once)
    vertices, faces = referenced(vertices, once)
    return Cleaned(vertices, faces, welded, len(bad), repeated)


def _without_repeats(faces: IntArray) -> IntArray:
    """Faces, only the first of those over the same vertices that all wind the same way.

    Those that are there from both sides mean a sheet, and are left to later steps.
    """
    group, groups, winding = same_corners(faces)
    if groups == len(faces):
        return faces
    number = np.bincount(group, minlength=groups)
    agreed = np.abs(np.bincount(group, weights=winding, minlength=groups)) == number
    first = np.full(groups, len(faces), dtype=np.int64)
    np.minimum.at(first, group, np.arange(len(faces)))
    kept: IntArray = faces[(first[group] == np.arange(len(faces))) | ~agreed[group]]
    return kept


def one_of_each(faces: IntArray) -> IntArray:
    """Faces, only the first of those over the same vertices."""
    group, groups, _ = same_corners(faces)
    if groups == len(faces):
        return faces
    first = np.full(groups, len(faces), dtype=np.int64)
    np.minimum.at(first, group, np.arange(len(faces)))
    return faces[np.sort(first)]


def same_corners(faces: IntArray) -> tuple[IntArray, int, IntArray]:
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
