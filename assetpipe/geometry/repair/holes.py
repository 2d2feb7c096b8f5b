"""Openings closed by caps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from assetpipe.geometry.health.topology import Edges, boundary_loops
from assetpipe.geometry.mesh import FloatArray, IntArray
from assetpipe.geometry.products import length, products
from assetpipe.geometry.repair.split import pair_half_edges


@dataclass(frozen=True, eq=False)
class Opening:
    """A closed loop of boundary edges.

    Attributes:
        loop: (k,) vertices, in the direction of a cap's boundary.
        centre: (3,) of its vertices.
        width: largest distance across its bounding box, in the units of the vertices.
        flatness: largest distance of a vertex from the best plane.
        area: of the loop projected to that plane.
        perimeter: length of the loop.
    """

    loop: IntArray
    centre: FloatArray
    width: float
    flatness: float
    area: float
    perimeter: float

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {
            "centre": self.centre.tolist(),
            "width": self.width,
            "flatness": self.flatness,
            "area": self.area,
            "edges": len(self.loop),
        }


def openings(vertices: FloatArray, faces: IntArray) -> list[Opening]:
    """All openings of a surface, its faces paired over non-manifold edges by angle."""
    first, second = pair_half_edges(vertices, Edges.of(faces, len(vertices)))
    return [opening_of(vertices, loop) for loop in boundary_loops(faces, first, second)]


def opening_of(vertices: FloatArray, loop: IntArray) -> Opening:
    """The opening over a loop of vertices."""
    points = vertices[loop]
    centre = points.mean(axis=0)
    arms = points - centre
    following = np.roll(arms, -1, axis=0)
    normal = np.cross(arms, following).sum(axis=0) / 2.0
    area = length(normal)
    size = length(points.max(axis=0) - points.min(axis=0))
    if area > 1e-12 * size * size:
        flatness = float(np.abs(products(arms, normal / area)).max())
    else:
        flatness = float(np.linalg.svd(arms, full_matrices=False)[1][-1])
    return Opening(
        loop, centre, size, flatness, area, float(np.linalg.norm(following - arms, axis=1).sum())
    )


def cap(vertices: FloatArray, opening: Opening) -> IntArray:
    """Triangles over a loop that use its vertices only: a minimum-area triangulation.

    Short loops get the optimum by dynamic programming (Barequet and Sharir 1995, "Filling
    gaps in the boundary of a polyhedron", §3); long plane ones manifold3d's
    triangulation of the projected polygon; others grow ears of least area.
    """
    loop = opening.loop
    if len(loop) < 3:
        return np.zeros((0, 3), dtype=np.int64)
    if len(loop) == 3:
        return loop[None, :]
    if len(loop) <= 48:
        return loop[_least_area(vertices[loop])]
    flat = _projected(vertices[loop])
    return loop[flat if flat is not None else _ears(vertices[loop])]


def _least_area(points: FloatArray) -> IntArray:
    """The triangulation of a closed 3D polygon with the least area, O(n³)."""
    n = len(points)
    corners = points[:, None, None], points[None, :, None], points[None, None, :]
    normals = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    area = np.linalg.norm(normals, axis=-1)
    cost = np.zeros((n, n))
    split = np.zeros((n, n), dtype=np.int64)
    for span in range(2, n):
        for i in range(n - span):
            k = i + span
            between = np.arange(i + 1, k)
            total = cost[i, between] + cost[between, k] + area[i, between, k]
            best = int(np.argmin(total))
            cost[i, k], split[i, k] = total[best], between[best]
    triangles = []
    stack = [(0, n - 1)]
    while stack:
        i, k = stack.pop()
        if k - i < 2:
            continue
        j = int(split[i, k])
        triangles.append((i, j, k))
        stack += [(i, j), (j, k)]
    return np.array(triangles, dtype=np.int64)


def _projected(points: FloatArray) -> IntArray | None:
    """Triangulate the projection to the loop's plane; ``None`` if it does not come out whole."""
    import manifold3d

    arms = points - points.mean(axis=0)
    normal = np.cross(arms, np.roll(arms, -1, axis=0)).sum(axis=0)
    size = length(normal)
    if size == 0.0:
        return None
    normal /= size
    u = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    u /= length(u)
    plane = np.ascontiguousarray(
        np.stack([products(arms, u), products(arms, np.cross(normal, u))], axis=1)
    )
    triangles = np.array(manifold3d.triangulate([plane], allow_convex=False), dtype=np.int64)
    if triangles.shape != (len(points) - 2, 3):
        return None
    return triangles


def _ears(points: FloatArray) -> IntArray:
    """Cut the ear of least area until three vertices are left."""
    left = list(range(len(points)))
    triangles = []
    while len(left) > 3:
        ring = points[left]
        area = np.linalg.norm(
            np.cross(np.roll(ring, 1, axis=0) - ring, np.roll(ring, -1, axis=0) - ring), axis=1
        )
        i = int(np.argmin(area))
        triangles.append((left[i - 1], left[i], left[(i + 1) % len(left)]))
        del left[i]
    triangles.append((left[0], left[1], left[2]))
    return np.array(triangles, dtype=np.int64)
