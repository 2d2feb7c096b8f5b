"""Seams between hulls that overlap, so that nothing catches on them or falls between.

Neighbouring hulls meet in a plane cut. Where both are flush, an engine that resolves contacts
hull by hull may see an inner edge; where slimming or rounding left them a hair apart, a
gap. One of the two is therefore extended into the other: by the slab of the
neighbour that lies within the overlap of its own faces. Both ends of the extension are within
hulls that are proved, and what bulges between them is proved again.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from assetpipe.decomposition.certificate import Certificate, Interval
from assetpipe.decomposition.hull import Hull
from assetpipe.errors import CancelledError
from assetpipe.geometry.mesh import FloatArray, Mesh
from assetpipe.geometry.products import products

_TOUCHING = 1e-9
"""Of the solid's diagonal: hulls nearer than that are neighbours."""


@dataclass(frozen=True)
class Seams:
    """What became of the seams.

    Attributes:
        overlap: metres, as asked.
        widened: pairs of neighbours that overlap now.
        open: pairs that do not, because the proof or the budget of vertices left no room.
    """

    overlap: float
    widened: int
    open: int

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {"overlap": self.overlap, "widened": self.widened, "open": self.open}


def with_overlap(
    solid: Mesh,
    hulls: Sequence[Hull],
    overlap: float,
    epsilon: float,
    *,
    max_vertices: int | None = None,
    on_progress: Callable[[float], object] | None = None,
) -> tuple[tuple[Hull, ...], Seams]:
    """Extend hulls across their seams by ``overlap`` metres as far as they are proved to stay
    within ``epsilon`` of the solid.

    Args:
        solid: what the hulls stand for, metres.
        hulls: of a decomposition.
        overlap: metres.
        epsilon: metres.
        max_vertices: most vertices a hull may have.
        on_progress: as in :func:`assetpipe.decompose`.

    Returns:
        The hulls in the same order, and what became of the seams.
    """
    found = list(hulls)
    pairs = _neighbours(hulls, _TOUCHING * solid.diagonal)
    widened = 0
    for done, (i, j) in enumerate(pairs):
        if on_progress is not None and on_progress(done / len(pairs)) is False:
            raise CancelledError("cancelled")
        # The smaller one first: it bulges less.
        order = (i, j) if hulls[i].volume <= hulls[j].volume else (j, i)
        for own, other in (order, order[::-1]):
            slab = _clipped(hulls[other].mesh, hulls[own].mesh, overlap)
            if slab is None:
                continue
            extended = _extended(solid, found[own], slab, epsilon, max_vertices)
            if extended is not None:
                found[own] = extended
                widened += 1
                break
    return tuple(found), Seams(overlap, widened, len(pairs) - widened)


def _neighbours(hulls: Sequence[Hull], near: float) -> list[tuple[int, int]]:
    """Pairs of hulls that touch or overlap."""
    low = np.array([hull.vertices.min(axis=0) for hull in hulls]) - near
    high = np.array([hull.vertices.max(axis=0) for hull in hulls])
    pairs = []
    for i in range(len(hulls)):
        meet = ((low[i + 1 :] <= high[i]) & (low[i] <= high[i + 1 :])).all(axis=1)
        pairs += [
            (i, j)
            for j in (np.flatnonzero(meet) + i + 1).tolist()
            if _clipped(hulls[j].mesh, hulls[i].mesh, near) is not None
        ]
    return pairs


def _clipped(mesh: Mesh, by: Mesh, offset: float) -> FloatArray | None:
    """Vertices of ``mesh`` within the half-spaces of another hull's faces, each moved outward
    by ``offset``; ``None`` if nothing is left."""
    from assetpipe import _core

    a, b, c = (by.vertices[by.faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    lengths = np.linalg.norm(normals, axis=1)
    sound = lengths > 0.0
    normals = normals[sound] / lengths[sound, None]
    offsets = products(normals, a[sound]) + offset
    vertices, faces = np.array(mesh.vertices), np.array(mesh.faces)
    for normal, limit in zip(normals, offsets, strict=True):
        heights = products(vertices, normal) - limit
        if (heights <= 0.0).all():
            continue
        if (heights >= 0.0).all():
            return None
        below, _ = _core.split(vertices, faces, tuple(normal.tolist()), float(limit))
        if below is None:
            return None
        vertices, faces = below
    return np.asarray(vertices)


def _extended(
    solid: Mesh, hull: Hull, slab: FloatArray, epsilon: float, max_vertices: int | None
) -> Hull | None:
    """The hull of both, if it is proved."""
    from assetpipe import _core

    vertices, faces = _core.convex_hull(np.vstack([hull.vertices, slab]))
    if max_vertices is not None and len(vertices) > max_vertices:
        return None
    (proof,) = _core.thickening_within(
        np.ascontiguousarray(solid.vertices),
        np.ascontiguousarray(solid.faces),
        [vertices],
        epsilon,
    )
    if proof is None:
        return None
    mesh = Mesh(vertices, faces)
    return Hull(mesh.vertices, mesh.faces, mesh.volume, Certificate(Interval(*proof), None))
