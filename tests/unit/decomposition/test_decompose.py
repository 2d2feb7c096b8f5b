"""decompose(): convexity, coverage, truth of certificates, determinism, errors."""

from __future__ import annotations

import time

import igl
import numpy as np
import pytest
import trimesh
from manifold3d import Manifold

import assetpipe
from assetpipe import decompose
from assetpipe.errors import CancelledError, MeshError, UsageError
from assetpipe.geometry import Mesh, RepairPolicy, repair


def box(lower, upper) -> Manifold:
    return Manifold.cube([b - a for a, b in zip(lower, upper, strict=True)]).translate(list(lower))


def arrays(solid: Manifold) -> tuple[np.ndarray, np.ndarray]:
    mesh = solid.to_mesh64()
    return np.asarray(mesh.vert_properties)[:, :3].copy(), np.asarray(mesh.tri_verts).astype(int)


def open_box() -> tuple[np.ndarray, np.ndarray]:
    return arrays(box((-1, -0.8, 0), (1, 0.8, 1)) - box((-0.92, -0.72, 0.08), (0.92, 0.72, 2)))


def ring() -> tuple[np.ndarray, np.ndarray]:
    outer, inner = Manifold.cylinder(0.5, 1, 1, 96), Manifold.cylinder(2, 0.8, 0.8, 96)
    return arrays(outer - inner.translate([0, 0, -1]))


def bumpy() -> tuple[np.ndarray, np.ndarray]:
    ball = trimesh.creation.icosphere(4)
    v = ball.vertices
    radius = 1 + 0.35 * np.sin(3 * v[:, 0]) * np.cos(4 * v[:, 1] + v[:, 2])
    return v * radius[:, None], ball.faces


SHAPES = {"open box": open_box, "ring": ring, "bumpy": bumpy}


