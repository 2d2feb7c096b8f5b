"""Shrink hulls by the margin that an engine adds around them."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from assetpipe.geometry.mesh import FloatArray, IntArray, Mesh
from assetpipe.validation.contact.surface import facet_planes
from assetpipe.validation.profiles import insphere
from assetpipe.validation.shape_key import ByContent

LEAST_RADIUS = 0.2
"""Share of a hull's in-sphere radius that erosion leaves at least."""


def eroded(hull: Mesh, margin: float) -> Mesh:
    """The points of a convex hull that are at least ``margin`` (metres) inside its facets.

    A ball of that radius swept over the result fills the hull up to its facets and rounds
    its edges, so an engine that puts a margin around every hull sees the facets where they
    are. Hulls thinner than two margins keep a core and stay thicker in the engine, by at
    most the margin.

    Args:
        hull: convex; a mesh that is not is treated as its convex hull, as engines do.
        margin: metres.
    """
    return _eroded(ByContent(hull), margin)


@lru_cache(maxsize=1024)
def _eroded(key: ByContent, margin: float) -> Mesh:
    from scipy.spatial import ConvexHull, HalfspaceIntersection, QhullError

    hull = key.mesh
    points: FloatArray = hull.vertices
    try:
        outer = ConvexHull(points)
    except (QhullError, ValueError):
        return hull  # flat: the engine gets it as it is
    convex = Mesh(points, _outward(points, np.asarray(outer.simplices, dtype=np.int64)))
    centre, radius = insphere(convex)
    depth = min(margin, (1.0 - LEAST_RADIUS) * radius)
    if not depth > 0.0:
        return convex
    normals, offsets = facet_planes(convex)
    # Qhull's halfspaces are n·x + b ≤ 0; solved around the centre for precision.
    bounds = np.column_stack([normals, depth - (offsets - normals @ centre)])
    try:
        corners = HalfspaceIntersection(bounds, np.zeros(3)).intersections
        corners = corners[np.isfinite(corners).all(axis=1)]
        inner = ConvexHull(corners)
    except (QhullError, ValueError):
        return convex
    used = np.asarray(inner.vertices)
    kept = corners[used] + centre
    index = np.full(len(corners), -1, dtype=np.int64)
    index[used] = np.arange(len(used))
    return Mesh(kept, _outward(kept, index[np.asarray(inner.simplices, dtype=np.int64)]))


def _outward(points: FloatArray, faces: IntArray) -> IntArray:
    centre = points[np.unique(faces)].mean(axis=0)
    a, b, c = (points[faces[:, k]] for k in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a - centre) < 0.0
    faces = faces.copy()
    faces[inward] = faces[inward][:, ::-1]
    return faces
