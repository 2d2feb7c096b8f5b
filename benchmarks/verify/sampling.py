"""Points on and in shapes, and on which side of others they lie."""

from __future__ import annotations

import igl
import numpy as np
from scipy import ndimage
from scipy.spatial import ConvexHull, QhullError, cKDTree


def inside(queries, vertices, windings) -> np.ndarray:
    """Where the winding number of one of the orientations is above one half."""
    found = np.zeros(len(queries), bool)
    for faces in filter(len, windings):
        size = max(1, 20_000_000 // max(1, len(faces)))
        for start in range(0, len(queries), size):
            part = np.ascontiguousarray(queries[start : start + size])
            number = np.asarray(igl.winding_number(vertices, faces, part)).ravel()
            found[start : start + size] |= np.abs(number) > 0.5
    return found


def planes_of(vertices: np.ndarray) -> np.ndarray | None:
    """Half-spaces normal · x + offset <= 0."""
    try:
        return np.unique(ConvexHull(vertices).equations, axis=0)
    except QhullError:
        return None


def on_surface(vertices, faces, count, rng) -> np.ndarray:
    """All vertices and uniform samples."""
    corner = vertices[np.asarray(faces)]
    area = np.linalg.norm(
        np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1
    )
    if not area.sum() > 0:
        return vertices
    tri = corner[rng.choice(len(corner), size=count, p=area / area.sum())]
    u, v = np.sort(rng.random((2, count, 1)), axis=0)
    return np.vstack([vertices, tri[:, 0] * u + tri[:, 1] * (v - u) + tri[:, 2] * (1 - v)])


def in_volume(vertices, count, rng) -> np.ndarray:
    """Convex combinations of four vertices each, dense towards the middle."""
    corners = vertices[rng.integers(0, len(vertices), size=(count, 4))]
    return (corners * rng.dirichlet(np.ones(4), size=count)[..., None]).sum(axis=1)


def outside_all(points: np.ndarray, planes: list[np.ndarray], bound: float) -> np.ndarray:
    """Least plane excess over the hulls (a lower bound of the distance to them)."""
    reach = np.full(len(points), np.inf)
    for p in planes:
        open_ = np.flatnonzero(reach > bound)
        if not len(open_):
            break
        for part in np.array_split(open_, max(1, len(open_) * len(p) // 4_000_000)):
            excess = (points[part] @ p[:, :3].T + p[:, 3]).max(axis=1)
            reach[part] = np.minimum(reach[part], excess)
    return reach


def touched(points, vertices, windings, radius: float) -> np.ndarray:
    """Which points a ball from outside surely touches: its centre walks on a lattice whose
    points are all half a step farther from the surface than it must be."""
    low, high = vertices.min(axis=0) - 2 * radius, vertices.max(axis=0) + 2 * radius
    step = max(radius / 3, float(np.cbrt(np.prod(high - low) / 600_000)))
    shape = np.ceil((high - low) / step).astype(int) + 1
    lattice = np.stack(np.meshgrid(*(np.arange(n) for n in shape), indexing="ij"), axis=-1)
    centres = low + step * lattice.reshape(-1, 3)
    squared, *_ = igl.point_mesh_squared_distance(centres, vertices, windings[0])
    free = np.sqrt(np.asarray(squared).ravel()) >= radius + step / 2
    free[free] = ~inside(centres[free], vertices, windings)
    labels, _ = ndimage.label(free.reshape(shape))
    reached = centres[(labels == labels[0, 0, 0]).ravel() & free]
    distance, _ = cKDTree(reached).query(points)
    return distance < radius - 1e-9
