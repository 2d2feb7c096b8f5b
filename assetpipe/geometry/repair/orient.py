"""Consistent winding across edges, and outward orientation of closed shells."""

from __future__ import annotations

import numpy as np

from assetpipe.geometry.health.topology import Edges, components, distinct, face_areas
from assetpipe.geometry.mesh import FloatArray, IntArray


def wind_consistently(vertices: FloatArray, faces: IntArray) -> tuple[IntArray, int, int]:
    """Flip faces until neighbours over two-face edges agree.

    In each patch the winding of the larger area stays. A patch that is one-sided
    (a Möbius band) cannot agree; it is left as it is.

    Returns:
        Faces, how many were flipped, and how many patches are one-sided.
    """
    edges = Edges.of(faces, len(vertices))
    if not len(edges.inconsistent):
        return faces, 0, 0
    m = len(faces)
    same_a, same_b = (half // 3 for half in edges.pair(edges.regular))
    flip_a, flip_b = (half // 3 for half in edges.pair(edges.inconsistent))
    # Two copies of each face, as it is and flipped: a link joins copies that agree.
    a = np.concatenate([same_a, same_a + m, flip_a, flip_a + m])
    b = np.concatenate([same_b, same_b + m, flip_b + m, flip_b])
    _, labels = components(2 * m, a, b)
    as_is, flipped = labels[:m], labels[m:]
    one_sided = as_is == flipped
    patch = np.minimum(as_is, flipped)
    areas, _ = face_areas(vertices, faces)
    weight = np.bincount(patch, np.where(as_is == patch, areas, -areas), int(patch.max()) + 1)
    flip = np.where(weight[patch] >= 0.0, as_is != patch, as_is == patch) & ~one_sided
    result = faces.copy()
    result[flip] = result[flip][:, ::-1]
    return result, int(flip.sum()), len(distinct(patch[one_sided]))
