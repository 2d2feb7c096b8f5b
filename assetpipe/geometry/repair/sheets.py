"""Open surfaces given a thickness.

Every face gets two sides. Around an edge, going by angle, the side of one face that
looks at the next is joined to that one's side that looks back; along a rim a strip joins
the two sides of the same face. The result is closed whatever the number of faces at
an edge and however they are wound, one-sided surfaces included.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from assetpipe.geometry.health.topology import Edges, face_areas, umbrellas
from assetpipe.geometry.health.weld import degenerate
from assetpipe.geometry.mesh import FloatArray, IntArray
from assetpipe.geometry.repair.holes import cap, openings
from assetpipe.geometry.repair.split import by_angle, split_nonmanifold

_MITER = 3.0
_RANK = 0.02


def thicken(
    vertices: FloatArray,
    faces: IntArray,
    thickness: float,
    side: Literal["inward", "centred"],
) -> tuple[FloatArray, IntArray]:
    """A closed surface around a sheet.

    Args:
        vertices: (n, 3).
        faces: (m, 3), none degenerate.
        thickness: distance between the two sides of a plane sheet.
        side: ``"inward"`` leaves the surface where it is and puts the other side behind it;
            ``"centred"`` puts both half the thickness away.

    Returns:
        Vertices and faces; closed, every edge with two faces. Where the sheet bends more
        sharply than the thickness allows the result may cross itself nearby.
    """
    two_sided, number, corners = _sides_joined(vertices, faces)
    before = np.zeros(number, dtype=np.int64)
    before[corners.ravel()] = two_sided.ravel()
    outward = 0.0 if side == "inward" else thickness / 2.0
    offsets = np.repeat([outward, thickness - outward], len(faces))
    moved = vertices[before] + _offset(vertices, two_sided, corners, offsets, number)
    strips = _strips(faces, corners)
    closed = np.concatenate([corners, strips])
    closed = np.delete(closed, degenerate(closed), axis=0)
    moved, closed, _ = split_nonmanifold(moved, closed)
    caps = [cap(moved, opening) for opening in openings(moved, closed)]
    return moved, np.concatenate([closed, *caps])


def _sides_joined(vertices: FloatArray, faces: IntArray) -> tuple[IntArray, int, IntArray]:
    """Both sides of every face, and the vertices that they make when joined by angle."""
    m = len(faces)
    two_sided = np.concatenate([faces, faces[:, ::-1]])
    edges = Edges.of(faces, len(vertices))
    several = np.flatnonzero(edges.count > 1)
    half, owner = by_angle(vertices, edges, several)
    if not len(half):
        number, corners = umbrellas(two_sided, half, half)
        return two_sided, number, corners
    # The next half-edge around the same edge, the first after the last.
    following = np.append(half[1:], half[0])
    last = np.append(owner[1:] != owner[:-1], True)
    start = np.flatnonzero(np.append(True, owner[1:] != owner[:-1]))
    following[last] = half[start]
    back = 3 * (half // 3 + m) + np.array([1, 0, 2])[half % 3]
    forward = edges.forward[half]
    ahead = np.where(forward, half, back)
    back_next = 3 * (following // 3 + m) + np.array([1, 0, 2])[following % 3]
    behind = np.where(edges.forward[following], back_next, following)
    number, corners = umbrellas(two_sided, ahead, behind)
    return two_sided, number, corners


def _offset(
    vertices: FloatArray,
    two_sided: IntArray,
    corners: IntArray,
    offsets: FloatArray,
    number: int,
) -> FloatArray:
    """(number, 3) displacement of each vertex that moves its faces by their offsets.

    Least squares over the faces around it, weighted by their angles there; directions
    that no face determines stay put, and miters end at three times the offset.
    """
    areas, normals = face_areas(vertices, two_sided)
    unit = normals / np.maximum(2.0 * areas, np.finfo(float).tiny)[:, None]
    matrix = np.zeros((number, 3, 3))
    right = np.zeros((number, 3))
    for k in range(3):
        p, q, r = (vertices[two_sided[:, (k + i) % 3]] for i in range(3))
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


def _strips(faces: IntArray, corners: IntArray) -> IntArray:
    """Two triangles along every rim edge, from one side of its face to the other."""
    m = len(faces)
    edges = Edges.of(faces, int(faces.max()) + 1)
    rim = edges.order[edges.first[edges.boundary]]
    top = corners.ravel()
    start, end = top[rim], top[np.where(rim % 3 == 2, rim - 2, rim + 1)]
    # The reversed face [c, b, a] has corner k of the face at 2 - k.
    back = 3 * (rim // 3 + m)
    k = rim % 3
    back_start, back_end = top[back + 2 - k], top[back + 2 - (k + 1) % 3]
    return np.concatenate(
        [
            np.stack([end, start, back_start], axis=1),
            np.stack([end, back_start, back_end], axis=1),
        ]
    )
