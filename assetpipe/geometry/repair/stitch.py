"""Boundaries that nearly meet: tolerance weld and T-junctions.

Only boundary vertices move, so that closed parts of the surface keep their bits.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from assetpipe.geometry.health.topology import Edges, components, distinct
from assetpipe.geometry.health.weld import degenerate
from assetpipe.geometry.mesh import FloatArray, IntArray
from assetpipe.geometry.products import products
from assetpipe.geometry.repair.subdivide import insert_on_edges
from assetpipe.geometry.repair.surface import Corners, no_corners
from assetpipe.geometry.strays import referenced

_CANDIDATES = 5_000_000


@dataclass(frozen=True, eq=False)
class Stitched:
    """Arrays after stitching.

    Attributes:
        vertices: (n, 3).
        faces: (m, 3).
        welded: vertices that were joined with others.
        inserted: vertices that were put onto edges.
        displacement: how far a point of the faces that are left moved at most.
        dropped: the faces that collapsed, as they were: nothing need be left where they lay.
    """

    vertices: FloatArray
    faces: IntArray
    welded: int = 0
    inserted: int = 0
    displacement: float = 0.0
    dropped: Corners = field(default_factory=no_corners)


def boundary_length(vertices: FloatArray, faces: IntArray) -> float:
    """Total length of unbalanced edges: what is left to close."""
    edges = Edges.of(faces, len(vertices))
    ends = vertices[edges.ends[np.flatnonzero(edges.count % 2 == 1)]]
    return float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum())


def weld_boundary(vertices: FloatArray, faces: IntArray, tolerance: float) -> Stitched:
    """Join boundary vertices closer than ``tolerance`` into the first of each cluster.

    Clusters are connected by pairs within the tolerance. They may be longer than that;
    what lies farther from the first stays.
    """
    from scipy.spatial import cKDTree

    edges = Edges.of(faces, len(vertices))
    rim = distinct(edges.ends[np.flatnonzero(edges.count % 2 == 1)])
    if not len(rim):
        return Stitched(vertices, faces)
    pairs = cKDTree(vertices[rim]).query_pairs(tolerance, output_type="ndarray")
    if not len(pairs):
        return Stitched(vertices, faces)
    _, label = components(len(rim), pairs[:, 0], pairs[:, 1])
    _, lead = np.unique(label, return_index=True)
    target = rim[lead[label]]
    distance = np.linalg.norm(vertices[target] - vertices[rim], axis=1)
    target = np.where(distance <= tolerance, target, rim)
    displacement = float(distance[distance <= tolerance].max())
    to = np.arange(len(vertices))
    to[rim] = target
    joined = to[faces]
    gone = degenerate(joined)
    kept, left = referenced(vertices, np.delete(joined, gone, axis=0))
    welded = int((target != rim).sum())
    return Stitched(kept, left, welded, 0, displacement, vertices[faces[gone]])


def insert_junctions(vertices: FloatArray, faces: IntArray, tolerance: float) -> Stitched:
    """Put boundary vertices onto the boundary edges that they nearly lie on.

    The face at the edge is bent to the vertex, by at most the tolerance.
    """
    edges = Edges.of(faces, len(vertices))
    odd = np.flatnonzero(edges.count == 1)
    if not len(odd):
        return Stitched(vertices, faces)
    half = edges.order[edges.first[odd]]
    start = faces.ravel()[half]
    end = np.roll(faces, -1, axis=1).ravel()[half]
    found = _on_edges(vertices, start, end, distinct(edges.ends[odd]), tolerance)
    if found is None:
        return Stitched(vertices, faces)
    edge, vertex, share, distance = found
    # No vertex may come into a face that has it already.
    keep = vertex != edges.apex(half)[edge]
    edge, vertex, share, distance = edge[keep], vertex[keep], share[keep], distance[keep]
    if not len(edge):
        return Stitched(vertices, faces)
    order = np.lexsort((vertex, share, edge))
    points: dict[int, list[int]] = {}
    for e, v in zip(edge[order].tolist(), vertex[order].tolist(), strict=True):
        points.setdefault(int(half[e]), []).append(v)
    cut = insert_on_edges(faces, points)
    gone = degenerate(cut)
    kept, left = referenced(vertices, np.delete(cut, gone, axis=0))
    return Stitched(kept, left, 0, len(edge), float(distance.max()), vertices[cut[gone]])


def _on_edges(
    vertices: FloatArray, start: IntArray, end: IntArray, rim: IntArray, tolerance: float
) -> tuple[IntArray, IntArray, FloatArray, FloatArray] | None:
    """Which rim vertices lie on which edges: edge, vertex, share along it and distance."""
    from scipy.spatial import cKDTree

    a, b = vertices[start], vertices[end]
    length = np.linalg.norm(b - a, axis=1)
    tree = cKDTree(vertices[rim])
    reach = length / 2.0 + tolerance
    if tree.query_ball_point((a + b) / 2.0, reach, return_length=True).sum() > _CANDIDATES:
        return None
    near = tree.query_ball_point((a + b) / 2.0, reach, return_sorted=True)
    counts = np.fromiter((len(n) for n in near), dtype=np.int64, count=len(near))
    edge = np.repeat(np.arange(len(start)), counts)
    vertex = rim[np.concatenate([np.asarray(n, dtype=np.int64) for n in near])]
    along = b[edge] - a[edge]
    arm = vertices[vertex] - a[edge]
    squared = np.maximum(length[edge] ** 2, np.finfo(float).tiny)
    share = products(arm, along) / squared
    distance = np.linalg.norm(arm - share[:, None] * along, axis=1)
    # Well between the ends: what lies near an end is a matter for the weld.
    inner = (share * length[edge] > tolerance) & ((1.0 - share) * length[edge] > tolerance)
    keep = inner & (distance <= tolerance) & (vertex != start[edge]) & (vertex != end[edge])
    return edge[keep], vertex[keep], share[keep], distance[keep]
