"""Inner hulls: inside by brute force, and large."""

from __future__ import annotations

import igl
import numpy as np
import pytest
import trimesh
from manifold3d import Manifold

import assetpipe
from assetpipe.decomposition import decompose_with, inner_hulls
from assetpipe.decomposition.inner import InnerHull, united_volume
from assetpipe.errors import CancelledError, MeshError, UsageError
from assetpipe.geometry import Mesh


def solid(body: Manifold) -> Mesh:
    made = body.to_mesh64()
    return Mesh(made.vert_properties[:, :3], made.tri_verts.astype(np.int64))


def box(size, at=(0.0, 0.0, 0.0)) -> Manifold:
    return Manifold.cube(list(size)).translate(list(at))


def crowd(rng: np.random.Generator, count: int) -> Manifold:
    """Boxes, balls and cones at random, some of them taken away."""
    body = Manifold()
    for k in range(count):
        size = rng.uniform(0.1, 0.8, 3)
        piece = [
            Manifold.cube(list(size), True),
            Manifold.sphere(float(size[0]), 16),
            Manifold.cylinder(float(size[0]), float(size[1]), float(0.3 * size[2]), 12),
        ][k % 3]
        piece = piece.rotate(list(rng.uniform(0, 360, 3))).translate(list(rng.uniform(-1, 1, 3)))
        body = body - piece if k % 4 == 3 else body + piece
    return body


def wave() -> Manifold:
    """A wavy sheet a hundredth thick."""
    flat = Manifold.cube([2.0, 1.0, 0.01]).refine(24)
    return flat.warp_batch(
        lambda v: np.column_stack([v[:, :2], v[:, 2] + 0.2 * np.sin(3 * v[:, 0]) * v[:, 1]])
    )


SOLIDS = {
    "ball": lambda: Manifold.sphere(1.0, 64),
    "ell": lambda: box((2, 1, 1)) + box((1, 1, 2)),
    "plate with holes": lambda: (
        box((2, 1, 0.02))
        - Manifold.cylinder(1, 0.2, 0.2, 32).translate([0.5, 0.5, -0.5])
        - Manifold.cylinder(1, 0.1, 0.1, 32).translate([1.5, 0.3, -0.5])
    ),
    "tube": lambda: Manifold.cylinder(2, 1, 1, 64) - Manifold.cylinder(2, 0.95, 0.95, 64),
    "hollow": lambda: Manifold.cube([2, 2, 2], True) - Manifold.sphere(0.9, 48),
    "wave": wave,
    **{f"crowd {k}": lambda k=k: crowd(np.random.default_rng(k), 14) for k in range(4)},
}


def points_in(vertices: np.ndarray, count: int, rng: np.random.Generator) -> np.ndarray:
    """The polytope's corners, and random points of it with as many near its corners as inside."""
    weights = rng.dirichlet(np.full(len(vertices), 0.3), count)
    return np.vstack([vertices, weights @ vertices])


@pytest.mark.parametrize("name", SOLIDS)
def test_no_point_of_an_inner_hull_is_outside(name: str):
    mesh = solid(SOLIDS[name]())
    found = inner_hulls(mesh, 0.01 * mesh.diagonal)
    assert found
    rng = np.random.default_rng(1)
    points = np.vstack([points_in(hull.vertices, 300, rng) for hull in found])
    winding = igl.fast_winding_number(mesh.vertices, mesh.faces, points)
    out = points[np.asarray(winding).ravel() < 0.5]
    if len(out):
        squared = igl.point_mesh_squared_distance(out, mesh.vertices, mesh.faces)[0]
        # On the surface itself the winding number is a matter of rounding.
        assert np.sqrt(np.max(squared)) < 1e-7 * mesh.diagonal


@pytest.mark.parametrize("name", SOLIDS)
def test_little_of_the_solid_is_left_out(name: str):
    mesh = solid(SOLIDS[name]())
    gap = 0.01 * mesh.diagonal
    shapes = [trimesh.Trimesh(h.vertices, h.faces) for h in inner_hulls(mesh, gap)]
    points, _ = trimesh.sample.sample_surface(
        trimesh.Trimesh(mesh.vertices, mesh.faces, process=False), 400, seed=3
    )
    away = np.full(len(points), np.inf)
    for shape in shapes:
        squared = igl.point_mesh_squared_distance(points, shape.vertices, shape.faces)[0]
        away = np.minimum(away, np.sqrt(np.maximum(squared, 0)))
    assert np.mean(away <= 2 * gap) >= 0.97


def test_a_convex_solid_is_its_own_inner_hull():
    mesh = solid(Manifold.cube([1, 2, 3]))
    (hull,) = inner_hulls(mesh, 0.01)
    assert hull.volume == pytest.approx(6.0, rel=1e-6)
    assert len(hull.vertices) == 8


def test_both_arms_of_an_ell_are_found_whole():
    mesh = solid(SOLIDS["ell"]())
    found = inner_hulls(mesh, 0.01)
    assert len(found) == 2
    assert [hull.volume for hull in found] == pytest.approx([2.0, 2.0], rel=1e-5)


def test_the_same_hulls_whatever_the_threads(monkeypatch):
    mesh = solid(SOLIDS["crowd 0"]())
    first, second = inner_hulls(mesh, 0.02), inner_hulls(mesh, 0.02)
    assert [h.vertices.tobytes() for h in first] == [h.vertices.tobytes() for h in second]


def test_d_inner_is_between_nothing_and_the_hulls():
    mesh = solid(SOLIDS["crowd 1"]())
    d = assetpipe.decompose(mesh, "1%")
    assert d.inner is d.inner
    for hull in d.inner:
        middle = hull.vertices.mean(axis=0)
        assert any(
            bool(trimesh.Trimesh(h.vertices, h.faces).contains([middle])[0]) for h in d.hulls
        )
    coarser = d.at(max_hulls=1)
    assert coarser.inner
    assert decompose_with("hull", mesh, "1%").inner


def test_a_budget_is_kept():
    mesh = solid(SOLIDS["crowd 2"]())
    assert len(inner_hulls(mesh, 0.005, most=3)) == 3


def test_what_cannot_be_asked_is_refused():
    mesh = solid(Manifold.cube([1, 1, 1]))
    with pytest.raises(UsageError, match="gap"):
        inner_hulls(mesh, 0.0)
    with pytest.raises(UsageError, match="most"):
        inner_hulls(mesh, 0.1, most=0)
    with pytest.raises(MeshError, match="passed 1 times"):
        inner_hulls(Mesh(mesh.vertices, mesh.faces[1:]), 0.1)
    with pytest.raises(CancelledError):
        inner_hulls(solid(crowd(np.random.default_rng(9), 60)), 1e-4, on_progress=lambda _: False)


def test_what_several_share_is_counted_once():
    far = 1e6  # a part far from its origin loses nothing
    boxes = [
        solid(box((2, 1, 1), (far, 0, 0))),
        solid(box((2, 1, 1), (far + 1, 0, 0))),
        solid(box((1, 1, 1), (far, 0, 5))),
    ]
    hulls = [InnerHull(mesh.vertices, mesh.faces, mesh.volume) for mesh in boxes]
    assert united_volume(hulls) == pytest.approx(4.0, rel=1e-9)
    assert united_volume(hulls[:1]) == pytest.approx(2.0, rel=1e-9)
    assert united_volume([]) == 0.0
