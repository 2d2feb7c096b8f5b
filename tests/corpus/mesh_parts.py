"""What meshes of the corpus are put together of: shapes, and ways to spoil them.

All are about one metre in size and centred near the origin.
"""

from __future__ import annotations

import numpy as np
import trimesh

from assetpipe.geometry import Mesh

Arrays = tuple[np.ndarray, np.ndarray]


def box(size=(1.0, 1.0, 1.0), at=(0.0, 0.0, 0.0)) -> Arrays:
    mesh = trimesh.creation.box(size)
    return np.asarray(mesh.vertices) + np.asarray(at), np.asarray(mesh.faces)


def sphere(subdivisions: int = 3, radius: float = 0.5, at=(0.0, 0.0, 0.0)) -> Arrays:
    mesh = trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius)
    return np.asarray(mesh.vertices) + np.asarray(at), np.asarray(mesh.faces)


def tetrahedron(corners) -> Arrays:
    points = np.asarray(corners, dtype=float)
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
    if np.linalg.det(points[1:] - points[0]) < 0:
        faces = faces[:, ::-1]
    return points, faces


def join(*parts: Arrays) -> Arrays:
    offsets = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    return (
        np.concatenate([vertices for vertices, _ in parts]),
        np.concatenate([faces + at for (_, faces), at in zip(parts, offsets, strict=False)]),
    )


def inverted(part: Arrays) -> Arrays:
    return part[0], part[1][:, ::-1]


def soup(part: Arrays) -> Arrays:
    vertices, faces = part
    return vertices[faces].reshape(-1, 3), np.arange(faces.size).reshape(-1, 3)


def welded(part: Arrays) -> Arrays:
    vertices, to = np.unique(part[0], axis=0, return_inverse=True)
    return vertices, to.ravel()[part[1]]


def without(part: Arrays, gone) -> Arrays:
    return part[0], np.delete(part[1], gone, axis=0)


def sheet(steps: int = 1, size: float = 1.0) -> Arrays:
    ticks = np.linspace(-size / 2, size / 2, steps + 1)
    x, y = np.meshgrid(ticks, ticks, indexing="ij")
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    a = np.arange(steps)[:, None] * (steps + 1) + np.arange(steps)
    a = a.ravel()
    b, c, d = a + steps + 1, a + steps + 2, a + 1
    return vertices, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def flat_square(corners) -> Arrays:
    return np.asarray(corners, dtype=float), np.array([[0, 1, 2], [0, 2, 3]])


def strip(twists: int, steps: int = 60, width: float = 0.2) -> Arrays:
    """A band around a circle with half twists: one is a Möbius band."""
    angle = 2 * np.pi * np.arange(steps) / steps
    turn = twists * angle / 2
    rows = []
    for side in (-width, width):
        r = 0.4 + side / 2 * np.cos(turn)
        rows.append(np.stack([r * np.cos(angle), r * np.sin(angle), side / 2 * np.sin(turn)], 1))
    vertices = np.stack(rows, axis=1).reshape(-1, 3)
    faces = []
    for i in range(steps):
        a, b = 2 * i, 2 * i + 1
        c, d = (2 * i + 2, 2 * i + 3) if i + 1 < steps else ((1, 0) if twists % 2 else (0, 1))
        faces += [[a, c, b], [b, c, d]]
    return vertices, np.array(faces)


def klein_bottle(rings: int = 40, steps: int = 16) -> Arrays:
    """The figure-eight immersion: closed, one-sided, crossing itself."""
    u = 2 * np.pi * np.arange(rings) / rings
    v = 2 * np.pi * np.arange(steps) / steps
    u, v = np.meshgrid(u, v, indexing="ij")
    r = 0.35 + 0.12 * (np.cos(u / 2) * np.sin(v) - np.sin(u / 2) * np.sin(2 * v))
    z = 0.12 * (np.sin(u / 2) * np.sin(v) + np.cos(u / 2) * np.sin(2 * v))
    vertices = np.stack([r * np.cos(u), r * np.sin(u), z], axis=-1).reshape(-1, 3)
    faces = []
    for i in range(rings):
        for k in range(steps):
            a, d = i * steps + k, i * steps + (k + 1) % steps
            if i + 1 < rings:
                b, c = (i + 1) * steps + k, (i + 1) * steps + (k + 1) % steps
            else:  # the seam runs backwards
                b, c = (-k) % steps, (-k - 1) % steps
            faces += [[a, b, c], [a, c, d]]
    return vertices, np.array(faces)


