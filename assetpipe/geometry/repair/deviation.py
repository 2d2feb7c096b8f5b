"""How far two surfaces lie apart, both ways, as a bound.

Branch and bound over triangles: the distance to a surface is 1-Lipschitz, so that
its value at a triangle's centre plus the triangle's radius bounds it all over the triangle.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
import numpy.typing as npt

from assetpipe.geometry.health.topology import face_areas
from assetpipe.geometry.mesh import FloatArray, IntArray
from assetpipe.geometry.repair.frame import Frame
from assetpipe.geometry.repair.result import Deviation

Arrays = tuple[FloatArray, IntArray]
_SAMPLES = 4000
_TRIANGLES = 200_000


class Surface:
    """Distances to, and winding numbers of, one triangle surface (in units)."""

    def __init__(self, vertices: FloatArray, faces: IntArray) -> None:
        import igl

        self.vertices = np.ascontiguousarray(vertices)
        self.faces = np.ascontiguousarray(faces)
        self._tree = igl.AABB()
        self._tree.init(self.vertices, self.faces)
        self._winding: igl.FastWindingNumberBVH | None = None

    def distance(self, points: FloatArray) -> FloatArray:
        """(n,) distance of each point to the surface."""
        if not len(points):
            return np.zeros(0)
        squared, _, _ = self._tree.squared_distance(self.vertices, self.faces, points)
        result: FloatArray = np.sqrt(np.maximum(squared, 0.0))
        return result

    def closest(self, points: FloatArray) -> tuple[FloatArray, IntArray, FloatArray]:
        """(n,) distances, (n,) faces and (n, 3) closest points."""
        squared, face, point = self._tree.squared_distance(self.vertices, self.faces, points)
        return np.sqrt(np.maximum(squared, 0.0)), face, point

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

    def outside(self, points: FloatArray) -> FloatArray:
        """(n,) distance to the solid: zero for points inside."""
        distance = self.distance(points)
        away = np.flatnonzero(distance > 0.0)
        inside = np.abs(self.winding(points[away])) > 0.5
        distance[away[inside]] = 0.0
        return distance

    def bound_over(self, corners: npt.NDArray[np.float64], face: IntArray) -> FloatArray:
        """(n,) upper bound on the distance of any point of (n, 3, 3) triangles to the surface.

        The distance to one face is convex, so that over a triangle it is largest at a
        corner: the bound is the largest distance of the corners to ``face``.
        """
        target = self.vertices[self.faces[face]]
        result = np.zeros(len(corners))
        for k in range(3):
            np.maximum(result, distance_to_triangles(corners[:, k], target), out=result)
        return result


def distance_to_triangles(points: FloatArray, triangles: npt.NDArray[np.float64]) -> FloatArray:
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


def sample(vertices: FloatArray, faces: IntArray, number: int, seed: int = 0) -> FloatArray:
    """``number`` points spread over the surface in proportion to area, the same every time."""
    areas, _ = face_areas(vertices, faces)
    total = areas.cumsum()
    if not len(total) or total[-1] <= 0.0:
        return vertices[faces[:, 0]][:number]
    random = np.random.default_rng(seed)
    places = (np.arange(number) + random.random(number)) / number * total[-1]
    face = np.minimum(np.searchsorted(total, places), len(faces) - 1)
    u, v = random.random((2, number))
    over = u + v > 1.0
    u[over], v[over] = 1.0 - u[over], 1.0 - v[over]
    a, b, c = (vertices[faces[face, k]] for k in range(3))
    points: FloatArray = a + u[:, None] * (b - a) + v[:, None] * (c - a)
    return points


def farthest(
    surface: Surface,
    corners: npt.NDArray[np.float64],
    *,
    side: Literal["surface", "solid"],
    resolution: float,
) -> float:
    """Upper bound on the distance of any point of triangles to a surface.

    Args:
        surface: the target.
        corners: (n, 3, 3) triangles.
        side: ``"surface"``: distance to the surface; ``"solid"``: zero inside it.
        resolution: how much larger than the truth the bound may be, if affordable.
    """
    reached = settled = 0.0
    while len(corners):
        centre = corners.mean(axis=1)
        radius = np.sqrt(((corners - centre[:, None]) ** 2).sum(axis=2).max(axis=1))
        distance, face, _ = surface.closest(centre)
        upper = np.minimum(distance + radius, surface.bound_over(corners, face))
        if side == "solid":
            far = np.flatnonzero(upper > reached + resolution)
            inside = far[np.abs(surface.winding(centre[far])) > 0.5]
            # The centre is inside: what lies nearer to it than the surface is inside too.
            upper[inside] = np.maximum(0.0, radius[inside] - distance[inside])
            distance[inside] = 0.0
            # Nobody asked whether the others are inside; they don't count as reached.
            distance[np.setdiff1d(np.arange(len(centre)), far)] = 0.0
        reached = max(reached, float(distance.max()))
        undecided = upper > reached + resolution
        settled = max(settled, float(upper[~undecided].max(initial=0.0)))
        corners = corners[undecided]
        if 4 * len(corners) > _TRIANGLES:
            return max(settled, float(upper[undecided].max()))
        corners = _quarters(corners)
    return max(settled, reached)


def _quarters(corners: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Each triangle cut at its edges' midpoints."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    ab, bc, ca = (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0
    return np.concatenate(
        [np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
    )


def deviation(before: Arrays, after: Arrays, *, resolution: float = 1e-3) -> Deviation:
    """Two-sided deviation between a surface and the solid made of it.

    Args:
        before: vertices (metres) and faces of the old surface.
        after: vertices (metres) and faces of the solid.
        resolution: of the bounds, as a share of the diagonal.
    """
    frame = Frame.around(before[0])
    old, new = frame.inward(before[0]), frame.inward(after[0])
    old_surface, new_surface = Surface(old, before[1]), Surface(new, after[1])
    removed = farthest(new_surface, old[before[1]], side="solid", resolution=resolution)
    added = farthest(old_surface, new[after[1]], side="surface", resolution=resolution)
    removed_p99 = np.quantile(new_surface.outside(sample(old, before[1], _SAMPLES)), 0.99)
    added_p99 = np.quantile(old_surface.distance(sample(new, after[1], _SAMPLES)), 0.99)
    return Deviation(
        removed * frame.scale,
        added * frame.scale,
        float(removed_p99) * frame.scale,
        float(added_p99) * frame.scale,
        "bound",
    )
