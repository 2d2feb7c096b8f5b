"""Each step of the ladder on its own."""

import manifold3d
import numpy as np
import pytest
import trimesh

from assetpipe.errors import UsageError
from assetpipe.geometry import Mesh, RepairPolicy, is_solid, repair
from assetpipe.geometry.health.topology import Edges
from assetpipe.geometry.health.weld import degenerate
from assetpipe.geometry.repair.cells import separate
from assetpipe.geometry.repair.check import defect
from assetpipe.geometry.repair.clean import one_of_each, weld_exactly
from assetpipe.geometry.repair.deviation import deviation, farthest
from assetpipe.geometry.repair.frame import Frame
from assetpipe.geometry.repair.holes import cap, openings
from assetpipe.geometry.repair.orient import wind_consistently
from assetpipe.geometry.repair.overlap import overlap, untangled
from assetpipe.geometry.repair.sheets import thicken
from assetpipe.geometry.repair.split import split_nonmanifold
from assetpipe.geometry.repair.stitch import boundary_length, insert_junctions, weld_boundary
from assetpipe.geometry.repair.subdivide import insert_on_edges
from assetpipe.geometry.repair.surface import Surface, distance_to_triangles
from assetpipe.geometry.repair.unite import Shell, arrays_of, manifold_of, nest, unite
from assetpipe.geometry.repair.winding import solid_of_soup


def box(size=(1.0, 1.0, 1.0), at=(0.0, 0.0, 0.0)):
    mesh = trimesh.creation.box(size)
    return np.asarray(mesh.vertices) + np.asarray(at), np.asarray(mesh.faces)


def sphere(subdivisions=2):
    mesh = trimesh.creation.icosphere(subdivisions=subdivisions)
    return np.asarray(mesh.vertices), np.asarray(mesh.faces)


def join(*parts):
    offsets = np.cumsum([0, *(len(v) for v, _ in parts)])
    return (
        np.concatenate([v for v, _ in parts]),
        np.concatenate([f + at for (_, f), at in zip(parts, offsets, strict=False)]),
    )


# --- check


def test_check_names_what_is_wrong():
    vertices, faces = box()
    assert defect(vertices, faces) is None
    assert "one face only" in str(defect(vertices, faces[1:]))
    assert "opposite winding" in str(defect(vertices, np.vstack([faces[:1, ::-1], faces[1:]])))
    assert "volume" in str(defect(vertices, faces[:, ::-1]))
    assert "no face" in str(defect(np.vstack([vertices, [[9, 9, 9]]]), faces))
    touching = weld_exactly(*join(box(), box(at=(1, 1, 1))))
    assert "umbrellas" in str(defect(touching.vertices, touching.faces))


# --- weld


def test_exact_weld_keeps_the_first_of_each_and_their_order():
    vertices = np.array([[1.0, 0, 0], [0, 0, 0], [1.0, 0, 0], [0, 1, 0], [-0.0, 0, 0]])
    result = weld_exactly(vertices, np.array([[0, 3, 1], [2, 4, 3], [1, 4, 3]]))
    np.testing.assert_array_equal(result.vertices, vertices[[0, 1, 3]])
    np.testing.assert_array_equal(result.faces, [[0, 2, 1], [0, 1, 2]])
    assert (result.welded, result.degenerate) == (2, 1)


def test_one_of_each_ignores_the_winding():
    faces = np.array([[0, 1, 2], [2, 1, 0], [1, 2, 0], [0, 1, 3]])
    np.testing.assert_array_equal(one_of_each(faces), [[0, 1, 2], [0, 1, 3]])


# --- orientation


def test_winding_follows_the_larger_area():
    vertices, faces = sphere()
    random = np.random.default_rng(0)
    turned = faces.copy()
    chosen = random.random(len(faces)) < 0.3
    turned[chosen] = turned[chosen][:, ::-1]
    result, flipped, one_sided = wind_consistently(vertices, turned)
    np.testing.assert_array_equal(result, faces)
    assert (flipped, one_sided) == (chosen.sum(), 0)


# --- splitting


