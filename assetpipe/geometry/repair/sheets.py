"""Open surfaces given a thickness.

Both sides of every face are drawn apart, joined around edges as :mod:`sides` says; along
a rim a strip joins the two sides of the same face. The result is closed whatever the
number of faces at an edge and however they are wound, one-sided surfaces included.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from assetpipe.geometry.health.topology import (
    BoolArray,
    Edges,
    components,
    face_areas,
    groups,
    umbrellas,
)
from assetpipe.geometry.health.weld import degenerate
from assetpipe.geometry.mesh import FloatArray, IntArray
from assetpipe.geometry.repair.holes import cap, openings
from assetpipe.geometry.repair.sides import joined_sides, rims, two_sided
from assetpipe.geometry.repair.split import pair_half_edges, split_nonmanifold
from assetpipe.geometry.repair.surface import Corners, no_corners
from assetpipe.geometry.strays import referenced

_MITER = 3.0
_RANK = 0.02
_FOLD = 1e-3
"""Radians between two faces below which one lies on the other."""


@dataclass(frozen=True, eq=False)
class Slab:
    """A sheet with a thickness.

    Attributes:
        vertices: (n, 3).
        faces: (m, 3), closed, every edge with two faces.
        caps: triangles that close what the two sides and the strips between them do not.
        away: bound on how far any point of the other faces lies from the sheet.
    """

    vertices: FloatArray
    faces: IntArray
    caps: Corners
    away: float


def thicken(
    vertices: FloatArray,
    faces: IntArray,
    thickness: float,
    side: Literal["inward", "centred"],
) -> Slab:
    """A closed surface around a sheet.

    Args:
        vertices: (n, 3).
        faces: (m, 3), none degenerate.
        thickness: distance between the two sides of a plane sheet.
        side: ``"inward"`` leaves the surface where it is and puts the other side behind it;
            ``"centred"`` puts both half the thickness away.

    Returns:
        The slab. Where the sheet bends more sharply than the thickness allows it may cross
        itself nearby.
    """
    sides = two_sided(faces)
    edges = Edges.of(faces, len(vertices))
    number, corners = umbrellas(sides, *joined_sides(vertices, faces, edges))
    before = np.zeros(number, dtype=np.int64)
    before[corners.ravel()] = sides.ravel()
    outward = 0.0 if side == "inward" else thickness / 2.0
    offsets = np.repeat([outward, thickness - outward], len(faces))
    offset = _offset(vertices, sides, corners, offsets, number)
    moved = vertices[before] + offset
    strips = _strips(corners, rims(edges))
    closed = np.concatenate([corners, strips])
    closed = np.delete(closed, degenerate(closed), axis=0)
    caps = [cap(moved, opening) for opening in openings(moved, closed)]
    closed = np.concatenate([closed, *caps])
    closed = np.delete(closed, degenerate(closed), axis=0)
    whole = split_nonmanifold(*referenced(moved, closed))[:2]
    # A point of a face or strip has the same weights in the face or edge that it came from.
    away = float(np.linalg.norm(offset, axis=1).max(initial=0.0))
    return Slab(*whole, np.concatenate([no_corners(), *(moved[c] for c in caps)]), away)


def manifold_pieces(vertices: FloatArray, faces: IntArray) -> list[tuple[FloatArray, IntArray]]:
    """A complex cut where more than two faces meet, into pieces that have a side to each side.

    Around such an edge faces stay together in pairs, by angle and winding; two faces that
    meet alone stay together however they are wound. Faces folded flat onto each other come
    apart: their sides would take each other's thickness away.
    """
    edges = Edges.of(faces, len(vertices))
    first, second = pair_half_edges(vertices, edges)
    third, fourth = edges.pair(edges.inconsistent)
    a, b = np.concatenate([first, third]), np.concatenate([second, fourth])
    flat = _folded(vertices, faces, a, b)
    a, b = a[~flat], b[~flat]
    corners_number, corners = umbrellas(faces, a, b)
    source = np.zeros(corners_number, dtype=np.int64)
    source[corners.ravel()] = faces.ravel()
    number, label = components(len(faces), a // 3, b // 3)
    apart = vertices[source]
    return [referenced(apart, corners[chosen]) for chosen in groups(label, number)]


def _folded(vertices: FloatArray, faces: IntArray, first: IntArray, second: IntArray) -> BoolArray:
    """Whether the faces of two half-edges lie to the same side of their edge."""

    def arm(half: IntArray) -> FloatArray:
        """Away from the edge, in the face, unit length."""
        start, end, apex = (vertices[faces[half // 3, (half + k) % 3]] for k in range(3))
        axis = end - start
        axis /= np.maximum(np.linalg.norm(axis, axis=1), np.finfo(float).tiny)[:, None]
        away = apex - start
        away -= np.einsum("ij,ij->i", away, axis)[:, None] * axis
        unit: FloatArray = (
            away / np.maximum(np.linalg.norm(away, axis=1), np.finfo(float).tiny)[:, None]
        )
        return unit

    apart: BoolArray = np.linalg.norm(arm(first) - arm(second), axis=1) < _FOLD
    return apart


def _offset(
    vertices: FloatArray,
    sides: IntArray,
    corners: IntArray,
    offsets: FloatArray,
    number: int,
) -> FloatArray:
    """(number, 3) displacement of each vertex that moves its faces by their offsets.

    Least squares over the faces around it, weighted by their angles there; directions
    that no face determines stay put, and miters end at three times the offset.
    """
    areas, normals = face_areas(vertices, sides)
    unit = normals / np.maximum(2.0 * areas, np.finfo(float).tiny)[:, None]
    matrix = np.zeros((number, 3, 3))
    right = np.zeros((number, 3))
    for k in range(3):
        p, q, r = (vertices[sides[:, (k + i) % 3]] for i in range(3))
        a, b = q - p, r - p
        weight = np.arctan2(2.0 * areas, np.einsum("ij,ij->i", a, b))
        outer = weight[:, None, None] * unit[:, :, None] * unit[:, None, :]
        np.add.at(matrix, corners[:, k], outer)
        np.add.at(right, corners[:, k], (weight * offsets)[:, None] * unit)
    values, axes = np.linalg.eigh(matrix)
    known = values > _RANK * np.maximum(values[:, 2:], np.finfo(float).tiny)
    inverse = np.where(known, 1.0 / np.where(known, values, 1.0), 0.0)
    along = np.einsum("nji,nj->ni", axes, right) * inverse
    result = np.einsum("nij,nj->ni", axes, along)
    length = np.linalg.norm(result, axis=1)
    most = _MITER * float(offsets.max(initial=0.0))
    shrink = np.where(length > most, most / np.maximum(length, np.finfo(float).tiny), 1.0)
    shrunk: FloatArray = result * shrink[:, None]
    return shrunk


def _strips(corners: IntArray, rim: IntArray) -> IntArray:
    """Two triangles along every rim edge, from one side of its face to the other."""
    top = corners.ravel()
    start, end = top[rim], top[np.where(rim % 3 == 2, rim - 2, rim + 1)]
    # The reversed face [c, b, a] has corner k of the face at 2 - k.
    back = 3 * (rim // 3 + len(corners) // 2)
    k = rim % 3
    back_start, back_end = top[back + 2 - k], top[back + 2 - (k + 1) % 3]
    return np.concatenate(
        [
            np.stack([end, start, back_start], axis=1),
            np.stack([end, back_start, back_end], axis=1),
        ]
    )
