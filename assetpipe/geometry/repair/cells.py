"""A complex of faces as the boundary of cells, and which of these are material.

Faces may meet in any number at an edge. They divide space into cells (Zhou et al. 2016,
"Mesh arrangements for solid geometry", §4, without their exact predicates); each cell is
material or not, and the faces between the two kinds are the solid's surface.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from assetpipe.geometry.health.topology import (
    Edges,
    components,
    face_areas,
    face_components,
    groups,
)
from assetpipe.geometry.mesh import FloatArray, IntArray
from assetpipe.geometry.products import products
from assetpipe.geometry.repair.clean import same_corners
from assetpipe.geometry.repair.sides import joined_sides, other_side, rims
from assetpipe.geometry.repair.surface import Surface

_SAMPLES = 5
_ASIDE = 1e-3
_NOTHING = 1e-12
_MOST = 2.0 / 3.0
"""Share of a skin's area that is drawn inward where it is meant to be."""


@dataclass(frozen=True, eq=False)
class Separated:
    """Faces of a complex by their part in the solid.

    Attributes:
        skin: (k, 3) faces between material and none, wound outward (inward for a component
            that the input winds inward: it may be a cavity of another).
        inner: (k, 3) faces with material on both sides.
        sheets: (k, 3) faces with none on either side.
        bodies: how many cells are material.
    """

    skin: IntArray
    inner: IntArray
    sheets: IntArray
    bodies: int


def separate(vertices: FloatArray, drawn: IntArray) -> Separated:
    """Find the cells of a complex and what lies between them.

    A bounded cell is material if the faces' winding says so: where all edges of its
    component are passed as often each way, the winding number is an integer and decides.
    Where they are not, the walls disagree about their outside, and every bounded cell
    counts as material; so too where most walls are drawn from both sides.

    Args:
        vertices: (n, 3).
        drawn: (d, 3) faces, copies included.
    """
    group, count, winds = same_corners(drawn)
    lead = np.full(count, len(drawn), dtype=np.int64)
    np.minimum.at(lead, group, np.arange(len(drawn)))
    order = np.argsort(lead, kind="stable")
    faces = drawn[lead[order]]
    net = np.bincount(group, winds, count)[order]
    m = len(faces)
    edges = Edges.of(faces, len(vertices))
    ahead, behind = joined_sides(vertices, faces, edges)
    rim = rims(edges)
    number, cell = components(
        2 * m,
        np.concatenate([ahead, rim]) // 3,
        np.concatenate([behind, other_side(rim, m)]) // 3,
    )
    areas, _ = face_areas(vertices, faces)
    centre = (vertices.min(axis=0) + vertices.max(axis=0)) / 2.0
    a, b, c = (vertices[faces[:, k]] - centre for k in range(3))
    each = products(a, np.cross(b, c)) / 6.0
    # Normals of sides look into the cell: a bounded cell has a negative volume.
    volume: FloatArray = np.bincount(cell, np.concatenate([each, -each]), number).astype(float)
    area = np.bincount(cell, np.concatenate([areas, areas]), number)
    bounded = volume < -_NOTHING * area
    parts, component = face_components(edges)
    trusted = _trusted(drawn, len(vertices), component[np.argsort(order)[group]], parts)
    nothing = np.bincount(component, np.where(net == 0, areas, 0.0), parts)
    trusted &= 2.0 * nothing < np.bincount(component, areas, parts)
    material = bounded.copy()
    inward = np.zeros(parts)
    field = Surface(vertices, drawn)
    members = groups(cell, number)
    for k in np.flatnonzero(bounded).tolist():
        own = int(component[members[k][0] % m])
        if trusted[own]:
            winding = _winding(vertices, faces, members[k], areas, field)
            material[k] = abs(winding) > 0.5
            inward[own] -= volume[k] * winding
    # A cell without volume between two walls that coincide: inside if all around it is.
    around = np.concatenate([cell[m:], cell[:m]])
    touched = np.bincount(cell, ~material[around] & (around != cell), number) > 0.0
    outermost = np.zeros(number, dtype=bool)
    outermost[_outermost(component, cell, volume)] = True
    material |= (np.abs(volume) <= _NOTHING * area) & ~touched & ~outermost
    top, bottom = material[cell[:m]], material[cell[m:]]
    outward = bottom.astype(float) - top
    drawn_so = outward * net * winds[lead[order]]
    inward = np.where(trusted, inward, _agreed(drawn_so, np.abs(outward) * areas, component))
    skin = np.where((top & ~bottom)[:, None], faces[:, ::-1], faces)
    skin = np.where((inward[component] < 0.0)[:, None], skin[:, ::-1], skin)
    return Separated(
        skin[top != bottom], faces[top & bottom], faces[~top & ~bottom], int(material.sum())
    )


def _outermost(component: IntArray, cell: IntArray, volume: FloatArray) -> IntArray:
    """The unbounded cell of each component: the one of largest volume, seen from inside."""
    owner = np.concatenate([component, component])
    order = np.lexsort((cell, volume[cell], owner))
    last = np.append(np.flatnonzero(np.diff(owner[order])), len(order) - 1)
    result: IntArray = cell[order[last]]
    return result


def _trusted(
    drawn: IntArray, vertices: int, component: IntArray, parts: int
) -> npt.NDArray[np.bool_]:
    """Which components pass every edge as often each way."""
    edges = Edges.of(drawn, vertices)
    odd = np.flatnonzero(edges.balance)
    result = np.ones(parts, dtype=bool)
    result[component[edges.order[edges.first[odd]] // 3]] = False
    return result


def _agreed(agree: FloatArray, areas: FloatArray, component: IntArray) -> FloatArray:
    """For each component −1 if nearly all of its skin is drawn inward, else 0.

    A few faces the wrong way round do not make a body of a cavity.

    Args:
        agree: (m,) positive where a face is drawn outward, negative where inward.
        areas: (m,) of the skin, 0 for other faces.
        component: (m,).
    """
    inward = np.bincount(component, np.where(agree < 0.0, areas, 0.0))
    return np.where(inward > _MOST * np.bincount(component, areas), -1.0, 0.0)


def _winding(
    vertices: FloatArray, faces: IntArray, sides: IntArray, areas: FloatArray, field: Surface
) -> float:
    """The winding number inside a cell: the median next to its largest faces."""
    m = len(faces)
    face = sides % m
    chosen = sides[np.argsort(-areas[face], kind="stable")[:_SAMPLES]]
    corners = vertices[faces[chosen % m]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1)
    # A step in proportion to the face, towards the cell.
    step = _ASIDE * np.sqrt(length) / np.maximum(length, np.finfo(float).tiny)
    step = np.where(chosen < m, step, -step)
    points = corners.mean(axis=1) + step[:, None] * normal
    return float(np.median(field.winding(points)))