def test_splitting_moves_no_point_and_leaves_manifold_edges():
    whole = weld_exactly(*join(box(), box(at=(1, 1, 0)), box(at=(-1, -1, 1))))
    vertices, faces, added = split_nonmanifold(whole.vertices, whole.faces)
    assert added == 3
    assert defect(vertices, faces) is None
    assert {tuple(p) for p in vertices} == {tuple(p) for p in whole.vertices}


def test_material_lies_between_the_faces_that_stay_together():
    whole = weld_exactly(*join(box(), box(at=(1, 1, 0))))
    vertices, faces, _ = split_nonmanifold(whole.vertices, whole.faces)
    volumes = [p.volume for p in nest([Shell.of(vertices, faces)]).shells]
    assert volumes == pytest.approx([2.0])
    parts = trimesh.Trimesh(vertices, faces, process=False).split(only_watertight=False)
    assert [p.volume for p in parts] == pytest.approx([1.0, 1.0])


# --- points on edges


def test_points_on_all_edges_of_a_face_keep_its_area_and_winding():
    vertices = np.array([[0, 0], [1, 0], [0, 1], [0.3, 0], [0.6, 0], [0.5, 0.5], [0, 0.5]])
    vertices = np.column_stack([vertices, np.zeros(len(vertices))])
    faces = insert_on_edges(np.array([[0, 1, 2]]), {0: [3, 4], 1: [5], 2: [6]})
    areas = np.cross(
        vertices[faces[:, 1]] - vertices[faces[:, 0]], vertices[faces[:, 2]] - vertices[faces[:, 0]]
    )[:, 2]
    assert (areas > 0).all()
    assert areas.sum() / 2 == pytest.approx(0.5)
    boundary = Edges.of(faces, 7)
    assert len(boundary.boundary) == 7


# --- stitching


def test_boundary_weld_moves_only_the_boundary():
    vertices, faces = join(box(), box(at=(3, 0, 0)))
    near = vertices.copy()
    soup = near[faces[:12]].reshape(-1, 3) + np.random.default_rng(0).uniform(-1e-6, 1e-6, (36, 3))
    points = np.vstack([near[8:], soup])
    triangles = np.vstack([faces[12:] - 8, np.arange(36).reshape(-1, 3) + 8])
    result = weld_boundary(points, triangles, 1e-5)
    assert result.welded == 28
    assert result.displacement <= 2e-6 * np.sqrt(3)
    np.testing.assert_array_equal(result.vertices[:8], near[8:])
    assert boundary_length(result.vertices, result.faces) == 0.0


def test_a_junction_is_put_onto_the_edge():
    vertices, faces = box()
    a, b, c = faces[0]
    middle = (vertices[a] + vertices[b]) / 2 + [0, 0, 1e-7]
    points = np.vstack([vertices, middle])
    triangles = np.vstack([faces[1:], [[a, 8, c], [8, b, c]]])
    result = insert_junctions(points, triangles, 1e-6)
    assert result.inserted == 1
    assert result.displacement == pytest.approx(1e-7)
    assert boundary_length(result.vertices, result.faces) == 0.0


# --- cells


def test_a_wall_between_rooms_is_inside():
    right = box(at=(0.5, 0, 0))
    # Mirrored, so that the diagonals of the shared wall agree.
    left = (right[0] * [-1, 1, 1], right[1][:, ::-1])
    welded = weld_exactly(*join(left, right))
    parts = separate(welded.vertices, welded.faces)
    assert parts.bodies == 2
    assert len(parts.inner) == 2
    assert len(parts.sheets) == 0
    assert Mesh(welded.vertices, parts.skin).volume == pytest.approx(2.0)


def test_a_fin_is_a_sheet():
    vertices, faces = box()
    fin = np.array([[0.5, -0.5, 0.5], [0.5, 0.5, 0.5], [0.9, 0.5, 0.9]])
    welded = weld_exactly(*join((vertices, faces), (fin, np.array([[0, 1, 2]]))))
    parts = separate(welded.vertices, welded.faces)
    assert (parts.bodies, len(parts.skin), len(parts.sheets)) == (1, 12, 1)


