import json
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh

from assetpipe.errors import MeshError, UsageError
from assetpipe.geometry.mesh import Mesh
from assetpipe.validation.contact import contact_truth


def shape(mesh):
    return SimpleNamespace(
        vertices=np.asarray(mesh.vertices, dtype=float),
        faces=np.asarray(mesh.faces, dtype=np.int64),
    )


def block(size, at=(0.0, 0.0, 0.0)):
    return trimesh.creation.box(size).apply_translation(at)


def channel(scale=1.0):
    """A U profile: two walls on a plate, open between; its three exact convex parts."""
    parts = [
        block((0.3, 0.2, 0.02)),
        block((0.02, 0.2, 0.1), (-0.14, 0, 0.06)),
        block((0.02, 0.2, 0.1), (0.14, 0, 0.06)),
    ]
    profile = [(-15, -1), (15, -1), (15, 11), (13, 11), (13, 1), (-13, 1), (-13, 11), (-15, 11)]
    solid = _extruded(np.array(profile) * 0.01, 0.2)
    for mesh in (solid, *parts):
        mesh.apply_scale(scale)
    return Mesh.of(solid), [shape(p) for p in parts]


def _extruded(outline, depth):
    n = len(outline)
    low = np.column_stack([outline[:, 0], np.full(n, -depth / 2), outline[:, 1]])
    high = low + np.array([0, depth, 0])
    # outline is counter-clockwise seen from -y
    cap = np.array([[0, 1, 4], [0, 4, 5], [1, 2, 3], [1, 3, 4], [0, 5, 6], [0, 6, 7]])
    sides = [[[i, (i + 1) % n, (i + 1) % n + n], [i, (i + 1) % n + n, i + n]] for i in range(n)]
    faces = np.vstack([cap, cap[:, ::-1] + n, np.vstack(sides)[:, ::-1]])
    mesh = trimesh.Trimesh(np.vstack([low, high]), faces, process=False)
    assert mesh.is_watertight
    if mesh.volume < 0:
        mesh.invert()
    return mesh


def test_exact_parts_have_no_error():
    solid, parts = channel()
    truth = contact_truth(solid, parts, 0.0, samples=400, seed=1)
    assert truth.holds
    assert truth.false_contacts.count == 0
    assert truth.clearance_error.worst == pytest.approx(0.0, abs=1e-9)
    assert truth.findings() == ()
    assert truth.false_contacts.of > 100
    assert truth.missed_contacts.of > 40


def test_one_hull_over_the_channel_is_caught_by_false_contacts():
    solid, _ = channel()
    hull = shape(solid.to_trimesh().convex_hull)
    truth = contact_truth(solid, [hull], 0.1, samples=600, seed=1)
    assert truth.false_contacts.count > 50
    assert truth.false_contacts.low > 0.05
    assert truth.missed_contacts.count == 0
    assert truth.holds
    # the deepest point of the mouth is 0.1 m from the plate and 0.13 m from the walls
    assert 0.03 < truth.clearance_error.greatest <= 0.1


def test_a_certificate_that_is_too_small_is_caught():
    solid, _ = channel()
    hull = shape(solid.to_trimesh().convex_hull)
    truth = contact_truth(solid, [hull], 0.01, samples=400, seed=1)
    assert truth.beyond.count > 0
    assert not truth.holds
    assert [f.code for f in truth.findings("link")] == ["AP401"]
    assert truth.worst is not None
    assert truth.worst.solid_clearance - truth.worst.hull_clearance > 0.01


def test_a_hole_in_the_cover_is_caught():
    solid, parts = channel()
    truth = contact_truth(solid, parts[:2], 0.0, samples=600, seed=1)
    codes = {f.code for f in truth.findings("link")}
    assert {"AP404", "AP405"} <= codes
    assert truth.coverage.surface.low > 0.1
    assert truth.coverage.gap == pytest.approx(0.1, rel=0.05)
    assert truth.missed is not None


def test_shrunk_hulls_are_caught_even_by_little():
    solid, parts = channel()
    shrunk = [
        SimpleNamespace(
            vertices=p.vertices.mean(0) + (p.vertices - p.vertices.mean(0)) * 0.9999, faces=p.faces
        )
        for p in parts
    ]
    truth = contact_truth(solid, shrunk, 0.0, samples=200, seed=1)
    assert not truth.coverage.complete


def test_what_repair_moved_is_allowed_for():
    solid, parts = channel()
    moved = [
        SimpleNamespace(vertices=p.vertices + np.array([0, 0, 1e-4]), faces=p.faces) for p in parts
    ]
    assert not contact_truth(solid, moved, 0.0, samples=400, seed=1).holds
    assert contact_truth(solid, moved, 0.0, samples=400, seed=1, moved=1.01e-4).holds


@pytest.mark.parametrize("scale", [1e-3, 10.0])
def test_counts_do_not_depend_on_the_unit(scale):
    counts = []
    for factor in (1.0, scale):
        solid, _ = channel(factor)
        hull = shape(solid.to_trimesh().convex_hull)
        truth = contact_truth(solid, [hull], 0.02 * factor, samples=200, seed=4)
        counts.append((truth.false_contacts.count, truth.missed_contacts.of, truth.beyond.count))
    assert abs(counts[0][0] - counts[1][0]) <= 1
    assert counts[0][1:] == pytest.approx(counts[1][1:], abs=1)


def test_same_seed_same_result_and_other_seed_other_poses():
    solid, _ = channel()
    hull = [shape(solid.to_trimesh().convex_hull)]
    first, again, other = (
        contact_truth(solid, hull, 0.05, samples=120, seed=s).as_dict() for s in (3, 3, 4)
    )
    assert first == again
    assert first["clearance_error"] != other["clearance_error"]
    assert json.loads(json.dumps(first)) == first


def test_probes_wholly_inside_count_as_contact():
    solid = Mesh.of(block((1.0, 1.0, 1.0)))
    truth = contact_truth(solid, [shape(block((1.0, 1.0, 1.0)))], 0.0, samples=300, seed=0)
    # the deepest stratum holds spheres that are wholly under the surface
    assert truth.missed_contacts.of > 0
    assert truth.missed_contacts.count == 0
    assert truth.holds


def test_every_stratum_and_probe_is_visited():
    solid, parts = channel()
    truth = contact_truth(solid, parts, 0.002, samples=300, seed=0)
    assert {p.kind for p in truth.probes} == {"sphere", "box", "finger"}
    assert all(p.tested == 50 for p in truth.probes)
    assert sum(p.tested for p in truth.probes) == truth.samples


def test_wrong_calls():
    solid, parts = channel()
    with pytest.raises(UsageError, match="negative"):
        contact_truth(solid, parts, -1.0)
    with pytest.raises(UsageError, match="at least 1"):
        contact_truth(solid, parts, 0.0, samples=0)
    with pytest.raises(MeshError, match="no hulls"):
        contact_truth(solid, [], 0.0)


def test_depth_is_asked_of_hulls_alone_so_an_open_solid_does_not_spoil_it():
    # FCL's depth between meshes, and of anything with an open one, means nothing.
    solid, _ = channel()
    hull = shape(solid.to_trimesh().convex_hull)
    opened = Mesh(solid.vertices, solid.faces[2:])
    for tested in (solid, opened):
        truth = contact_truth(tested, [hull], 0.1, samples=400, seed=1)
        assert truth.false_depth.samples == truth.false_contacts.count
        # An upper estimate, but never more than hull and probe together are long.
        assert truth.false_depth.least > 0.0
        assert truth.false_depth.greatest < 0.38 + 0.06
