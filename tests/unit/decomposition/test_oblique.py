"""Planes through reflex edges that lie along no axis."""

from __future__ import annotations

import numpy as np
import pytest
from manifold3d import Manifold

import assetpipe
from assetpipe.decomposition import Params

SEARCH = {"policy": "lookahead", "ways": "", "prisms": "search"}


def three_arms() -> tuple[np.ndarray, np.ndarray]:
    """Arms of three heights at 120° to one another: along the axes none can be cut off."""
    body = Manifold()
    for k, height in enumerate((0.3, 0.5, 0.8)):
        arm = Manifold.cube((1.1155, 0.4, height)).translate((-0.1155, -0.2, 0))
        body += arm.rotate((0, 0, 10 + 120 * k))
    mesh = body.to_mesh64()
    vertices = np.asarray(mesh.vert_properties)[:, :3].copy()
    return vertices, np.asarray(mesh.tri_verts).astype(int)


def turned(vertices: np.ndarray) -> np.ndarray:
    q, _ = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))
    return vertices @ (q * np.sign(np.linalg.det(q))).T


def test_arms_that_no_axis_cuts_off_need_fewer_hulls():
    solid = three_arms()
    with_planes = assetpipe.decompose(solid, 0.05, params=Params(SEARCH))
    without = assetpipe.decompose(solid, 0.05, params=Params({**SEARCH, "oblique": 0}))
    assert len(with_planes.hulls) < len(without.hulls)


@pytest.mark.parametrize("precision", [np.float64, np.float32])
def test_nothing_is_lost_at_a_plane_that_rounding_makes_uneven(precision: type):
    vertices, faces = three_arms()
    vertices = turned(vertices).astype(precision).astype(np.float64)
    own_frame = Params({**SEARCH, "frame": "mesh"})
    found = assetpipe.decompose((vertices, faces), 0.05, params=own_frame)
    assert found.certificate.upper <= 0.05
    # Corners and points of the surface, each in a hull.
    corners = vertices[faces]
    weights = np.random.default_rng(0).dirichlet((1, 1, 1), size=40)
    points = np.concatenate([vertices, np.einsum("sk,tkd->std", weights, corners).reshape(-1, 3)])
    outside = np.full(len(points), np.inf)
    for hull in found.hulls:
        a, b, c = (np.asarray(hull.vertices)[np.asarray(hull.faces)[:, i]] for i in range(3))
        normals = np.cross(b - a, c - a)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        heights = points @ normals.T - np.einsum("fd,fd->f", normals, a)
        outside = np.minimum(outside, heights.max(axis=1))
    assert outside.max() < 1e-12