def coil(turns: float = 1.2, steps: int = 96, sides: int = 12) -> Arrays:
    """A closed tube around a circle whose ends overlap: one shell that overlaps itself."""
    angle = 2 * np.pi * turns * np.arange(steps + 1) / steps
    around = 2 * np.pi * np.arange(sides) / sides
    a, b = np.meshgrid(angle, around, indexing="ij")
    r = 0.4 + 0.1 * np.cos(b)
    z = 0.1 * np.sin(b) + 0.02 * (a / (2 * np.pi))
    vertices = np.stack([r * np.cos(a), r * np.sin(a), z], axis=-1).reshape(-1, 3)
    faces = []
    for i in range(steps):
        for k in range(sides):
            p, q = i * sides + k, i * sides + (k + 1) % sides
            faces += [[p, p + sides, q + sides], [p, q + sides, q]]
    for row, order in ((0, 1), (steps, -1)):
        rim = [row * sides + k for k in range(sides)][::order]
        faces += [[rim[0], rim[k], rim[k + 1]] for k in range(1, sides - 1)]
    return vertices, np.array(faces)[:, ::-1]


def with_flap() -> Arrays:
    """A fine box, one vertex of its upper side moved out over the edge in that side's plane."""
    fine = trimesh.creation.box().subdivide().subdivide()
    vertices, faces = np.array(fine.vertices), np.asarray(fine.faces)
    vertices[np.abs(vertices - [0.25, 0.0, 0.5]).max(axis=1) < 1e-9] = [0.509, 0.03, 0.5]
    return vertices, faces


def with_junction() -> Arrays:
    """A box of which one face knows a vertex on an edge that its neighbour does not."""
    vertices, faces = box()
    vertices = np.vstack([vertices, (vertices[faces[0][0]] + vertices[faces[0][1]]) / 2])
    a, b, c = faces[0]
    return vertices, np.vstack([faces[1:], [[a, 8, c], [8, b, c]]])


def pinched() -> Arrays:
    """Two tunnels' worth of touching: a closed surface that passes one edge twice."""
    return welded(join(box(), box(at=(1.0, 1.0, 0.0)), box((2.0, 2.0, 1.0), (0.5, 0.5, -1.0))))


def exploded() -> Arrays:
    """A sphere whose faces are each drawn in a little: gaps everywhere."""
    vertices, faces = soup(sphere(3))
    corners = vertices.reshape(-1, 3, 3)
    centre = corners.mean(axis=1, keepdims=True)
    return (centre + 0.97 * (corners - centre)).reshape(-1, 3), faces


def two_halves(gap: float) -> Arrays:
    """A box in two open halves, the gap apart."""
    left = box((0.5, 1.0, 1.0), (-0.25 - gap / 2, 0.0, 0.0))
    right = box((0.5, 1.0, 1.0), (0.25 + gap / 2, 0.0, 0.0))
    normal = trimesh.Trimesh(*left, process=False).face_normals[:, 0]
    return join(without(left, normal > 0.5), without(right, normal < -0.5))


def lid_off() -> Arrays:
    vertices, faces = box()
    top = trimesh.Trimesh(vertices, faces, process=False).face_normals[:, 2] > 0.5
    return without((vertices, faces), top)


def divided_box() -> Arrays:
    """A box of two rooms: the wall between them makes edges with three faces."""
    a = trimesh.creation.box((0.5, 1.0, 1.0)).apply_translation((-0.25, 0, 0))
    b = trimesh.creation.box((0.5, 1.0, 1.0)).apply_translation((0.25, 0, 0))
    shared = b.face_normals[:, 0] < -0.5
    part = (np.asarray(b.vertices), np.asarray(b.faces)[~shared])
    return welded(join((np.asarray(a.vertices), np.asarray(a.faces)), part))


def hollow() -> Arrays:
    return join(box(), inverted(box((0.5, 0.5, 0.5))))


def turned(part: Arrays, every: int) -> Arrays:
    """One face in so many the other way round."""
    vertices, faces = part
    chosen = np.arange(len(faces)) % every == 0
    return vertices, np.where(chosen[:, None], faces[:, ::-1], faces)


def loose(part: Arrays, again: slice, turn: int = 1) -> Arrays:
    """Faces with vertices of their own, a hair off; some are there twice, some from both sides."""
    vertices, faces = part
    faces = np.vstack([faces, faces[again, ::turn]])
    corners = vertices[faces].reshape(-1, 3)
    hair = 1e-9 * np.random.default_rng(5).normal(size=corners.shape)
    return corners + hair, np.arange(len(corners)).reshape(-1, 3)


def sphere_volume(subdivisions: int, radius: float) -> float:
    return float(trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius).volume)


def mesh(part: Arrays) -> Mesh:
    return Mesh(*part)


def thick(mesh: Mesh) -> float:
    """The volume of a sheet: its thickness is a quarter of the budget of 1%."""
    return mesh.area * mesh.diagonal / 400


def doubled(square: Arrays) -> Arrays:
    """Its other two triangles, facing the other way, as well: a tetrahedron without height."""
    return square[0], np.concatenate([square[1], [[0, 3, 1], [1, 3, 2]]])
