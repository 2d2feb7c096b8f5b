"""The solid that a soup of faces stands for, by generalized winding number.

Jacobson et al. 2013, "Robust inside-outside segmentation using generalized winding
numbers"; evaluated by Barill et al. 2018, "Fast winding numbers for soups and clouds".
The surface where it is one half is found by marching cubes on cells near the soup and
wherever the surface leads from there, and then drawn to the soup where that is near.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from assetpipe.geometry.health.topology import distinct, missing
from assetpipe.geometry.mesh import FloatArray, IntArray
from assetpipe.geometry.products import products
from assetpipe.geometry.repair.deadline import NEVER, Deadline
from assetpipe.geometry.repair.frame import doublings
from assetpipe.geometry.repair.split import split_nonmanifold
from assetpipe.geometry.repair.surface import Surface
from assetpipe.geometry.repair.unite import arrays_of, manifold_of, signed_volume
from assetpipe.geometry.strays import referenced

Sense = Literal["outward", "either"]
CELL = 5e-3
"""Edge of the grid's cells, in units."""
_LEVEL = 0.5
_ROUNDS = 400
_NEIGHBOURS = np.array(
    [(-1, 0, 0), (1, 0, 0), (0, -1, 0), (0, 1, 0), (0, 0, -1), (0, 0, 1)], dtype=np.int64
)
_FACES = np.array(
    # Corners (numbered x + 2 y + 4 z) of the face towards each neighbour.
    [(0, 2, 4, 6), (1, 3, 5, 7), (0, 1, 4, 5), (2, 3, 6, 7), (0, 1, 2, 3), (4, 5, 6, 7)]
)
_CORNERS = np.array([(i & 1, i >> 1 & 1, i >> 2 & 1) for i in range(8)], dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Lattice:
    """Cells of edge ``cell``; corner (i, j, k) is at ``origin + cell * (i, j, k)``."""

    origin: FloatArray
    cell: float
    size: int

    def code(self, ijk: IntArray) -> IntArray:
        """One number a corner or cell."""
        result: IntArray = (ijk[..., 0] * self.size + ijk[..., 1]) * self.size + ijk[..., 2]
        return result

    def ijk(self, code: IntArray) -> IntArray:
        """The inverse of :meth:`code`."""
        k = code % self.size
        j = code // self.size % self.size
        return np.stack([code // (self.size * self.size), j, k], axis=-1)

    def points(self, code: IntArray) -> FloatArray:
        """(n, 3) positions of corners."""
        result: FloatArray = self.origin + self.cell * self.ijk(code)
        return result


def solid_of_soup(
    vertices: FloatArray,
    faces: IntArray,
    cell: float,
    cells: int,
    deadline: Deadline = NEVER,
    *,
    sense: Sense = "outward",
) -> tuple[FloatArray, IntArray] | None:
    """The closed surface around all points with a winding number above one half.

    Args:
        vertices: (n, 3).
        faces: (m, 3), wound as consistently as may be.
        cell: edge of the grid's cells.
        cells: how many there may be.
        deadline: past which LimitError is raised.
        sense: ``"either"``: what is enclosed inside-out counts as enclosed, too.

    Returns:
        Vertices and faces, closed and outward; ``None`` if nothing is enclosed or the
        grid would have too many cells.
    """
    import igl

    surface = Surface(vertices, faces)
    found = _cells(surface, cell, cells, deadline, sense)
    if found is None:
        return None
    lattice, active, corner_codes, values = found
    positions = lattice.points(corner_codes)
    index = np.searchsorted(
        corner_codes, lattice.code(lattice.ijk(active)[:, None] + _MARCHING_ORDER)
    )
    points, triangles, _ = igl.marching_cubes(values - _LEVEL, positions, index, 0.0)
    triangles = triangles.astype(np.int64)
    if len(triangles) < 4:
        return None
    if signed_volume(points, triangles) < 0.0:
        triangles = triangles[:, ::-1]
    points = _drawn(surface, points, triangles, cell)
    points, triangles, _ = split_nonmanifold(*referenced(points, triangles))
    whole = manifold_of(points, triangles)
    if whole is None:
        return None
    simple = whole.simplify(cell / 20.0)
    return None if simple.is_empty() else arrays_of(simple)


# The order in which libigl's marching cubes numbers a cell's corners.
_MARCHING_ORDER = np.array(
    [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)],
    dtype=np.int64,
)


def _cells(
    surface: Surface, cell: float, limit: int, deadline: Deadline, sense: Sense
) -> tuple[Lattice, IntArray, IntArray, FloatArray] | None:
    """Cells that the surface of level one half passes, followed wherever it leads."""
    import igl

    low = surface.vertices.min(axis=0) - 3.0 * cell
    extent = float((surface.vertices.max(axis=0) + 3.0 * cell - low).max())
    depth = max(1, doublings(extent / cell))
    lattice = Lattice(low, cell, (1 << depth) + 3)
    near = igl.lipschitz_octree(low, cell * (1 << depth), depth, surface.distance)
    if len(near) > limit:
        return None
    active = distinct(lattice.code(np.asarray(near, dtype=np.int64)))
    codes = np.zeros(0, dtype=np.int64)
    values = np.zeros(0)
    fresh = active
    for _ in range(_ROUNDS):
        deadline.check()
        corners = lattice.code(lattice.ijk(fresh)[:, None] + _CORNERS)
        unknown = missing(corners, codes)
        codes = np.concatenate([codes, unknown])
        around = surface.winding(lattice.points(unknown))
        values = np.concatenate([values, around if sense == "outward" else np.abs(around)])
        order = np.argsort(codes, kind="stable")
        codes, values = codes[order], values[order]
        inside = values[np.searchsorted(codes, corners)] > _LEVEL
        steps = []
        for step, face in zip(_NEIGHBOURS, _FACES, strict=True):
            crossed = inside[:, face].any(axis=1) & ~inside[:, face].all(axis=1)
            steps.append(lattice.ijk(fresh[crossed]) + step)
        reached = np.concatenate(steps)
        reached = reached[((reached >= 0) & (reached < lattice.size - 1)).all(axis=1)]
        fresh = missing(lattice.code(reached), active)
        if not len(fresh):
            return lattice, active, codes, values
        active = distinct(np.concatenate([active, fresh]))
        if len(active) > limit:
            return None
    return None


def _drawn(surface: Surface, points: FloatArray, triangles: IntArray, cell: float) -> FloatArray:
    """Draw vertices to the closest point of the soup, where it is nearer than a cell.

    A vertex stays where drawing it would turn one of its faces around.
    """
    distance, _, closest = surface.closest(points)
    near = distance < cell
    before = np.cross(
        points[triangles[:, 1]] - points[triangles[:, 0]],
        points[triangles[:, 2]] - points[triangles[:, 0]],
    )
    for _ in range(8):
        drawn = np.where(near[:, None], closest, points)
        after = np.cross(
            drawn[triangles[:, 1]] - drawn[triangles[:, 0]],
            drawn[triangles[:, 2]] - drawn[triangles[:, 0]],
        )
        turned = products(before, after) < 0.0
        if not turned.any():
            return drawn
        near[triangles[turned]] = False
    return np.where(near[:, None], closest, points)
