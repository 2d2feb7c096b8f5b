"""Triangles in smaller ones, so that bounds over each become sharper."""

from __future__ import annotations

import numpy as np

from assetpipe.geometry.mesh import FloatArray, IntArray
from assetpipe.geometry.repair.surface import Corners

_ACROSS = 1e-9
"""Units by which a triangle reaches over an edge at least to be cut there."""
_SLENDER = 0.4
"""Shortest over longest edge below which a triangle is halved, not quartered."""


def divided(corners: Corners, faces: Corners, near: FloatArray) -> tuple[Corners, IntArray]:
    """Each triangle divided, and the index of the triangle that each part is of.

    Args:
        corners: (n, 3, 3).
        faces: (n, 3, 3), a face for each: a triangle no farther than ``near`` from its plane,
            but across one of its edges, is cut there.
        near: (n,).
    """
    edges = np.roll(faces, -1, axis=1) - faces
    normal = np.cross(edges[:, 0], edges[:, 1])
    normal /= np.maximum(np.linalg.norm(normal, axis=1), np.finfo(float).tiny)[:, None]
    inward = np.cross(normal[:, None], edges)
    inward /= np.maximum(np.linalg.norm(inward, axis=2), np.finfo(float).tiny)[:, :, None]
    height = np.einsum("nij,nj->ni", corners - faces[:, :1], normal)
    # (n, edge, corner): how far a corner lies on the face's side of an edge.
    side = np.einsum("nkj,nij->nki", inward, corners)
    side -= np.einsum("nkj,nkj->nk", inward, faces)[:, :, None]
    across = np.minimum(side.max(axis=2), -side.min(axis=2))
    best = across.argmax(axis=1)
    each = np.arange(len(corners))
    cut = (across[each, best] > _ACROSS) & (np.abs(height).max(axis=1) <= near)
    length = np.linalg.norm(corners - np.roll(corners, -1, axis=1), axis=2)
    slender = ~cut & (length.min(axis=1) < _SLENDER * length.max(axis=1))
    whole = ~cut & ~slender
    parts = (
        quarters(corners[whole]),
        _halves(corners[slender], length[slender]),
        _sliced(corners[cut], side[each, best][cut]),
    )
    source = (np.tile(each[whole], 4), np.tile(each[slender], 2), np.tile(each[cut], 3))
    return np.concatenate(parts), np.concatenate(source)


def quarters(corners: Corners) -> Corners:
    """Each triangle cut at its edges' midpoints."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    ab, bc, ca = (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0
    return np.concatenate(
        [np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
    )


def _halves(corners: Corners, length: FloatArray) -> Corners:
    """Each triangle cut at the middle of its longest edge, from a corner to the next one."""
    a, b, c = _turned(corners, length.argmax(axis=1))
    middle = (a + b) / 2.0
    return np.concatenate([np.stack(t, axis=1) for t in ((a, middle, c), (middle, b, c))])


def _sliced(corners: Corners, side: FloatArray) -> Corners:
    """Each triangle cut where ``side``, (n, 3) at its corners, is zero: into three."""
    below = side < 0.0
    alone = np.where(below.sum(axis=1) == 1, side.argmin(axis=1), side.argmax(axis=1))
    a, b, c = _turned(corners, alone)
    of_a, of_b, of_c = _turned(side[:, :, None], alone)
    ab = a + np.clip(of_a / (of_a - of_b), 0.0, 1.0) * (b - a)
    ac = a + np.clip(of_a / (of_a - of_c), 0.0, 1.0) * (c - a)
    return np.concatenate([np.stack(t, axis=1) for t in ((a, ab, ac), (ab, b, c), (ab, c, ac))])


def _turned(values: Corners, first: IntArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Values at three corners, beginning with the one at ``first``."""
    order = (first[:, None] + np.arange(3)) % 3
    turned = np.take_along_axis(values, order[:, :, None], axis=1)
    return turned[:, 0], turned[:, 1], turned[:, 2]