def test_a_cavity_that_shares_an_edge_stays_empty():
    outer, inner = box(), box((0.5, 0.5, 1.0), (0.25, 0.25, 0.0))
    pocket = manifold_of(*outer) - manifold_of(*box((0.5, 0.5, 0.5), (0.25, 0.25, 0.0)))
    vertices, faces = arrays_of(pocket)
    parts = separate(vertices, faces)
    assert Mesh(vertices, parts.skin).volume == pytest.approx(1 - 0.125)
    assert len(inner[0]) == 8


# --- caps


@pytest.mark.parametrize("number", [3, 4, 7, 48, 49, 200])
def test_a_plane_cap_has_the_area_of_its_loop(number):
    angle = 2 * np.pi * np.arange(number) / number
    rim = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(number)])
    vertices = np.vstack([rim, [[0, 0, -1]]])
    faces = np.array([[(i + 1) % number, i, number] for i in range(number)])[:, [1, 0, 2]]
    found = openings(vertices, faces)
    assert [len(o.loop) for o in found] == [number]
    assert found[0].flatness == pytest.approx(0.0, abs=1e-12)
    closed = np.vstack([faces, cap(vertices, found[0])])
    assert not Edges.of(closed, len(vertices)).balance.any()
    assert abs(Mesh(vertices, closed).volume) == pytest.approx(
        number / 2 * np.sin(2 * np.pi / number) / 3
    )


def test_a_cap_never_needs_more_than_the_loop():
    random = np.random.default_rng(4)
    for number in (5, 30, 60):
        angle = np.sort(random.uniform(0, 2 * np.pi, number))
        radius = random.uniform(0.5, 1.0, number)
        rim = np.column_stack(
            [radius * np.cos(angle), radius * np.sin(angle), random.random(number)]
        )
        vertices = np.vstack([rim, [[0, 0, -3]]])
        faces = np.array([[i, (i + 1) % number, number] for i in range(number)])
        closed = np.vstack([faces, cap(vertices, openings(vertices, faces)[0])])
        edges = Edges.of(closed, len(vertices))
        assert not edges.balance.any()
        assert len(closed) == 2 * number - 2


def test_a_minimal_cap_is_no_larger_than_any_fan():
    random = np.random.default_rng(5)
    points = random.random((12, 3))
    from assetpipe.geometry.repair.holes import _least_area

    def area(triangles):
        a, b, c = (points[triangles[:, k]] for k in range(3))
        return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2

    best = area(_least_area(points))
    for start in range(12):
        fan = np.array([[start, (start + k) % 12, (start + k + 1) % 12] for k in range(1, 11)])
        assert best <= area(fan) + 1e-12


def test_a_loop_may_pass_a_vertex_twice():
    """Two squares of a sheet that touch at a corner are cut out: one rim around both."""
    ticks = np.arange(5.0)
    vertices = np.array([[x, y, 0] for x in ticks for y in ticks])
    faces = []
    for i in range(4):
        for k in range(4):
            if (i, k) in ((1, 1), (2, 2)):
                continue
            a, b, c, d = 5 * i + k, 5 * i + k + 5, 5 * i + k + 6, 5 * i + k + 1
            faces += [[a, b, c], [a, c, d]]
    faces = np.array(faces)
    loops = [opening.loop for opening in openings(vertices, faces)]
    assert sorted(len(loop) for loop in loops) == [8, 16]
    inner = min(loops, key=len)
    assert (inner == 12).sum() == 2
    caps = [cap(vertices, opening) for opening in openings(vertices, faces)]
    closed = np.concatenate([faces, *caps])
    closed = np.delete(closed, degenerate(closed), axis=0)
    assert not Edges.of(closed, 25).balance.any()


# --- nesting and union


def test_union_agrees_with_inclusion_and_exclusion():
    random = np.random.default_rng(6)
    for _ in range(5):
        at = random.uniform(-0.8, 0.8, 3)
        united = unite((Shell.of(*box()), Shell.of(*box(at=at))), "keep")
        assert united is not None
        common = np.prod(1 - np.abs(at))
        assert Mesh(united.vertices, united.faces).volume == pytest.approx(2 - common, rel=1e-12)


