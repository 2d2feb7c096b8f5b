"""What repair says of how far it moved the surface, where pieces are united or dropped."""

import igl
import numpy as np
import pytest
import trimesh
from jobs import job_on

from assetpipe.geometry import Mesh, RepairPolicy, repair
from assetpipe.geometry.repair.deadline import NEVER
from assetpipe.geometry.repair.measured import moved_by_union, strays
from assetpipe.geometry.repair.stitch import weld_boundary
from assetpipe.geometry.repair.unite import Shell, unite
from assetpipe.geometry.repair.within import whole

NARROW = RepairPolicy(budget=1e-3)


def box(size=(1.0, 1.0, 1.0), at=(0.0, 0.0, 0.0), wound="outward"):
    made = trimesh.creation.box(size).apply_translation(at)
    faces = np.asarray(made.faces)
    return np.asarray(made.vertices), faces if wound == "outward" else faces[:, ::-1]


def joined(*parts):
    offsets = np.cumsum([0, *(len(v) for v, _ in parts)])
    return Mesh(
        np.concatenate([v for v, _ in parts]),
        np.concatenate([f + at for (_, f), at in zip(parts, offsets, strict=False)]),
    )


def bent(turns, segments=48, sides=12):
    """A bar bent into more than a full circle: it runs into itself."""
    along = np.linspace(0.0, 2.0 * np.pi * turns, segments)
    around = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)
    a, b = np.meshgrid(along, around, indexing="ij")
    radius = 1.0 + 0.13 * np.cos(b)
    points = np.stack([radius * np.cos(a), radius * np.sin(a), 0.13 * np.sin(b)], axis=2)
    faces = []
    for i in range(segments - 1):
        for j in range(sides):
            k = (j + 1) % sides
            p, q, r, s = i * sides + j, (i + 1) * sides + j, (i + 1) * sides + k, i * sides + k
            faces += [[p, q, r], [p, r, s]]
    ends = np.array([[1.0, 0.0, 0.0], [np.cos(along[-1]), np.sin(along[-1]), 0.0]])
    for end, row, way in ((0, 0, 1), (1, segments - 1, -1)):
        for j in range(sides):
            face = [segments * sides + end, row * sides + j, row * sides + (j + 1) % sides]
            faces.append(face[::way])
    mesh = Mesh(np.vstack([points.reshape(-1, 3), ends]), np.array(faces))
    return mesh if mesh.volume > 0 else Mesh(mesh.vertices, mesh.faces[:, ::-1])


def truth(mesh, solid, number=4000):
    """(removed, added) at points of both surfaces, from libigl alone."""
    result = []
    for one, other in ((mesh, solid), (solid, mesh)):
        surface = trimesh.Trimesh(one.vertices, one.faces, process=False)
        points, _ = trimesh.sample.sample_surface(surface, number, seed=5)
        points = np.vstack([one.vertices, points])
        away = np.sqrt(igl.point_mesh_squared_distance(points, other.vertices, other.faces)[0])
        if other is solid:
            away[igl.winding_number(solid.vertices, solid.faces, points) > 0.5] = 0.0
        result.append(float(away.max()))
    return result


def holds(mesh, result):
    removed, added = truth(mesh, result.solid)
    slack = 1e-9 * mesh.diagonal
    assert removed <= result.deviation.removed + slack
    assert added <= result.deviation.added + slack


def test_an_exact_union_has_moved_nothing():
    mesh = joined(box(), box(at=(0.5, 0.3, 0.2)))
    assert repair(mesh).moved == 0.0


@pytest.mark.parametrize("angle", [0.3, 1.0, 2.2])
def test_a_turned_union_has_moved_less_than_a_millionth(angle):
    turn = trimesh.transformations.rotation_matrix(angle, [0.3, -0.7, 0.2])[:3, :3]
    mesh = joined(box(), box(at=(0.5, 0.3, 0.2)), box((0.2, 0.2, 3.0)))
    result = repair(Mesh(mesh.vertices @ turn.T, mesh.faces))
    assert result.moved <= 1e-6 * mesh.diagonal


def test_a_cavity_flush_with_a_side_opens_it_and_the_lost_wall_is_told():
    mesh = joined(box(), box((0.5, 0.5, 0.5), (0.0, 0.0, 0.25), "inward"))
    result = repair(mesh)
    assert result.solid.volume == pytest.approx(0.875)
    assert 0.25 - 1e-9 <= result.deviation.removed <= 0.27
    assert repair(mesh, policy=RepairPolicy(mode="strict")).solid is None


@pytest.mark.parametrize("turns", [1.05, 1.2])
def test_what_is_made_of_shells_that_run_into_themselves_is_measured(turns):
    mesh = joined((bent(turns).vertices, bent(turns).faces), box((0.5, 0.5, 0.5), (-1.0, 0.0, 0.2)))
    result = repair(mesh)
    assert result.solid is not None
    holds(mesh, result)


