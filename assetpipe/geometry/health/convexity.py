"""How far a surface is from convex."""

from __future__ import annotations

import numpy as np

from assetpipe.geometry.health.topology import distinct
from assetpipe.geometry.mesh import FloatArray, IntArray

_POINTS = 4000
_PRODUCTS = 20_000_000


def depth_below_hull(vertices: FloatArray, faces: IntArray) -> float:
    """The largest depth of the surface below its convex hull, as a share of the diagonal.

    Taken at vertices and face centres, at most 4,000 of them spread evenly: a lower
    bound, exact enough to tell a convex mesh from others.
    """
    from scipy.spatial import ConvexHull, QhullError

    used = vertices[distinct(faces)]
    low, high = used.min(axis=0), used.max(axis=0)
    diagonal = float(np.linalg.norm(high - low))
    if diagonal == 0.0:
        return 0.0
    centre = (low + high) / 2.0
    try:
        hull = ConvexHull((used - centre) / diagonal)
    except QhullError:
        return 0.0
    planes = np.unique(hull.equations.round(9), axis=0)
    points = (np.concatenate([used, vertices[faces].mean(axis=1)]) - centre) / diagonal
    wanted = min(_POINTS, max(200, _PRODUCTS // len(planes)))
    points = points[:: max(1, len(points) // wanted)]
    depth = np.full(len(points), np.inf)
    for start in range(0, len(planes), 256):
        part = planes[start : start + 256]
        np.minimum(depth, -(points @ part[:, :3].T + part[:, 3]).max(axis=1), out=depth)
    return float(max(0.0, depth.max()))
