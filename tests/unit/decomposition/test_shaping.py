"""Simple shapes in the place of hulls, and seams that overlap."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

import assetpipe
from assetpipe.decomposition import Decomposition
from assetpipe.decomposition.primitives import KINDS, Primitive, enclosing
from assetpipe.errors import UsageError
from assetpipe.geometry.mesh import Mesh


def turned(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    mesh.apply_transform(trimesh.transformations.rotation_matrix(0.7, [1.0, 2.0, 3.0], [0.1, 0, 0]))
    return mesh


def heights(points, mesh) -> np.ndarray:
    """Largest distance beyond a face's plane; at most 0 inside."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return (points @ normals.T - np.einsum("ij,ij->i", normals, a)).max(axis=1)


def surface_of(shape: Primitive, count: int = 4000) -> np.ndarray:
    """Points of a shape's surface, by its definition."""
    rng = np.random.default_rng(0)
    local = rng.normal(size=(count, 3))
    unit = local / np.linalg.norm(local, axis=1, keepdims=True)
    if shape.kind == "box":
        found = unit / np.abs(unit).max(axis=1, keepdims=True) * 0.5 * np.array(shape.size)
    elif shape.kind == "sphere":
        found = unit * shape.size[0]
    else:
        radius, length = shape.size
        if shape.kind == "cylinder":
            ring = unit[:, :2] / np.linalg.norm(unit[:, :2], axis=1, keepdims=True) * radius
            found = np.column_stack([ring, rng.uniform(-0.5, 0.5, count) * length])
            found[: count // 2, 2] = np.sign(found[: count // 2, 2]) * 0.5 * length
        else:
            found = unit * radius + np.array([0, 0, 0.5 * length]) * np.sign(unit[:, 2:])
    return found @ shape.frame[:3, :3].T + shape.frame[:3, 3]


SHAPES = {
    "box": lambda: trimesh.creation.box((0.1, 0.05, 0.02)),
    "cylinder": lambda: trimesh.creation.cylinder(0.02, 0.1, sections=40),
    "capsule": lambda: trimesh.creation.capsule(0.08, 0.02, count=[24, 24]),
    "sphere": lambda: trimesh.creation.icosphere(3, 0.03),
}


@pytest.mark.parametrize("kind", KINDS)
def test_a_shape_is_found_for_what_it_is(kind):
    mesh = turned(SHAPES[kind]())
    found = assetpipe.decompose(mesh, 0.0008, shapes="primitives_and_capsules")
    (hull,) = found.hulls
    assert hull.primitive is not None
    assert hull.primitive.kind == kind
    assert hull.certificate.upper <= 0.0008
    assert hull.primitive.depth(np.asarray(mesh.vertices)).min() > 0.0
    assert found.as_dict()["hulls"][0]["primitive"]["kind"] == kind


@pytest.mark.parametrize("kind", KINDS)
def test_the_polytope_is_around_the_shape(kind):
    mesh = turned(SHAPES[kind]())
    for shape in enclosing(Mesh.of(mesh)):
        around = shape.polytope()
        size = float(np.ptp(around.vertices, axis=0).max())
        assert heights(surface_of(shape), around).max() <= 1e-9 * size
        assert shape.depth(surface_of(shape)).max() <= 1e-9 * size
        assert shape.volume <= around.volume * (1 + 1e-9) <= 1.05 * shape.volume


def test_smallest_first():
    volumes = [shape.volume for shape in enclosing(Mesh.of(SHAPES["cylinder"]()))]
    assert len(volumes) == 4
    assert volumes == sorted(volumes)


def test_capsules_only_where_they_are_asked_for():
    mesh = turned(SHAPES["capsule"]())
    found = assetpipe.decompose(mesh, 0.0008, shapes="primitives")
    assert all(h.primitive is None or h.primitive.kind != "capsule" for h in found.hulls)


def test_a_shape_that_reaches_too_far_is_not_taken():
    wedge = trimesh.convex.convex_hull(
        np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]], dtype=float)
    )
    found = assetpipe.decompose(wedge, 0.002, shapes="primitives_and_capsules")
    assert [hull.primitive for hull in found.hulls] == [None]


def bars() -> Mesh:
    """An L of two bars."""
    import manifold3d

    solid = manifold3d.Manifold.cube([0.1, 0.02, 0.02]) + manifold3d.Manifold.cube(
        [0.02, 0.1, 0.02]
    )
    made = solid.to_mesh64()
    return Mesh(np.array(made.vert_properties)[:, :3], np.array(made.tri_verts).astype(np.int64))


def test_coarser_levels_and_files_know_shapes(tmp_path):
    found = assetpipe.decompose(bars(), 0.001, shapes="primitives")
    assert [h.primitive.kind for h in found.hulls if h.primitive] == ["box", "box"]
    found.save(tmp_path / "bars.apd")
    read = Decomposition.load(tmp_path / "bars.apd")
    assert [h.as_dict() for h in read.hulls] == [h.as_dict() for h in found.hulls]
    assert np.array_equal(read.hulls[0].primitive.frame, found.hulls[0].primitive.frame)
    assert [h.primitive for h in found.at(max_hulls=1).hulls] == [None]


def test_neighbours_overlap_by_what_was_asked_and_stay_within():
    overlap = 0.0015
    plain = assetpipe.decompose(bars(), 0.002)
    found = assetpipe.decompose(bars(), 0.002, overlap=overlap)
    assert len(plain.hulls) == len(found.hulls) == 2
    assert found.seams.as_dict() == {"overlap": overlap, "widened": 1, "open": 0}
    assert found.certificate.upper <= 0.002
    # Every old hull is in its successor; what they share is as thick as was asked.
    for old, new in zip(plain.hulls, found.hulls, strict=True):
        assert heights(old.vertices, new).max() <= 1e-12
    (grown,) = (i for i in range(2) if found.hulls[i].volume > plain.hulls[i].volume * 1.0001)
    reach = heights(found.hulls[grown].vertices, plain.hulls[grown]).max()
    assert reach == pytest.approx(overlap, rel=0.3)
    assert found.at(max_hulls=1).seams is None


def test_an_overlap_that_the_proof_forbids_leaves_the_seam_open():
    # A thin plate on a bar: the slab's corners would bulge by more than the tolerance.
    found = assetpipe.decompose(bars(), 1e-5, overlap=0.01)
    assert found.certificate.upper <= 1e-5
    assert found.seams.open == 1
    assert found.seams.widened == 0


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"shapes": "boxes"}, "primitives"),
        ({"overlap": -1.0}, "overlap"),
        ({"overlap": float("nan")}, "overlap"),
        ({"shapes": "primitives", "metric": "concavity"}, "thickening"),
        ({"overlap": 0.001, "metric": "concavity"}, "thickening"),
    ],
)
def test_what_cannot_be_done_is_refused(options, said):
    with pytest.raises(UsageError, match=said):
        assetpipe.decompose(bars(), 0.001, **options)
