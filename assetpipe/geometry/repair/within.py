"""Triangles that are inside a solid as soon as one point of each is.

A triangle that reaches from inside a solid to outside leaves it through a face, or over a
convex edge that lies in the triangle's own plane. One that meets neither is inside, outside
or on the surface as a whole, but for parts that lie on faces of the solid.
"""

from __future__ import annotations

import numpy as np

from assetpipe.geometry.health.crossings import crossing_faces, overlapping_boxes
from assetpipe.geometry.health.topology import BoolArray, Edges, face_areas
from assetpipe.geometry.mesh import FloatArray, IntArray
from assetpipe.geometry.products import products
from assetpipe.geometry.repair.surface import Corners

_ON = 1e-9
"""Units within which an edge lies in a plane, and inside of a triangle's border."""
_FLAT = 1e-12
"""Units of height below which an edge is flat."""
_PAIRS = 12_000_000


def whole(corners: Corners, vertices: FloatArray, faces: IntArray) -> BoolArray:
    """(n,) which triangles a solid's surface does not divide.

    Args:
        corners: (n, 3, 3) triangles, units.
        vertices: (k, 3) of the solid.
        faces: (m, 3), closed.
    """
    result = np.ones(len(corners), dtype=bool)
    if not len(corners):
        return result
    result[_pierced(corners, vertices, faces)] = False
    result[_left_over_edges(corners, vertices, faces)] = False
    return result


def _pierced(corners: Corners, vertices: FloatArray, faces: IntArray) -> IntArray | slice:
    """Triangles that cross a face; all, if there are too many to tell."""
    own = np.arange(3 * len(corners)).reshape(-1, 3)
    points = np.concatenate([vertices, corners.reshape(-1, 3)])
    joined = np.concatenate([faces, len(vertices) + own])
    pairs = crossing_faces(points, joined, second=len(faces))
    if pairs is None:
        return slice(None)
    found: IntArray = pairs[:, 1] - len(faces)
    return found


def _left_over_edges(corners: Corners, vertices: FloatArray, faces: IntArray) -> IntArray | slice:
    """Triangles in whose plane, and inside of whose border, a convex edge lies."""
    ends = vertices[_convex(vertices, faces)]
    low = np.concatenate([corners.min(axis=1), ends.min(axis=1) - _ON])
    high = np.concatenate([corners.max(axis=1), ends.max(axis=1) + _ON])
    pairs = overlapping_boxes(low, high, _PAIRS, len(corners))
    if pairs is None:
        return slice(None)
    pairs = np.sort(pairs, axis=1)
    which, (a, b, c) = pairs[:, 0], corners[pairs[:, 0]].transpose(1, 0, 2)
    start, end = ends[pairs[:, 1] - len(corners)].transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.sqrt(products(normal, normal)), np.finfo(float).tiny)[:, None]
    flat = np.ones(len(which), dtype=bool)
    for p in (start, end):
        flat &= np.abs(products(p - a, normal)) <= _ON
    enters, leaves = np.zeros(len(which)), np.ones(len(which))
    for p, q in ((a, b), (b, c), (c, a)):
        inward = np.cross(normal, q - p)
        inward /= np.maximum(np.sqrt(products(inward, inward)), np.finfo(float).tiny)[:, None]
        first, second = products(start - p, inward) - _ON, products(end - p, inward) - _ON
        change = second - first
        with np.errstate(divide="ignore", invalid="ignore"):
            share = -first / change
        enters = np.where(change > 0.0, np.maximum(enters, share), enters)
        leaves = np.where(change < 0.0, np.minimum(leaves, share), leaves)
        flat &= (change != 0.0) | (first > 0.0)
    found: IntArray = which[flat & (leaves > enters)]
    return found


def _convex(vertices: FloatArray, faces: IntArray) -> IntArray:
    """(e, 2) ends of the edges at which a solid is convex, and of those of several sheets."""
    edges = Edges.of(faces, len(vertices))
    first, second = edges.pair(edges.regular)
    _, normals = face_areas(vertices, faces)
    size = np.maximum(np.sqrt(products(normals, normals)), np.finfo(float).tiny)
    face = first // 3
    height = (
        products(vertices[edges.apex(second)] - vertices[faces[face, 0]], normals[face])
        / size[face]
    )
    chosen = edges.regular[height < -_FLAT]
    found: IntArray = edges.ends[np.concatenate([chosen, edges.nonmanifold])]
    return found
