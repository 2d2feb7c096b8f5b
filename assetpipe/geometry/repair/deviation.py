"""How far two surfaces lie apart, both ways, as a bound.

Branch and bound over triangles: the distance to a surface is 1-Lipschitz, so that
its value at a triangle's centre plus the triangle's radius bounds it all over the triangle.
Triangles that lie on the surface, but on several of its faces, are cut where these end;
slender ones are halved, and others quartered.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from assetpipe.geometry.health.topology import BoolArray, face_areas
from assetpipe.geometry.mesh import FloatArray, IntArray
from assetpipe.geometry.repair.deadline import NEVER, Deadline
from assetpipe.geometry.repair.frame import Frame
from assetpipe.geometry.repair.pieces import divided
from assetpipe.geometry.repair.result import Deviation
from assetpipe.geometry.repair.surface import Corners, Surface

Side = Literal["surface", "solid"]
Arrays = tuple[FloatArray, IntArray]
RESOLUTION = 5e-4
"""How sharp measured bounds are, in units."""
_SAMPLES = 4000
_TRIANGLES = 40_000
_SHARP = 1.05
_MIDDLE = (0.3139, 0.3372, 0.3489)
"""A point of each triangle near its centre, which in symmetric ones lies on too many edges."""
_ON = 1e-9
"""Units from the surface within which a point counts as one of it."""


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
    side: Side,
    resolution: float,
    floor: float = 0.0,
    whole: BoolArray | None = None,
    deadline: Deadline = NEVER,
) -> float:
    """Upper bound on the distance of any point of triangles to a surface (see below)."""
    owner = np.zeros(len(corners), dtype=np.int64)
    each = farthest_each(
        surface,
        corners,
        owner,
        1,
        side=side,
        resolution=resolution,
        floor=floor,
        whole=whole,
        deadline=deadline,
    )
    return float(each[0])


def farthest_each(
    surface: Surface,
    corners: Corners,
    owner: IntArray,
    owners: int,
    *,
    side: Side,
    resolution: float,
    floor: float = 0.0,
    ceiling: float = np.inf,
    whole: BoolArray | None = None,
    deadline: Deadline = NEVER,
) -> FloatArray:
    """Upper bounds on the distance of any point of groups of triangles to a surface.

    Args:
        surface: the target.
        corners: (n, 3, 3) triangles.
        owner: (n,) group of each.
        owners: how many groups.
        side: ``"surface"``: distance to the surface; ``"solid"``: zero inside it.
        resolution: how much larger than 1.05 of the truth a bound may be, if affordable.
        floor: bounds below need not be sharp.
        ceiling: bounds above need not be sharp.
        whole: (n,) triangles that are inside as soon as one point is, see
            :func:`assetpipe.geometry.repair.within.whole`. ``None``: nobody knows.
        deadline: past which LimitError is raised.

    Returns:
        (owners,) bounds.
    """
    reached, settled = np.zeros(owners), np.zeros(owners)
    whole = np.zeros(len(corners), dtype=bool) if whole is None else whole

    def enough() -> FloatArray:
        """(n,) what need not be known more sharply."""
        return np.maximum(_SHARP * reached[owner] + resolution, floor)

    while len(corners):
        deadline.check()
        centre = _MIDDLE[0] * corners[:, 0] + _MIDDLE[1] * corners[:, 1]
        centre = centre + _MIDDLE[2] * corners[:, 2]
        radius = np.sqrt(((corners - centre[:, None]) ** 2).sum(axis=2).max(axis=1))
        distance, face, _ = surface.closest(centre)
        upper = np.minimum(distance + radius, surface.bound_over(corners, face))
        if side == "solid":
            asked = (upper > enough()) & (distance > _ON)
            inside = np.flatnonzero(asked)
            inside = inside[surface.contains(centre[inside])]
            # The centre is inside: what lies nearer to it than the surface is inside too.
            upper[inside] = np.maximum(0.0, radius[inside] - distance[inside])
            upper[inside[whole[inside]]] = 0.0
            distance[inside] = 0.0
            # Nobody asked whether the others are inside; they don't count as reached.
            distance[~asked & (distance > _ON)] = 0.0
        np.maximum.at(reached, owner, distance)
        undecided = (upper > enough()) & (reached[owner] <= ceiling)
        np.maximum.at(settled, owner[~undecided], upper[~undecided])
        corners, owner, face = corners[undecided], owner[undecided], face[undecided]
        whole = whole[undecided]
        parts, source = divided(corners, surface.vertices[surface.faces[face]], enough())
        if len(parts) > _TRIANGLES:
            np.maximum.at(settled, owner, upper[undecided])
            break
        corners, owner, whole = parts, owner[source], whole[source]
    return np.maximum(settled, reached)


def quantile(
    surface: Surface,
    arrays: tuple[FloatArray, IntArray],
    *,
    side: Side,
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