def test_shells_apart_are_left_alone():
    united = unite((Shell.of(*box()), Shell.of(*box(at=(3, 0, 0)))), "keep")
    assert united is not None
    assert united.joined == "apart"
    np.testing.assert_array_equal(united.vertices, join(box(), box(at=(3, 0, 0)))[0])


# --- self-overlap


def test_a_shell_that_overlaps_itself_encloses_once_afterwards():
    """Two boxes joined by a thin bridge outside and overlapping inside: one shell."""
    bridge = manifold_of(*box((3.0, 0.1, 0.1), (1.0, 0.0, 1.0)))
    posts = [manifold_of(*box((0.2, 0.2, 1.0), (x, 0.0, 0.5))) for x in (0.0, 2.0)]
    feet = [manifold_of(*box((0.8, 0.8, 0.4), (x, 0.0, 0.0))) for x in (0.0, 2.0)]
    whole = manifold3d.Manifold.batch_boolean([bridge, *posts, *feet], manifold3d.OpType.Add)
    vertices, faces = arrays_of(whole)
    # Bend the second foot into the first: same faces, now overlapping.
    bent = vertices.copy()
    foot = (vertices[:, 0] > 1.5) & (vertices[:, 2] < 0.21)
    bent[foot, 0] -= 1.7
    shell = Shell.of(bent / 4, faces)
    assert overlap(shell) > 0.01
    parts = untangled(shell)
    assert parts is not None
    assert sum(part.volume for part in parts) < shell.volume
    assert all(overlap(part) <= 0.005 for part in parts)


def test_sound_shells_do_not_overlap():
    for part in (box(), sphere(3), box((1, 1, 1e-6)), box((1, 1e-5, 1e-5))):
        assert overlap(Shell.of(*part)) == 0.0


# --- sheets


@pytest.mark.parametrize("side", ["inward", "centred"])
def test_a_plane_sheet_gets_its_thickness(side):
    vertices = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    slab = thicken(vertices, np.array([[0, 1, 2], [0, 2, 3]]), 0.01, side)
    points, faces = slab.vertices, slab.faces
    assert defect(points, faces) is None
    assert Mesh(points, faces).volume == pytest.approx(0.01)
    low, high = (0.0, 0.01) if side == "inward" else (0.005, 0.005)
    assert points[:, 2].min() == pytest.approx(-high)
    assert points[:, 2].max() == pytest.approx(low if side == "centred" else 0.0)


def test_inward_leaves_the_outside_alone():
    vertices, faces = box()
    open_box = faces[vertices[faces].mean(axis=1)[:, 2] < 0.49]
    slab = thicken(vertices, open_box, 0.01, "inward")
    points, closed = slab.vertices, slab.faces
    assert defect(points, closed) is None
    assert points.min() == -0.5
    assert points.max() == 0.5
    # Five walls, the corners counted once: mitred, up to where they end at the rim.
    assert Mesh(points, closed).volume == pytest.approx(5 * 0.01, rel=0.03)


def test_three_sheets_at_an_edge_become_one_solid():
    vertices = np.array(
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, -1, 0], [1, -1, 0], [0, 0, 1], [1, 0, 1]],
        dtype=float,
    )
    faces = np.array([[0, 1, 2], [0, 2, 3], [4, 5, 1], [4, 1, 0], [0, 1, 7], [0, 7, 6]])
    slab = thicken(vertices, faces, 0.01, "centred")
    points, closed = slab.vertices, slab.faces
    assert defect(points, closed) is None
    assert Mesh(points, closed).volume == pytest.approx(0.03, rel=0.01)


# --- winding numbers


def test_a_soup_with_gaps_becomes_the_sphere():
    vertices, faces = sphere(3)
    corners = vertices[faces] * 0.3
    centre = corners.mean(axis=1, keepdims=True)
    soup = (centre + 0.95 * (corners - centre)).reshape(-1, 3)
    solid = solid_of_soup(soup, np.arange(len(soup)).reshape(-1, 3), 0.01, 1_000_000)
    assert solid is not None
    assert defect(*solid) is None
    assert Mesh(*solid).volume == pytest.approx(Mesh(vertices * 0.3, faces).volume, rel=0.02)


