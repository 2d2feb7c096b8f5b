"""Geometry without rounding: coordinates as whole numbers of one power of two.

Every float64 is a whole number times a power of two, so signs and volumes of polyhedra are
computed exactly with Python's integers. Nothing here shares code with what it judges.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np

_ERROR = 2.0**-48
"""Relative rounding bound of a 3 × 3 determinant of differences, with room to spare."""


def whole(*arrays: np.ndarray) -> tuple[list[np.ndarray], int]:
    """Arrays of floats as arrays of Python integers, all times 2**shift."""
    used = np.concatenate([np.asarray(a, dtype=float).ravel() for a in arrays])
    used = used[used != 0]
    shift = 53 - int(np.frexp(used)[1].min()) if used.size else 0
    shift = max(shift, 0)

    rows = []
    for array in arrays:
        ratios = (x.as_integer_ratio() for x in np.asarray(array, dtype=float).ravel().tolist())
        numbers = [top * ((1 << shift) // bottom) for top, bottom in ratios]
        rows.append(np.array(numbers, dtype=object).reshape(np.shape(array)))
    return rows, shift


def _determinants(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """a · (b × c), row by row."""
    return (
        a[:, 0] * (b[:, 1] * c[:, 2] - b[:, 2] * c[:, 1])
        + a[:, 1] * (b[:, 2] * c[:, 0] - b[:, 0] * c[:, 2])
        + a[:, 2] * (b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0])
    )


def volume(vertices: np.ndarray, faces: np.ndarray) -> Fraction:
    """The exact signed volume of a closed mesh."""
    if not len(faces):
        return Fraction(0)
    (points,), shift = whole(vertices)
    corners = points[faces] - points[faces[0, 0]]
    six = _determinants(corners[:, 0], corners[:, 1], corners[:, 2]).sum()
    return Fraction(int(six), 6 << (3 * shift))


def heights(vertices: np.ndarray, faces: np.ndarray, points: np.ndarray) -> np.ndarray:
    """(points, faces) exact signs: 1 above a counter-clockwise face, −1 below, 0 on it."""
    corners = vertices[faces]
    a = corners[:, 0]
    u, v = corners[:, 1] - a, corners[:, 2] - a
    normal = np.cross(u, v)
    w = points[:, None, :] - a[None]
    value = np.einsum("pfk,fk->pf", w, normal)
    # A difference of floats carries one rounding of its own size.
    doubt = _ERROR * 6 * (np.abs(u).max(1) * np.abs(v).max(1)) * np.abs(w).max(2)
    sign = np.sign(value).astype(int)
    same = (points[:, None, None, :] == corners[None]).all(axis=3).any(axis=2)
    sign[same] = 0
    p, f = np.nonzero((np.abs(value) <= doubt) & ~same)
    if len(p):
        (every, given), _ = whole(corners, points)
        x, y, z = (every[f, k] for k in range(3))
        exact = _determinants(y - x, z - x, given[p] - x)
        sign[p, f] = (exact > 0).astype(int) - (exact < 0).astype(int)
    return sign


def contains(vertices: np.ndarray, faces: np.ndarray, points: np.ndarray) -> np.ndarray:
    """For each point whether a convex polytope holds it, by exact signs."""
    corners = {tuple(v) for v in vertices.tolist()}
    held = np.array([tuple(p) in corners for p in points.tolist()], dtype=bool)
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    asked = np.flatnonzero(~held & ((points >= low) & (points <= high)).all(axis=1))
    block = max(1, 400_000 // len(faces))
    for k in range(0, len(asked), block):
        some = asked[k : k + block]
        held[some] = (heights(vertices, faces, points[some]) <= 0).all(axis=1)
    return held


def is_convex(vertices: np.ndarray, faces: np.ndarray) -> bool:
    """Whether a mesh is the boundary of a convex polytope, outward.

    It is, if it is one closed surface of genus 0 whose every edge is convex or flat; that it
    does not wind around more than once is the caller's to check, by its volume.
    """
    start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    apex = np.roll(faces, 1, axis=1).ravel()
    across = {
        (a, b): c for a, b, c in zip(*map(np.ndarray.tolist, (start, end, apex)), strict=True)
    }
    if len(across) != faces.size or any((b, a) not in across for a, b in across):
        return False
    if len(np.unique(faces)) - faces.size // 2 + len(faces) != 2:
        return False
    beyond = np.array([across[b, a] for a, b in zip(start.tolist(), end.tolist(), strict=True)])
    x, y, z, q = (vertices[k] for k in (start, end, apex, beyond))
    value = np.einsum("ij,ij->i", np.cross(y - x, z - x), q - x)
    doubt = _ERROR * 6 * (np.abs(y - x).max(1) * np.abs(z - x).max(1) * np.abs(q - x).max(1))
    if (value > doubt).any():
        return False
    unsure = np.abs(value) <= doubt
    if not unsure.any():
        return True
    (x, y, z, q), _ = whole(x[unsure], y[unsure], z[unsure], q[unsure])
    return bool((_determinants(y - x, z - x, q - x) <= 0).all())
