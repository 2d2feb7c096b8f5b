"""A triangle surface that answers for distances and winding numbers."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from assetpipe.geometry.mesh import FloatArray, IntArray

Corners = npt.NDArray[np.float64]
"""(n, 3, 3): the corners of n triangles."""

NEAR = 1e-4
"""Units next to a surface within which fast winding numbers are not trusted: libigl
computes them in single precision. What is nearer counts as outside."""


def no_corners() -> Corners:
    """No triangles."""
    return np.zeros((0, 3, 3))


class Surface:
    """Distances to, and winding numbers of, one triangle surface (in units)."""

    def __init__(self, vertices: FloatArray, faces: IntArray) -> None:
        self.vertices = np.ascontiguousarray(vertices)
        self.faces = np.ascontiguousarray(faces)
        self._winding: Any = None
        self._index: Any = None

    def distance(self, points: FloatArray) -> FloatArray:
        """(n,) distance of each point to the surface."""
        return self.closest(points)[0]

    def closest(self, points: FloatArray) -> tuple[FloatArray, IntArray, FloatArray]:
        """(n,) distances, (n,) faces and (n, 3) closest points."""
        if not len(points):
            return np.zeros(0), np.zeros(0, dtype=np.int64), np.zeros((0, 3))
        result: tuple[FloatArray, IntArray, FloatArray]
        result = self._indexed().closest(np.ascontiguousarray(points))
        return result

    def winding(self, points: FloatArray) -> FloatArray:
        """(n,) generalized winding number (Barill et al. 2018), to about 1e-2."""
        import igl

        if not len(points):
            return np.zeros(0)
        if self._winding is None:
            self._winding = igl.FastWindingNumberBVH()
            self._winding.init(self.vertices, self.faces)
        result: FloatArray = self._winding.winding_number(np.ascontiguousarray(points))
        return result

    def exact_winding(self, points: FloatArray) -> FloatArray:
        """(n,) winding number, right next to the surface too; asks every face for every point."""
        import igl

        if not len(points):
            return np.zeros(0)
        result: FloatArray = igl.winding_number(
            self.vertices, self.faces, np.ascontiguousarray(points)
        )
        return result

    def contains(self, points: FloatArray) -> npt.NDArray[np.bool_]:
        """(n,) whether points belong to what a closed surface encloses; exact."""
        result: npt.NDArray[np.bool_] = self._indexed().contains(np.ascontiguousarray(points))
        return result

    def turns(self, points: FloatArray) -> IntArray:
        """(n,) how often a closed surface goes around each point, once for its own; exact."""
        result: IntArray = self._indexed().winding(np.ascontiguousarray(points))
        return result

    def _indexed(self) -> Any:
        from assetpipe import _core

        if self._index is None:
            self._index = _core.Solid(self.vertices, self.faces)
        return self._index

    def outside(self, points: FloatArray) -> FloatArray:
        """(n,) distance to the solid: zero for points inside by more than :data:`NEAR`."""
        distance = self.distance(points)
        away = np.flatnonzero(distance > NEAR)
        inside = np.abs(self.winding(points[away])) > 0.5
        distance[away[inside]] = 0.0
        return distance

    def bound_over(self, corners: Corners, face: IntArray) -> FloatArray:
        """(n,) upper bound on the distance of any point of (n, 3, 3) triangles to the surface.

        The distance to one face is convex, so that over a triangle it is largest at a
        corner: the bound is the largest distance of the corners to ``face``.
        """
        target = self.vertices[self.faces[face]]
        result = np.zeros(len(corners))
        for k in range(3):
            np.maximum(result, distance_to_triangles(corners[:, k], target), out=result)
        return result


def distance_to_triangles(points: FloatArray, triangles: Corners) -> FloatArray:
    """(n,) distance of each point to its own triangle of (n, 3, 3)."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    nearest = np.minimum(
        np.minimum(_to_segments(points, a, b), _to_segments(points, b, c)),
        _to_segments(points, c, a),
    )
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    over = length > 0.0
    for start, end in ((a, b), (b, c), (c, a)):
        over &= np.einsum("ij,ij->i", np.cross(end - start, points - start), normal) >= 0.0
    height = np.abs(np.einsum("ij,ij->i", points - a, normal)) / np.where(over, length, 1.0)
    result: FloatArray = np.where(over, np.minimum(height, nearest), nearest)
    return result


def _to_segments(points: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    along = end - start
    squared = np.einsum("ij,ij->i", along, along)
    share = np.einsum("ij,ij->i", points - start, along) / np.where(squared > 0.0, squared, 1.0)
    foot = start + np.clip(share, 0.0, 1.0)[:, None] * along
    result: FloatArray = np.linalg.norm(points - foot, axis=1)
    return result
