"""Extruded outlines: decomposed in the plane where that gives fewer hulls."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from manifold3d import CrossSection, Manifold

import assetpipe
from assetpipe.decomposition import Decomposition, Params, certify
from assetpipe.geometry import Mesh


def bracket() -> CrossSection:
    """Five arms of different length around a hub with a hole."""
    shape = CrossSection.circle(0.3, 32)
    for k in range(5):
        arm = CrossSection.square([1 + 0.2 * k, 0.24]).translate([0, -0.12])
        shape += arm.rotate(79.0 * k)
    return shape - CrossSection.circle(0.15, 32)


def comb() -> CrossSection:
    shape = CrossSection.square([15, 0.3]).translate([0, -0.3])
    for k in range(15):
        shape += CrossSection([[(k, 0), (k + 0.6, 0), (k + 0.7, 1.5), (k + 0.3, 1.5)]])
    return shape


def mesh_of(body: Manifold) -> Mesh:
    made = body.to_mesh64()
    return Mesh(made.vert_properties[:, :3], made.tri_verts.astype(np.int64))


def decomposed(mesh: Mesh, prisms: str) -> Decomposition:
    return assetpipe.decompose(mesh, "1%", params=Params({"prisms": prisms}))


@pytest.mark.parametrize("outline", [bracket, comb])
@pytest.mark.parametrize("turn", [(0, 0, 0), (31, 47, 11)])
def test_the_plane_is_used_where_it_gives_fewer_hulls(outline, turn):
    mesh = mesh_of(outline().extrude(0.4).rotate([float(a) for a in turn]))
    search, plane = decomposed(mesh, "search"), decomposed(mesh, "plane")
    assert len(plane.hulls) <= len(search.hulls)
    if outline is bracket and not any(turn):  # of the comb the search finds the fewest too
        assert len(plane.hulls) < len(search.hulls)
    assert plane.certificate.upper <= plane.epsilon
    # Bounds and cover as anybody else finds them.
    assert all(b.lower <= plane.epsilon for b in certify(mesh, [h.vertices for h in plane.hulls]))
    points, _ = trimesh.sample.sample_surface(
        trimesh.Trimesh(mesh.vertices, mesh.faces, process=False), 3000, seed=1
    )
    outside = np.full(len(points), np.inf)
    for hull in plane.hulls:
        a, b, c = (hull.vertices[hull.faces[:, k]] for k in range(3))
        normals = np.cross(b - a, c - a)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        height = points @ normals.T - np.einsum("ij,ij->i", normals, a)
        outside = np.minimum(outside, height.max(axis=1))
    assert outside.max() <= 1e-9 * mesh.diagonal


def test_a_solid_that_is_no_prism_is_left_to_the_search():
    body = bracket().extrude(0.4) + Manifold.cube([0.2, 0.2, 1.0])
    search, plane = (decomposed(mesh_of(body), prisms) for prisms in ("search", "plane"))
    assert [h.vertices.tobytes() for h in search.hulls] == [
        h.vertices.tobytes() for h in plane.hulls
    ]


def test_the_same_bytes_whatever_the_threads():
    mesh = mesh_of(bracket().extrude(0.4))
    one, many = (assetpipe.decompose(mesh, "1%", threads=k) for k in (1, 3))
    assert [h.vertices.tobytes() for h in one.hulls] == [h.vertices.tobytes() for h in many.hulls]
