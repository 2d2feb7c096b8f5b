"""How far two surfaces lie apart, both ways, as a bound.

Branch and bound over triangles: the distance to a surface is 1-Lipschitz, so that
its value at a triangle's centre plus the triangle's radius bounds it all over the triangle.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from assetpipe.geometry.health.topology import face_areas
from assetpipe.geometry.mesh import FloatArray, IntArray
from assetpipe.geometry.repair.frame import Frame
from assetpipe.geometry.repair.result import Deviation
from assetpipe.geometry.repair.surface import Corners, Surface

Arrays = tuple[FloatArray, IntArray]
_SAMPLES = 4000
_TRIANGLES = 200_000


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
    corners: Corners,
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


def _quarters(corners: Corners) -> Corners:
    """Each triangle cut at its edges' midpoints."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    ab, bc, ca = (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0
    return np.concatenate(
        [np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
    )


def quantile(
    surface: Surface,
    arrays: tuple[FloatArray, IntArray],
    *,
    side: Literal["surface", "solid"],
    share: float = 0.99,
) -> float:
    """The distance within which ``share`` of the area of a surface lies (fixed sample)."""
    points = sample(*arrays, _SAMPLES)
    distance = surface.outside(points) if side == "solid" else surface.distance(points)
    return float(np.quantile(distance, share))


def deviation(before: Arrays, after: Arrays, *, resolution: float = 1e-3) -> Deviation:
    """Two-sided deviation between any surface and a solid, measured from scratch.

    Args:
        before: vertices (metres) and faces of the surface.
        after: vertices (metres) and faces of the solid.
        resolution: of the bounds, as a share of the diagonal.
    """
    frame = Frame.around(before[0])
    old, new = frame.inward(before[0]), frame.inward(after[0])
    old_surface, new_surface = Surface(old, before[1]), Surface(new, after[1])
    return Deviation(
        farthest(new_surface, old[before[1]], side="solid", resolution=resolution) * frame.scale,
        farthest(old_surface, new[after[1]], side="surface", resolution=resolution) * frame.scale,
        quantile(new_surface, (old, before[1]), side="solid") * frame.scale,
        quantile(old_surface, (new, after[1]), side="surface") * frame.scale,
        "bound",
    )