def test_needles_that_a_weld_drops_are_measured():
    vertices, faces = box()
    fin = np.array([[0.5, 0.0, 0.5], [0.5, 2e-6, 0.5], [0.9, 0.0, 0.9]])
    mesh = Mesh(np.vstack([vertices, fin]), np.vstack([faces[1:], [[8, 9, 10]]]))
    dropped = weld_boundary(mesh.vertices, mesh.faces, 1e-5).dropped
    np.testing.assert_array_equal(dropped, [fin])
    result = repair(mesh)
    assert result.solid is not None
    holds(mesh, result)


def test_the_volume_of_a_void_is_no_change_unless_it_is_filled():
    mesh = joined(box(), box((0.5, 0.5, 0.5), wound="inward"))
    kept, filled = (repair(mesh, policy=RepairPolicy(cavities=c)) for c in ("keep", "fill"))
    assert kept.volume_change == pytest.approx(0.0, abs=1e-12)
    assert filled.volume_change == pytest.approx(0.125, rel=1e-9)


def crossed(outline):
    """A prism over a polygon; its caps are fans."""
    flat = np.column_stack([outline, np.zeros(len(outline))])
    n = len(flat)
    faces = [[0, i + 1, i] for i in range(1, n - 1)]
    faces += [[n, n + i, n + i + 1] for i in range(1, n - 1)]
    for i in range(n):
        j = (i + 1) % n
        faces += [[i, j, j + n], [i, j + n, i + n]]
    return Mesh(np.vstack([flat, flat + np.array([0.0, 0.0, 1.0])]), np.array(faces))


def test_what_encloses_inside_out_gets_a_thickness_where_it_would_be_lost():
    # A bow tie: one of its halves is inside-out.
    mesh = crossed([(0, 0), (2, 2), (2, 0), (0, 1)])
    result = repair(mesh)
    assert any(f.code == "AP209" and "inside-out" in f.message for f in result.findings)
    assert result.deviation.removed_p99 <= 0.01 * mesh.diagonal
    holds(mesh, result)


def test_a_body_turned_through_itself_keeps_both_its_ends():
    made = trimesh.creation.box().subdivide().subdivide()
    vertices = np.array(made.vertices)
    vertices[:, 0] *= 1.0 - 1.95 * (vertices[:, 2] + 0.5)  # the upper end through itself
    mesh = Mesh(vertices, np.asarray(made.faces))
    result = repair(mesh)
    assert result.solid.volume == pytest.approx(0.4884, rel=0.03)
    assert result.deviation.p99 <= 0.01 * mesh.diagonal
    holds(mesh, result)


def test_beyond_the_budget_is_what_bounds_something_and_is_far_from_the_solid():
    mesh = joined(box(), box((0.5, 0.5, 0.5), (0.0, 0.0, 0.25), "inward"))
    result = repair(mesh, policy=NARROW)
    assert result.solid is not None  # the wall that is lost bounds nothing
    assert strays(result.deviation, job_on(mesh, NARROW), Mesh(*box((0.9, 0.9, 0.9))))
    assert not strays(result.deviation, job_on(mesh, NARROW), result.solid)


def test_union_of_shells_side_by_side_needs_no_measure():
    united = unite((Shell.of(*box()), Shell.of(*box(at=(3.0, 0.0, 0.0)))), "keep")
    assert moved_by_union(united, NEVER) == (0.0, 0.0)


def triangle(*corners):
    return np.array([corners], dtype=float)


@pytest.mark.parametrize(
    ("corners", "undivided"),
    [
        (triangle((0.1, 0.1, 0.1), (0.2, 0.1, 0.1), (0.1, 0.3, 0.2)), True),  # inside
        (triangle((2.0, 0.0, 0.0), (3.0, 0.0, 0.0), (2.0, 1.0, 0.0)), True),  # outside
        (triangle((0.0, 0.0, 0.1), (2.0, 0.1, 0.1), (0.0, 0.3, 0.2)), False),  # through a side
        (triangle((0.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 0.0, 0.3)), False),  # over an edge
        (triangle((0.1, 0.1, 0.5), (0.3, 0.1, 0.5), (0.1, 0.3, 0.5)), True),  # on a side
        (triangle((0.1, 0.1, 0.5), (0.9, 0.1, 0.5), (0.1, 0.3, 0.5)), False),  # on it and beyond
        (triangle((0.5, -0.3, -0.3), (0.5, 0.3, -0.3), (0.2, 0.0, 0.0)), True),  # up to a side
    ],
)
def test_triangles_that_a_solid_divides_are_known(corners, undivided):
    assert whole(corners, *box()).tolist() == [undivided]
