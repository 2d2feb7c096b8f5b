"""Every trap of the collision library that would make a wrong verdict."""

import time
from itertools import pairwise

import fcl
import numpy as np
import pytest
import trimesh

from assetpipe.errors import MeshError
from assetpipe.validation.contact.probes import Probe
from assetpipe.validation.contact.surface import (
    UNITS,
    Frame,
    Surface,
    bvh_geometry,
    convex_geometry,
    facet_planes,
    outside_hulls,
)


def surface(mesh):
    vertices = np.asarray(mesh.vertices, dtype=float)
    return Surface(vertices, np.asarray(mesh.faces, dtype=np.int64), Frame.around(vertices))


def placed(probe, frame, position, rotation=None):
    rotation = np.eye(3) if rotation is None else rotation
    transform = fcl.Transform(rotation, frame.points(np.asarray(position, dtype=float)))
    return fcl.CollisionObject(probe.geometry(frame), transform)


@pytest.mark.parametrize("scale", [1e-4, 1.0, 1e3])
def test_separation_of_aligned_boxes_is_exact_at_any_scale(scale):
    # GJK answers are up to 15% too large here, whatever its solver.
    rng = np.random.default_rng(3)
    for _ in range(150):
        edges = rng.choice([0.1, 0.2, 1.0, 0.05, 0.002], 3) * scale
        edge = float(rng.choice([0.1, 0.3])) * scale
        position = np.round(rng.uniform(-0.9, 0.9, 3), 1) * scale
        apart = np.abs(position) - (edges + edge) / 2.0
        true = float(np.linalg.norm(np.maximum(apart, 0.0)))
        if true <= 1e-6 * scale:
            continue
        body = surface(trimesh.creation.box(edges))
        probe = placed(Probe.box(edge), body.frame, position)
        assert not body.crosses(probe)
        assert body.gap(probe) == pytest.approx(true, abs=1e-8 * scale)


def test_gjk_would_have_been_wrong_on_a_millimetre_shape():
    # Characterisation: once this fails, FCL has become better and Surface can be simpler.
    box = trimesh.creation.box((1e-3, 1e-3, 1e-3))
    convex = fcl.CollisionObject(convex_geometry(box.vertices, box.faces))
    centre = np.array([0.9e-3, 0.8e-3, 0.75e-3])
    ball = fcl.CollisionObject(fcl.Sphere(1e-4), fcl.Transform(np.eye(3), centre))
    told = fcl.distance(convex, ball, fcl.DistanceRequest(), fcl.DistanceResult())
    true = float(np.linalg.norm(centre - 0.5e-3)) - 1e-4
    body = surface(box)
    probe = placed(Probe.sphere(1e-4), body.frame, centre)
    assert body.gap(probe) == pytest.approx(true, rel=1e-9)
    assert abs(told - true) > 1e-3 * true


def test_a_mesh_is_a_surface_so_inside_needs_its_own_test():
    body = surface(trimesh.creation.box((1.0, 1.0, 1.0)))
    probe = placed(Probe.sphere(0.05), body.frame, (0.0, 0.0, 0.0))
    assert not body.crosses(probe)
    assert body.gap(probe) > 0.0
    assert body.winding(np.zeros((1, 3)))[0] == pytest.approx(1.0, abs=1e-6)
    assert body.winding(np.full((1, 3), 0.6))[0] == pytest.approx(0.0, abs=1e-2)


def test_contact_reads_as_zero_separation_for_every_probe():
    # FCL says -1 for boxes and a denormal number for spheres.
    body = surface(trimesh.creation.box((1.0, 1.0, 1.0)))
    for probe in (Probe.sphere(0.1), Probe.box(0.1), Probe.finger(0.2)):
        item = placed(probe, body.frame, (0.5, 0.013, 0.017))
        assert body.crosses(item)
        assert body.gap(item) <= 1e-12


def test_kissing_contact_lies_in_the_dead_band():
    body = surface(trimesh.creation.box((1.0, 1.0, 1.0)))
    for offset in (-1e-12, 0.0, 1e-12):
        probe = placed(Probe.box(0.2), body.frame, (0.6 + offset, 0.013, 0.017))
        assert body.gap(probe) < 1e-9


def test_tiny_box_against_a_huge_geometry_ends():
    ground = surface(trimesh.creation.box((1e4, 1e4, 1.0)))
    start = time.process_time()
    for height in (0.5005, 0.50051, 0.6, 3.0):
        probe = placed(Probe.box(1e-3), ground.frame, (123.4, -77.7, height))
        expected = height - 0.5005
        assert ground.gap(probe) == pytest.approx(expected, abs=1e-6)
    assert time.process_time() - start < 2.0


def test_convex_faces_are_checked_before_fcl_reads_past_them():
    box = trimesh.creation.box((1.0, 1.0, 1.0))
    flat = np.hstack([np.full((12, 1), 3), box.faces]).ravel()
    with pytest.raises(MeshError, match=r"shape \(f, 3\)"):
        convex_geometry(box.vertices, flat)
    with pytest.raises(MeshError, match="does not exist"):
        convex_geometry(box.vertices, np.array([[0, 1, 8]]))
    with pytest.raises(MeshError, match="without faces"):
        bvh_geometry(np.asarray(box.vertices), np.zeros((0, 3), dtype=np.int64))


def test_penetration_depth_of_convex_shapes_whatever_its_sign():
    box = trimesh.creation.box((1.0, 1.0, 1.0))
    hull = fcl.CollisionObject(convex_geometry(box.vertices * UNITS, box.faces))
    for solver in (fcl.GJKSolverType.GST_LIBCCD, fcl.GJKSolverType.GST_INDEP):
        ball = fcl.CollisionObject(
            fcl.Sphere(0.1 * UNITS), fcl.Transform(np.eye(3), np.array([0.55, 0.01, 0.02]) * UNITS)
        )
        request = fcl.CollisionRequest(enable_contact=True, gjk_solver_type=solver)
        result = fcl.CollisionResult()
        fcl.collide(hull, ball, request, result)
        assert abs(result.contacts[0].penetration_depth) / UNITS == pytest.approx(0.05, abs=1e-6)


def test_facet_planes_hold_every_vertex_even_with_slivers():
    rng = np.random.default_rng(5)
    points = rng.normal(size=(60, 3)) * (1.0, 1.0, 1e-5) + 1e3
    hull = trimesh.convex.convex_hull(points)
    normals, offsets = facet_planes(hull)
    assert (np.asarray(hull.vertices) @ normals.T - offsets).max() < 1e-9
    assert outside_hulls(points, [hull]).max() < 1e-9


def test_inside_and_outside_of_several_hulls():
    left = trimesh.creation.box((1.0, 1.0, 1.0))
    right = left.copy().apply_translation((3.0, 0.0, 0.0))
    excess = outside_hulls(np.array([[0.0, 0, 0], [3.0, 0, 0], [1.5, 0, 0]]), [left, right])
    assert (excess[:2] < 0).all()
    assert excess[2] == pytest.approx(1.0)


def test_standing_far_from_the_origin_changes_nothing():
    gaps = []
    for shift in (0.0, 1e4):
        body = surface(trimesh.creation.torus(0.4, 0.1).apply_translation((shift, 0, 0)))
        probe = placed(Probe.finger(0.1), body.frame, (shift + 0.7, 0.1, 0.05))
        gaps.append(body.gap(probe))
    assert all(b == pytest.approx(a, abs=1e-9) for a, b in pairwise(gaps))
