"""Is it a solid? Our own check: a library's status is not proof."""

from __future__ import annotations

import numpy as np

from assetpipe.geometry.health.topology import Edges, umbrellas
from assetpipe.geometry.mesh import FloatArray, IntArray, Mesh


def defect(vertices: FloatArray, faces: IntArray) -> str | None:
    """Why (vertices, faces) is not a closed 2-manifold of positive volume, or ``None``.

    Closed means that every directed edge occurs once and its reverse once; manifold
    that the faces around each vertex form one umbrella; and every vertex is used.
    Nothing is said about self-intersection.
    """
    if len(faces) < 4:
        return f"{len(faces)} faces enclose nothing"
    used = np.zeros(len(vertices), dtype=bool)
    used[faces] = True
    if not used.all():
        return f"{int((~used).sum())} vertices belong to no face"
    a, b, c = faces.T
    if ((a == b) | (b == c) | (c == a)).any():
        return "a face names a vertex twice"
    edges = Edges.of(faces, len(vertices))
    if len(edges.boundary):
        return f"{len(edges.boundary)} edges have one face only"
    if len(edges.nonmanifold):
        return f"{len(edges.nonmanifold)} edges have more than two faces"
    if len(edges.inconsistent):
        return f"{len(edges.inconsistent)} edges separate faces of opposite winding"
    first, second = edges.pair(edges.regular)
    corners, _ = umbrellas(faces, first, second)
    if corners != len(vertices):
        return f"{corners - len(vertices)} vertices join several umbrellas"
    volume = Mesh(vertices, faces).volume
    if volume <= 0.0:
        return f"the enclosed volume is {volume:g} m³"
    return None


def is_solid(mesh: Mesh) -> bool:
    """Whether the mesh is a closed 2-manifold of positive volume (see :func:`defect`)."""
    return defect(mesh.vertices, mesh.faces) is None
