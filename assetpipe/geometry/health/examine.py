"""Examining a mesh: every defect, counted."""

from __future__ import annotations

from typing import Literal

import numpy as np

from assetpipe.geometry.health.convexity import depth_below_hull
from assetpipe.geometry.health.crossings import crossing_faces
from assetpipe.geometry.health.report import Defect, Health, Soundness
from assetpipe.geometry.health.topology import (
    Edges,
    boundary_loops,
    distinct,
    face_areas,
    face_components,
    umbrellas,
)
from assetpipe.geometry.health.weld import degenerate, exact_duplicates
from assetpipe.geometry.mesh import FloatArray, IntArray, Mesh

_SLIVER = 1e-3
_FLAT = 1e-9


def examine(mesh: Mesh, *, crossings: Literal["count", "skip"] = "skip") -> Health:
    """Count every defect of a mesh.

    Args:
        mesh: any triangles, metres.
        crossings: ``"count"`` also looks for faces that cross each other, which costs more
            than everything else together; a mesh too crowded for it gets a note.

    Returns:
        :class:`Health`.

    Raises:
        LimitError: coordinates with which areas and volumes are no numbers any more.
    """
    mesh.check_size()
    keep, to = exact_duplicates(mesh.vertices)
    vertices, faces = mesh.vertices[keep], to[mesh.faces]
    bad = degenerate(faces)
    faces = np.delete(faces, bad, axis=0)
    notes: list[str] = []
    edges = Edges.of(faces, len(vertices))
    number, label = face_components(edges)
    doubled = _doubled(faces)
    thin, zero = _thin(vertices, faces)
    first, second = edges.pair(edges.regular)
    joined = _joined_vertices(faces, len(vertices), *edges.pair(np.flatnonzero(edges.count == 2)))
    loops = boundary_loops(faces, first, second)
    widths = [_extent(vertices[loop]) for loop in loops]
    closed = bool(len(faces)) and not np.any(edges.balance)
    volumes = _volumes(vertices, faces, label, number)
    inverted, cavities = (
        _inward(vertices, faces, label, volumes)
        if closed and not len(edges.nonmanifold)
        else (0, 0)
    )
    crossing: Defect | None = None
    if crossings == "count" and len(faces):
        found = crossing_faces(vertices, faces)
        if found is None:
            notes.append("self-intersection was not examined: too many faces lie close together")
        else:
            crossing = Defect.of(vertices[faces[found[:, 0]]].mean(axis=1))
    elif len(faces):
        notes.append("self-intersection was not examined")
    flat = _is_flat(vertices, faces)
    soundness = _soundness(
        edges,
        faces,
        flat=flat,
        joined=len(joined),
        number=number,
        inverted=inverted,
        crossing=crossing,
        welded=len(keep) < len(mesh.vertices) or len(bad) > 0,
    )
    low, high = mesh.bounds
    extents = high - low
    return Health(
        soundness=soundness,
        vertices=len(mesh.vertices),
        faces=len(mesh.faces),
        components=number,
        duplicate_vertices=len(mesh.vertices) - len(keep),
        degenerate_faces=len(bad),
        duplicate_faces=Defect.of(vertices[faces[doubled]].mean(axis=1)),
        zero_area_faces=Defect.of(vertices[faces[zero]].mean(axis=1)),
        sliver_faces=Defect.of(vertices[faces[thin]].mean(axis=1)),
        boundary_edges=Defect.of(vertices[edges.ends[edges.boundary]].mean(axis=1)),
        openings=Defect.of(
            np.array([vertices[loop].mean(axis=0) for loop in loops]).reshape(-1, 3)
        ),
        widest_opening=max(widths, default=0.0),
        nonmanifold_edges=Defect.of(vertices[edges.ends[edges.nonmanifold]].mean(axis=1)),
        nonmanifold_vertices=Defect.of(vertices[joined]),
        inconsistent_edges=Defect.of(vertices[edges.ends[edges.inconsistent]].mean(axis=1)),
        inverted_components=inverted,
        cavities=cavities,
        self_intersections=crossing,
        closed=closed,
        convex_within=depth_below_hull(vertices, faces) if len(faces) and not flat else 0.0,
        volume=float(volumes.sum()) if closed else None,
        area=mesh.area,
        extents=(float(extents[0]), float(extents[1]), float(extents[2])),
        diagonal=mesh.diagonal,
        notes=tuple(notes),
    )


