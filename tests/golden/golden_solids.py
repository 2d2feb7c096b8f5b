"""Solids of which every coordinate is the same number on every machine.

Whole numbers, and quotients and products of them in one fixed order: each operation is rounded
as IEEE 754 says, so no processor, compiler or library has a say in them.
"""

from __future__ import annotations

import numpy as np

from assetpipe.geometry import Mesh

Point = tuple[float, float, float]


def _extruded(outline: list[tuple[float, float]], low: float, high: float) -> Mesh:
    """A prism over an outline that is seen as a whole from its first corner."""
    n = len(outline)
    vertices = [(x, y, z) for z in (low, high) for x, y in outline]
    faces = [(0, k + 1, k) for k in range(1, n - 1)]
    faces += [(n, n + k, n + k + 1) for k in range(1, n - 1)]
    for k in range(n):
        after = (k + 1) % n
        faces += [(k, after, n + after), (k, n + after, n + k)]
    return Mesh(np.array(vertices, dtype=float), np.array(faces))


def angle() -> Mesh:
    """An angle of two plates: an extruded outline."""
    return _extruded([(0, 0), (8, 0), (8, 1), (1, 1), (1, 6), (0, 6)], 0, 5)


def _revolved(profile: list[tuple[float, float]], steps: int) -> Mesh:
    """A closed profile (radius, height) around z; cosines and sines by rational points."""
    quarter = []
    for k in range(steps):
        t = k / steps
        quarter.append(((1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)))
    circle = list(quarter)
    for _ in range(3):
        quarter = [(-y, x) for x, y in quarter]
        circle += quarter
    around, along = len(circle), len(profile)
    vertices = [(r * c, r * s, z) for c, s in circle for r, z in profile]
    faces = []
    for i in range(around):
        for k in range(along):
            a, b = i * along + k, (i + 1) % around * along + k
            c, d = (i + 1) % around * along + (k + 1) % along, i * along + (k + 1) % along
            faces += [(a, b, c), (a, c, d)]
    return Mesh(np.array(vertices), np.array(faces))


def ring() -> Mesh:
    """A flat ring: walls that are divided into sectors."""
    return _revolved([(3, 0), (5, 0), (5, 1), (3, 1)], 5)


def flask() -> Mesh:
    """A ring of a stepped profile, so that sectors alone do not do."""
    return _revolved([(2, 0), (7, 0), (7, 2), (5, 3), (5, 6), (8, 8), (7, 9), (3, 6), (3, 2)], 3)


def block_with_cavity_and_well() -> Mesh:
    """A box with a cavity and, beside it, a box that stands alone."""
    outer = _extruded([(0, 0), (9, 0), (9, 7), (0, 7)], 0, 8)
    cavity = _extruded([(2, 2), (6, 3), (5, 5), (2, 4)], 2, 6)
    other = _extruded([(11, 0), (13, 0), (12, 4)], 1, 6)
    parts = [(outer.vertices, outer.faces), (cavity.vertices, cavity.faces[:, ::-1])]
    parts.append((other.vertices, other.faces))
    starts = np.cumsum([0] + [len(vertices) for vertices, _ in parts])
    return Mesh(
        np.vstack([vertices for vertices, _ in parts]),
        np.vstack([faces + start for (_, faces), start in zip(parts, starts, strict=False)]),
    )


def turned(mesh: Mesh) -> Mesh:
    """By the rotation of the quaternion (4, 1, 2, 3), metres instead of its whole numbers."""
    rows = ((4, -20, 22), (28, 10, 4), (-10, 20, 20))
    moved = []
    for x, y, z in mesh.vertices.tolist():
        moved.append([((a * x + b * y) + c * z) / 30 / 64 + 0.7 for a, b, c in rows])
    return Mesh(np.array(moved), mesh.faces)


SOLIDS = {
    "angle": angle(),
    "ring": ring(),
    "block with a cavity": block_with_cavity_and_well(),
    "angle, turned": turned(angle()),
    "flask, turned": turned(flask()),
}