def half_spaces(hull: assetpipe.Hull) -> tuple[np.ndarray, np.ndarray]:
    a, b, c = (hull.vertices[hull.faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return normals, np.einsum("ij,ij->i", normals, a)


def heights(hull: assetpipe.Hull, points: np.ndarray) -> np.ndarray:
    """Largest height of each point over the hull's faces: ≤ 0 inside."""
    normals, offsets = half_spaces(hull)
    return (points @ normals.T - offsets).max(axis=1)


def inside_points(mesh, count: int, seed: int) -> np.ndarray:
    v, f = mesh
    rng = np.random.default_rng(seed)
    lower, upper = v.min(axis=0), v.max(axis=0)
    points = lower + rng.random((count, 3)) * (upper - lower)
    winding = igl.fast_winding_number(v.astype(float), f.astype(np.int64), points)
    surface, _ = trimesh.sample.sample_surface(
        trimesh.Trimesh(v, f, process=False), count, seed=seed
    )
    return np.concatenate([points[np.asarray(winding) > 0.5], surface, v])


@pytest.fixture(scope="module", params=sorted(SHAPES))
def case(request):
    mesh = SHAPES[request.param]()
    return mesh, assetpipe.decompose(mesh, assetpipe.Tolerance.coacd(0.05))


def test_hulls_are_convex_and_minimal(case):
    _, d = case
    for hull in d.hulls:
        assert heights(hull, hull.vertices).max() < 1e-12
        assert hull.volume > 0
        assert set(hull.faces.ravel()) == set(range(len(hull.vertices)))


def test_every_point_of_the_solid_is_in_a_hull(case):
    mesh, d = case
    points = inside_points(mesh, 20_000, seed=1)
    outside = np.min([heights(hull, points) for hull in d.hulls], axis=0)
    assert d.coverage.complete
    assert outside.max() < 1e-9


def test_certificates_hold_against_samples(case):
    (v, f), d = case
    rng = np.random.default_rng(2)
    worst = 0.0
    for hull in d.hulls:
        corners = hull.vertices[rng.integers(len(hull.vertices), size=(3000, 4))]
        weights = rng.dirichlet(np.full(4, 0.5), 3000)
        points = np.concatenate([np.einsum("ij,ijk->ik", weights, corners), hull.vertices])
        distance = np.sqrt(igl.point_mesh_squared_distance(points, v.astype(float), f)[0])
        winding = np.asarray(igl.fast_winding_number(v.astype(float), f.astype(np.int64), points))
        found = np.where(winding > 0.5, 0.0, distance).max()
        assert hull.certificate.lower <= hull.certificate.upper <= d.epsilon
        assert found <= hull.certificate.upper + 2e-7  # igl: root of a rounded square
        worst = max(worst, found)
    # The bound is no empty promise: samples come near its lower end (an exact
    # decomposition, as of the open box, has none).
    assert worst >= 0.5 * d.certificate.lower


def test_threads_do_not_change_a_byte(case):
    mesh, d = case
    for threads in (1, 2, 3):
        again = assetpipe.decompose(mesh, d.tolerance, threads=threads)
        assert len(again.nodes) == len(d.nodes)
        for a, b in zip(again.nodes, d.nodes, strict=True):
            assert a.hull.vertices.tobytes() == b.hull.vertices.tobytes()
            assert a.hull.faces.tobytes() == b.hull.faces.tobytes()
            assert a.hull.certificate == b.hull.certificate


def test_levels_are_coarser_and_true(case):
    (v, f), d = case
    for count in range(1, len(d.hulls)):
        level = d.at(max_hulls=count)
        assert len(level.hulls) == count
        assert level.certificate.upper >= d.certificate.lower
    single = d.at(max_hulls=1).hulls[0]
    own = trimesh.Trimesh(v, f).convex_hull
    assert single.volume >= own.volume * (1 - 1e-9)
    wide = d.at(tolerance=4 * d.epsilon)
    assert wide.certificate.upper <= 4 * d.epsilon
    assert len(wide.hulls) <= len(d.hulls)
    assert d.at(tolerance=d.epsilon).certificate.upper <= d.epsilon


@pytest.mark.parametrize("factor", [1e-6, 1e-3, 1e4])
@pytest.mark.parametrize("shift", [0.0, 100.0])
def test_scale_and_place_do_not_matter(factor, shift):
    v, f = open_box()
    d = assetpipe.decompose((v * factor + shift * factor, f), assetpipe.Tolerance.coacd(0.05))
    assert len(d.hulls) == 5
    assert d.certificate.upper <= d.epsilon


def test_a_turned_part_needs_no_more_hulls():
    v, f = open_box()
    turn = trimesh.transformations.rotation_matrix(0.7, [0.3, -0.5, 0.8])[:3, :3]
    tolerance = assetpipe.Tolerance.metres(0.05)
    assert len(assetpipe.decompose((v @ turn.T, f), tolerance).hulls) <= 6


def test_the_order_of_faces_and_vertices_hardly_matters():
    v, f = open_box()
    rng = np.random.default_rng(0)
    order = rng.permutation(len(v))
    inverse = np.argsort(order)
    d = assetpipe.decompose((v[order], inverse[f][rng.permutation(len(f))]), 0.05)
    assert len(d.hulls) == len(assetpipe.decompose((v, f), 0.05).hulls)


def test_convex_input_returns_its_own_hull_at_once():
    ball = trimesh.creation.icosphere(3)
    mesh = assetpipe.Mesh.of(ball)
    assetpipe.decompose(mesh, 0.01)
    start = time.process_time()
    for _ in range(5):
        d = assetpipe.decompose(mesh, 0.01)
    assert (time.process_time() - start) / 5 < 0.02  # generous: machines differ
    assert len(d.hulls) == 1
    assert d.certificate.upper == 0.0
    assert set(map(tuple, d.hulls[0].vertices)) <= set(map(tuple, ball.vertices))


def test_separate_components_stay_separate():
    v, f = arrays(box((0, 0, 0), (1, 1, 1)) + box((5, 0, 0), (6, 1, 1)))
    d = assetpipe.decompose((v, f), 0.01)
    assert len(d.hulls) == 2
    assert sum(hull.volume for hull in d.hulls) == pytest.approx(2.0)


def test_a_dirty_mesh_is_repaired_and_said():
    v, f = open_box()
    soup = v[f].reshape(-1, 3)  # every face has its own vertices
    d = assetpipe.decompose((soup, np.arange(len(soup)).reshape(-1, 3)), 0.05)
    assert d.repair is not None
    assert d.repair.moved == 0.0
    assert len(d.hulls) == 5


def test_budgets_are_met_outwards_and_told():
    mesh = bumpy()
    free = assetpipe.decompose(mesh, 0.03)
    few = assetpipe.decompose(mesh, 0.03, max_hulls=3)
    assert len(few.hulls) == 3
    assert few.certificate.upper > free.certificate.upper
    light = assetpipe.decompose(mesh, 0.03, max_hull_vertices=16)
    assert max(len(hull.vertices) for hull in light.hulls) <= 16
    assert light.certificate.upper > 0.03
    both = assetpipe.decompose(mesh, 0.03, max_hulls=2, max_hull_vertices=12)
    assert len(both.hulls) == 2
    assert max(len(hull.vertices) for hull in both.hulls) <= 12
    points = inside_points(mesh, 5000, seed=3)
    for d in (few, light, both):
        assert np.min([heights(h, points) for h in d.hulls], axis=0).max() < 1e-9


def test_effort_is_a_name():
    v, f = open_box()
    for effort in ("fast", "balanced", "best"):
        d = assetpipe.decompose((v, f), 0.05, effort=effort)
        assert d.certificate.upper <= 0.05
    with pytest.raises(UsageError, match="did you mean 'balanced'"):
        assetpipe.decompose((v, f), 0.05, effort="balancd")


def test_progress_is_reported_and_false_cancels():
    mesh = bumpy()
    seen: list[float] = []
    assetpipe.decompose(mesh, 0.02, on_progress=seen.append)
    assert seen
    assert all(0 <= share <= 1 for share in seen)
    assert seen == sorted(seen)
    with pytest.raises(CancelledError):
        assetpipe.decompose(mesh, 0.002, on_progress=lambda share: False)

    class StopError(Exception):
        pass

    def stop(share: float) -> None:
        raise StopError

    with pytest.raises(StopError):
        assetpipe.decompose(mesh, 0.002, on_progress=stop)


def test_cancelling_takes_effect_within_a_tenth_of_a_second():
    asked: list[float] = []

    def cancel(share: float) -> bool:
        if not asked:
            asked.append(time.perf_counter())
        return False

    with pytest.raises(CancelledError):
        assetpipe.decompose(bumpy(), 0.001, on_progress=cancel)
    # Twice the promise: a loaded machine schedules threads late.
    assert time.perf_counter() - asked[0] < 0.2


@pytest.mark.parametrize(
    ("mesh", "error"),
    [
        ((np.zeros((0, 3)), np.zeros((0, 3), int)), MeshError),
        ((np.array([[0, 0, 0], [1, 0, np.nan], [0, 1, 0.0]]), np.array([[0, 1, 2]])), MeshError),
        ((np.eye(3), np.array([[0, 1, 7]])), MeshError),
    ],
)
def test_what_is_no_solid_is_a_typed_error(mesh, error):
    with pytest.raises(error):
        assetpipe.decompose(mesh, 0.01)


@pytest.mark.parametrize("tolerance", [0.0, -1.0, float("nan"), float("inf"), "2 parsec"])
def test_an_impossible_tolerance_is_a_usage_error(tolerance):
    with pytest.raises(UsageError):
        assetpipe.decompose(open_box(), tolerance)


@pytest.mark.parametrize("at", [2.0, 0.6], ids=["apart", "overlapping"])
def test_a_component_that_faces_inward_in_the_open_is_solid(at: float) -> None:
    """Taken as it is, it was a void: six plates around it, or parts without end."""
    big, small = trimesh.creation.box((1, 1, 1)), trimesh.creation.box((0.3, 0.3, 0.3))
    small.apply_translation((at, 0, 0))
    small.invert()
    vertices = np.vstack([big.vertices, small.vertices])
    result = assetpipe.decompose((vertices, np.vstack([big.faces, small.faces + 8])), "1%")
    assert len(result.hulls) == 2
    assert result.solid is not None
    assert result.solid.volume == pytest.approx(1.027 if at == 2.0 else 1 + 0.3**2 * 0.25)
    assert result.repair is not None
    assert result.repair.moved == 0.0


def twice(mesh: trimesh.Trimesh) -> Mesh:
    """Every face from both sides, corners of their own, as visual meshes have them."""
    soup = mesh.vertices[np.vstack([mesh.faces, mesh.faces[:, ::-1]])]
    return Mesh(soup.reshape(-1, 3), np.arange(soup.size // 3).reshape(-1, 3))


@pytest.mark.parametrize("seed", range(6))
def test_faces_from_both_sides_are_a_body_in_whatever_order(seed: int) -> None:
    order = np.random.default_rng(seed)
    ball = twice(trimesh.creation.icosphere(2, 0.4).apply_translation([3.0, 0.0, 0.0]))
    box = trimesh.creation.box()
    vertices = np.vstack([box.vertices, ball.vertices])
    faces = order.permutation(np.vstack([box.faces, ball.faces + len(box.vertices)]))
    made = decompose(Mesh(vertices, faces), 0.01)
    assert made.repair is not None
    assert len(made.hulls) == 2
    assert max(hull.vertices[:, 0].max() for hull in made.hulls) == pytest.approx(3.4)
    assert len(decompose(Mesh(ball.vertices, order.permutation(ball.faces)), 0.01).hulls) == 1


def test_what_repair_made_is_taken_as_it_is() -> None:
    mesh = Mesh.of(trimesh.creation.box())
    opened = Mesh(mesh.vertices, mesh.faces[1:])
    repaired = repair(opened)
    made = decompose(repaired, 0.01)
    assert made.repair is repaired
    assert made.solid is repaired.solid
    with pytest.raises(MeshError, match="cannot be made a solid"):
        decompose(repair(opened, policy=RepairPolicy(mode="off")), 0.01)


def crossing(seed: int) -> Mesh:
    """A prism over a star that runs through itself, faces in some order."""
    angle = 2.0 * np.pi * 2.0 * np.arange(5) / 5.0
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(5)])
    vertices = np.vstack([ring, ring + np.array([0, 0, 0.5]), [[0, 0, 0], [0, 0, 0.5]]])
    faces = []
    for i in range(5):
        j = (i + 1) % 5
        faces += [[i, j, j + 5], [i, j + 5, i + 5], [j, i, 10], [i + 5, j + 5, 11]]
    return Mesh(vertices, np.random.default_rng(seed).permutation(np.array(faces)))


def test_a_solid_that_runs_through_itself_is_known_in_whatever_order() -> None:
    made = [decompose(crossing(seed), 0.02) for seed in range(4)]
    assert all(one.repair is not None for one in made)
    assert len({len(one.hulls) for one in made}) == 1