def _soundness(
    edges: Edges,
    faces: IntArray,
    *,
    flat: bool,
    joined: int,
    number: int,
    inverted: int,
    crossing: Defect | None,
    welded: bool,
) -> Soundness:
    rules = (
        (not len(faces), Soundness.EMPTY),
        (flat, Soundness.FLAT),
        (len(edges.boundary) > 0, Soundness.OPEN),
        (len(edges.nonmanifold) > 0 or joined > 0, Soundness.NON_MANIFOLD),
        (len(edges.inconsistent) > 0, Soundness.INCONSISTENT),
        (bool(crossing), Soundness.SELF_INTERSECTING),
        (number > 1, Soundness.SEVERAL),
        (inverted > 0, Soundness.INSIDE_OUT),
        (welded, Soundness.NEEDS_WELD),
    )
    return next((state for holds, state in rules if holds), Soundness.SOLID)


def _doubled(faces: IntArray) -> IntArray:
    """Faces that repeat the vertices of an earlier one."""
    order = np.sort(faces, axis=1)
    by = np.lexsort((order[:, 2], order[:, 1], order[:, 0]))
    same = (order[by][1:] == order[by][:-1]).all(axis=1)
    return np.sort(by[1:][same])


def _thin(vertices: FloatArray, faces: IntArray) -> tuple[IntArray, IntArray]:
    """Slivers, and faces of no area at all."""
    areas, _ = face_areas(vertices, faces)
    corners = vertices[faces]
    longest = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max(
        axis=1, initial=0.0
    )
    height = 2.0 * areas / np.maximum(longest, np.finfo(float).tiny)
    none = height <= 1e-12 * longest
    return np.flatnonzero((height < _SLIVER * longest) & ~none), np.flatnonzero(none)


def _joined_vertices(faces: IntArray, vertices: int, first: IntArray, second: IntArray) -> IntArray:
    """Vertices that belong to several umbrellas."""
    number, corners = umbrellas(faces, first, second)
    source = np.zeros(number, dtype=np.int64)
    source[corners.ravel()] = faces.ravel()
    return np.flatnonzero(np.bincount(source, minlength=vertices) > 1)


def _extent(points: FloatArray) -> float:
    return float(np.linalg.norm(points.max(axis=0) - points.min(axis=0)))


def _volumes(vertices: FloatArray, faces: IntArray, label: IntArray, number: int) -> FloatArray:
    """(number,) signed volume of each component."""
    if not number:
        return np.zeros(0)
    centre = (vertices.min(axis=0) + vertices.max(axis=0)) / 2.0
    a, b, c = (vertices[faces[:, k]] - centre for k in range(3))
    each = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    return np.asarray(np.bincount(label, each, number), dtype=np.float64)


def _inward(
    vertices: FloatArray, faces: IntArray, label: IntArray, volumes: FloatArray
) -> tuple[int, int]:
    """How many inward components lie in no other, and how many in one."""
    import igl

    inverted = cavities = 0
    for k in np.flatnonzero(volumes < 0.0):
        rest = faces[label != k]
        point = vertices[faces[np.flatnonzero(label == k)[0], 0]]
        around = len(rest) and abs(float(igl.winding_number(vertices, rest, point))) > 0.5
        cavities += bool(around)
        inverted += not around
    return inverted, cavities


def _is_flat(vertices: FloatArray, faces: IntArray) -> bool:
    """Whether all used vertices lie in one plane."""
    if not len(faces):
        return True
    used = vertices[distinct(faces)]
    arms = used - used.mean(axis=0)
    spread = np.linalg.eigvalsh(arms.T @ arms)
    return bool(spread[0] <= (_FLAT * _FLAT) * spread[2])
