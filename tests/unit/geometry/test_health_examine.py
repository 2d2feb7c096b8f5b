"""Every defect is counted, and located where it is."""

import numpy as np
import pytest
import trimesh

from assetpipe.geometry import Mesh, Soundness, examine


def box() -> tuple[np.ndarray, np.ndarray]:
    mesh = trimesh.creation.box()
    return np.asarray(mesh.vertices), np.asarray(mesh.faces)


def test_a_box_is_a_solid_and_convex():
    health = examine(Mesh(*box()), crossings="count")
    assert health.soundness is Soundness.SOLID
    assert health.solid
    assert health.closed
    assert health.components == 1
    assert health.volume == pytest.approx(1.0, rel=1e-12)
    assert health.convex_within == pytest.approx(0.0, abs=1e-8)
    assert health.extents == (1.0, 1.0, 1.0)
    assert health.self_intersections is not None
    assert health.self_intersections.count == 0


def test_a_soup_needs_a_weld():
    vertices, faces = box()
    health = examine(Mesh(vertices[faces].reshape(-1, 3), np.arange(36).reshape(-1, 3)))
    assert health.soundness is Soundness.NEEDS_WELD
    assert health.duplicate_vertices == 28
    assert health.closed


def test_negative_zero_is_zero():
    health = examine(
        Mesh([[0.0, 0, 0], [-0.0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 2, 3], [1, 3, 2]])
    )
    assert health.duplicate_vertices == 1


def test_an_opening_is_located_and_measured():
    vertices, faces = box()
    top = vertices[faces].mean(axis=1)[:, 2] > 0.49
    health = examine(Mesh(vertices, faces[~top]))
    assert health.soundness is Soundness.OPEN
    assert health.boundary_edges.count == 4
    assert health.openings.count == 1
    assert health.openings.at[0] == pytest.approx((0.0, 0.0, 0.5))
    assert health.widest_opening == pytest.approx(np.sqrt(2))
    assert health.volume is None


def test_a_turned_face_is_inconsistent():
    vertices, faces = box()
    health = examine(Mesh(vertices, np.vstack([faces[:1, ::-1], faces[1:]])))
    assert health.soundness is Soundness.INCONSISTENT
    assert health.inconsistent_edges.count == 3


def test_an_inverted_box_is_inside_out():
    vertices, faces = box()
    health = examine(Mesh(vertices, faces[:, ::-1]))
    assert health.soundness is Soundness.INSIDE_OUT
    assert health.inverted_components == 1
    assert health.volume == pytest.approx(-1.0)


def test_a_cavity_is_no_inverted_component():
    vertices, faces = box()
    health = examine(
        Mesh(
            np.vstack([vertices, vertices / 2]), np.vstack([faces, faces[:, ::-1] + len(vertices)])
        )
    )
    assert (health.inverted_components, health.cavities, health.components) == (0, 1, 2)


def test_boxes_on_an_edge_are_non_manifold():
    vertices, faces = box()
    both = np.vstack([vertices, vertices + np.array([1, 1, 0])])
    health = examine(Mesh(both, np.vstack([faces, faces + len(vertices)])))
    assert health.soundness is Soundness.NON_MANIFOLD
    assert health.nonmanifold_edges.count == 1
    assert health.nonmanifold_edges.at == ((0.5, 0.5, 0.0),)


def test_boxes_on_a_corner_join_umbrellas():
    vertices, faces = box()
    both = np.vstack([vertices, vertices + np.array([1, 1, 1])])
    health = examine(Mesh(both, np.vstack([faces, faces + len(vertices)])))
    assert health.nonmanifold_edges.count == 0
    assert health.nonmanifold_vertices.at == ((0.5, 0.5, 0.5),)


def test_degenerate_duplicate_and_thin_faces_are_counted():
    vertices, faces = box()
    points = np.vstack([vertices, [[0.5, 0.0, 0.5], [5, 0, 0], [6, 0, 0], [5.5, 1e-5, 0]]])
    extra = [[0, 0, 1], faces[0], [8, 9, 9], [9, 10, 11]]
    health = examine(Mesh(points, np.vstack([faces, extra])))
    assert health.degenerate_faces == 2
    assert health.duplicate_faces.count == 1
    assert health.sliver_faces.count == 1
    assert health.zero_area_faces.count == 0


def test_a_face_on_a_line_has_no_area():
    health = examine(Mesh([[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0]], [[0, 1, 2], [0, 1, 3]]))
    assert health.zero_area_faces.count == 1
    assert health.soundness is Soundness.FLAT


def test_crossing_boxes_intersect_and_neighbours_do_not():
    vertices, faces = box()
    both = np.vstack([vertices, vertices + np.array([0.5, 0.25, 0.125])])
    mesh = Mesh(both, np.vstack([faces, faces + len(vertices)]))
    health = examine(mesh, crossings="count")
    assert health.self_intersections is not None
    assert health.self_intersections.count > 0
    sphere = trimesh.creation.icosphere(subdivisions=3)
    clean = examine(Mesh.of(sphere), crossings="count")
    assert clean.self_intersections is not None
    assert clean.self_intersections.count == 0


def pierces(start, end, triangle) -> bool:
    """Whether a segment meets a triangle, by its share of the way and barycentric weights."""
    a, b, c = triangle
    matrix = np.stack([start - end, b - a, c - a], axis=1)
    way, v, w = np.linalg.solve(matrix, start - a)
    return 0 < way < 1 and v > 0 and w > 0 and v + w < 1


@pytest.mark.parametrize("second", [None, 25])
def test_crossings_agree_with_a_test_of_all_pairs(second):
    from assetpipe.geometry.health.crossings import crossing_faces

    random = np.random.default_rng(1)
    corners = 0.7 * random.random((60, 1, 3)) + 0.5 * random.random((60, 3, 3))
    vertices, faces = corners.reshape(-1, 3), np.arange(180).reshape(-1, 3)
    found = crossing_faces(vertices, faces, second=second)
    assert found is not None
    truth = [
        [i, k]
        for i in range(60)
        for k in range(i + 1, 60)
        if second is None or i < second <= k
        if any(
            pierces(t[m - 1], t[m], u)
            for t, u in ((corners[i], corners[k]), (corners[k], corners[i]))
            for m in range(3)
        )
    ]
    assert len(truth) > 5
    np.testing.assert_array_equal(found, truth)


def test_too_crowded_is_said():
    from assetpipe.geometry.health.crossings import crossing_faces

    faces = np.arange(300).reshape(-1, 3)
    vertices = np.random.default_rng(2).random((300, 3))
    assert crossing_faces(vertices, faces, pairs=100) is None


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e3])
@pytest.mark.parametrize("far", [0.0, 1e4])
def test_scale_and_place_do_not_matter(scale, far):
    mesh = trimesh.creation.torus(1.0, 0.3)
    vertices = (np.asarray(mesh.vertices) + far) * scale
    health = examine(Mesh(vertices, mesh.faces), crossings="count")
    assert health.soundness is Soundness.SOLID
    assert health.convex_within == pytest.approx(examine(Mesh.of(mesh)).convex_within, abs=1e-3)


def test_as_dict_is_plain_data():
    import json

    text = json.dumps(examine(Mesh(*box())).as_dict(), allow_nan=False)
    assert json.loads(text)["soundness"] == "solid"


def test_no_faces_is_empty():
    health = examine(Mesh(np.zeros((0, 3)), np.zeros((0, 3), dtype=int)))
    assert health.soundness is Soundness.EMPTY
    assert examine(Mesh([[0, 0, 0]], [[0, 0, 0]])).soundness is Soundness.EMPTY
