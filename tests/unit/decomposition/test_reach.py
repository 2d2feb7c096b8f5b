"""Space that nothing can enter counts as solid."""

from __future__ import annotations

import manifold3d
import numpy as np
import pytest

import assetpipe
from assetpipe.decomposition import Tolerance, close_unreachable, decompose_with
from assetpipe.decomposition.engine import is_closed
from assetpipe.errors import CancelledError, LimitError, UsageError
from assetpipe.geometry.mesh import Mesh


def mesh_of(solid: manifold3d.Manifold) -> Mesh:
    made = solid.to_mesh64()
    return Mesh(np.array(made.vert_properties)[:, :3], np.array(made.tri_verts).astype(np.int64))


def box(size, at=(0.0, 0.0, 0.0)) -> manifold3d.Manifold:
    return manifold3d.Manifold.cube(list(size), True).translate(list(at))


@pytest.fixture(scope="module")
def drilled() -> Mesh:
    """A plate of 100 × 60 × 20 mm with four through holes of 6 mm and a blind one of 20 mm."""
    plate = box((0.1, 0.06, 0.02))
    for x in (-0.035, 0.035):
        for y in (-0.02, 0.02):
            plate -= manifold3d.Manifold.cylinder(0.03, 0.003, 0.003, 24, True).translate(
                [x, y, 0.0]
            )
    plate -= manifold3d.Manifold.cylinder(0.02, 0.01, 0.01, 32).translate([0.0, 0.0, -0.005])
    return mesh_of(plate)


@pytest.fixture(scope="module")
def closed(drilled):
    return close_unreachable(drilled, 0.005, threads=2)


def in_some(points, hulls) -> np.ndarray:
    """How far outside of the nearest hull's faces points lie, at most 0 for those inside."""
    found = np.full(len(points), np.inf)
    for hull in hulls:
        a, b, c = (hull.vertices[hull.faces[:, k]] for k in range(3))
        normals = np.cross(b - a, c - a)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        heights = points @ normals.T - np.einsum("ij,ij->i", normals, a)
        found = np.minimum(found, heights.max(axis=1))
    return found


def test_screw_holes_are_closed_and_what_a_ball_enters_is_not(drilled, closed):
    found = closed
    assert found.closing.pockets == 4
    holes = 4 * np.pi * 0.003**2 * 0.02
    assert 0.6 * holes < found.closing.volume < holes
    assert is_closed(found.solid)
    assert found.solid.volume == pytest.approx(drilled.volume + found.closing.volume)
    # The wide hole stayed: its bottom is no deeper in the solid than before.
    above = np.array([[0.0, 0.0, 0.0]])
    assert assetpipe.certify(found.solid, [above + 1e-4 * np.eye(4, 3)])[0].lower > 0.004


def test_corners_of_the_given_solid_stay_to_the_bit(drilled, closed):
    kept = {row.tobytes() for row in closed.solid.vertices + 0.0}
    corners = [row for row in drilled.vertices + 0.0 if abs(row[0]) == 0.05]
    assert len(corners) == 8
    assert {row.tobytes() for row in corners} <= kept


def test_fewer_hulls_and_a_certificate_towards_the_closed_solid(drilled):
    epsilon = 0.002
    open_ = assetpipe.decompose(drilled, epsilon)
    shut = assetpipe.decompose(drilled, epsilon, reach=0.005)
    assert len(shut.hulls) < len(open_.hulls)
    assert shut.certificate.upper <= epsilon
    assert shut.closed is not None
    assert shut.closed.pockets == 4
    assert shut.as_dict()["closed"]["pockets"] == 4
    # Every point of the given solid is covered still.
    assert in_some(drilled.vertices, shut.hulls).max() <= 1e-12
    # No hull's point that a ball could touch is farther than allowed from the solid: balls
    # that stand on the plate, or in the wide hole.
    rng = np.random.default_rng(0)
    for hull in shut.hulls:
        weights = rng.dirichlet(np.ones(len(hull.vertices)), 200)
        points = weights @ hull.vertices
        assert (np.abs(points[:, 2]) <= 0.01 + epsilon).all()
        across = np.linalg.norm(points[:, :2], axis=1)
        in_wide = (across < 0.01) & (points[:, 2] > -0.005)
        deep = np.minimum(0.01 - across, points[:, 2] + 0.005)[in_wide]
        assert (deep <= epsilon + 1e-9).all()


def test_other_engines_close_too(drilled):
    found = decompose_with("hull", drilled, Tolerance.metres(0.002), reach=0.012)
    assert found.closed is not None
    assert found.closed.pockets == 5  # the wide hole too


def test_a_convex_solid_is_left_as_it_is():
    cube = mesh_of(box((0.1, 0.1, 0.1)))
    found = close_unreachable(cube, 0.01)
    assert found.solid is cube
    assert (found.closing.pockets, found.closing.volume) == (0, 0.0)


def test_the_same_bytes_whatever_the_threads(drilled, closed):
    assert close_unreachable(drilled, 0.005, threads=1).solid.digest == closed.solid.digest


@pytest.mark.parametrize("reach", [-0.001, float("nan"), float("inf")])
def test_what_is_no_length_is_refused(drilled, reach):
    with pytest.raises(UsageError, match="reach"):
        assetpipe.decompose(drilled, 0.002, reach=reach)


def test_a_reach_too_small_for_the_mesh_names_one_that_is_not(drilled):
    with pytest.raises(LimitError, match="at least"):
        close_unreachable(drilled, 1e-6)


def test_a_listener_that_says_no_stops_it(drilled):
    with pytest.raises(CancelledError):
        close_unreachable(drilled, 0.0012, on_progress=lambda _: False)