def test_the_grid_has_a_limit():
    assert solid_of_soup(*sphere(3), 0.01, 1000) is None


def test_nothing_enclosed_is_none():
    vertices = np.array([[0, 0, 0], [0.5, 0, 0], [0, 0.5, 0]], dtype=float)
    assert solid_of_soup(vertices, np.array([[0, 1, 2]]), 0.01, 1_000_000) is None


# --- deviation


def test_the_distance_to_a_triangle_is_that_to_its_closest_point():
    random = np.random.default_rng(8)
    triangles, points = random.random((200, 3, 3)), 2 * random.random((200, 3))
    expected = np.linalg.norm(trimesh.triangles.closest_point(triangles, points) - points, axis=1)
    np.testing.assert_allclose(distance_to_triangles(points, triangles), expected, atol=1e-12)


def test_the_bound_holds_and_is_sharp():
    vertices, faces = box()
    target = Surface(*box((0.8, 0.8, 0.8)))
    bound = farthest(target, vertices[faces], side="surface", resolution=1e-4)
    truth = np.sqrt(3) * 0.1
    assert truth - 1e-12 <= bound <= 1.05 * truth + 1e-4
    inside = farthest(
        Surface(vertices, faces), box((0.8, 0.8, 0.8))[0][faces], side="solid", resolution=1e-4
    )
    assert inside <= 1e-4


def test_two_sided_deviation_tells_the_directions_apart():
    result = deviation(box(), box((1.2, 1.0, 1.0)), resolution=1e-4)
    assert result.added == pytest.approx(0.1, rel=0.06)
    assert result.removed <= 5e-4
    result = deviation(box((1.2, 1.0, 1.0)), box(), resolution=1e-4)
    assert result.removed == pytest.approx(0.1, rel=0.06)


# --- frame


def test_what_came_from_the_input_gets_its_bits_back():
    random = np.random.default_rng(9)
    points = random.random((100, 3)) * 1e-3 + 1e4
    frame = Frame.around(points)
    mixed = np.vstack([frame.inward(points)[::-1], [[0.1, 0.2, 0.3]]])
    restored, new = frame.restored(mixed, points)
    np.testing.assert_array_equal(restored[:100], points[::-1])
    assert new == 1


# --- policy


def test_a_wrong_choice_names_the_right_ones():
    with pytest.raises(UsageError, match="did you mean 'strict'"):
        RepairPolicy(mode="stricct")
    with pytest.raises(UsageError):
        RepairPolicy(budget=-1.0)


def test_off_changes_nothing_and_strict_moves_nothing():
    vertices, faces = box()
    soup = Mesh(vertices[faces].reshape(-1, 3), np.arange(36).reshape(-1, 3))
    assert repair(soup, policy=RepairPolicy(mode="off")).solid is None
    assert repair(soup, policy=RepairPolicy(mode="strict")).solid is not None
    holed = Mesh(*sphere(4)).faces[1:]
    mesh = Mesh(sphere(4)[0], holed)
    strict = repair(mesh, policy=RepairPolicy(mode="strict"))
    assert strict.solid is None
    assert [finding.code for finding in strict.findings] == ["AP202"]
    assert repair(mesh).solid is not None


@pytest.mark.parametrize(("choice", "volume"), [("fill", 1.0), ("sheet", 0.02), ("refuse", None)])
def test_a_wide_opening_is_a_choice(choice, volume):
    vertices, faces = box()
    mesh = Mesh(vertices, faces[vertices[faces].mean(axis=1)[:, 2] < 0.49])
    result = repair(mesh, policy=RepairPolicy(openings=choice))
    if volume is None:
        assert result.solid is None
        assert any(finding.code == "AP202" for finding in result.findings)
    else:
        assert result.solid is not None
        assert is_solid(result.solid)
        assert result.solid.volume == pytest.approx(volume, rel=0.15)


def test_a_stated_thickness_is_used():
    mesh = Mesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    result = repair(mesh, policy=RepairPolicy(thickness=0.002))
    assert result.solid is not None
    assert result.solid.volume == pytest.approx(0.002)
