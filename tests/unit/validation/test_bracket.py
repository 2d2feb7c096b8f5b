"""Two-sided answers against brute force."""

from __future__ import annotations

import igl
import numpy as np
import pytest
from manifold3d import Manifold

import assetpipe
from assetpipe import Bracket
from assetpipe.decomposition import decompose_with
from assetpipe.errors import UsageError
from assetpipe.geometry import Mesh

CUBE = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])


def mesh_of(body: Manifold) -> Mesh:
    made = body.to_mesh64()
    return Mesh(made.vert_properties[:, :3], made.tri_verts.astype(np.int64))


def hook() -> Manifold:
    body = Manifold.cube([2.0, 0.4, 0.4]) + Manifold.cube([0.4, 0.4, 1.5])
    body += Manifold.sphere(0.5, 32).translate([2.0, 0.2, 0.2])
    return body - Manifold.cylinder(2, 0.25, 0.25, 32).translate([2.0, 0.2, -1])


def placed(at, turn=None) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, 3] = at
    if turn is not None:
        pose[:3, :3] = turn
    return pose


def turned(rng: np.random.Generator) -> np.ndarray:
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn[:, 2] *= np.sign(np.linalg.det(turn))
    return turn


@pytest.fixture(scope="module")
def solid() -> Mesh:
    return mesh_of(hook())


@pytest.fixture(scope="module")
def bracket(solid: Mesh) -> Bracket:
    return Bracket(assetpipe.decompose(solid, "1%"))


def around(solid: Mesh, count: int, rng: np.random.Generator) -> np.ndarray:
    low, high = solid.vertices.min(axis=0), solid.vertices.max(axis=0)
    return (low + high) / 2 + 0.75 * (high - low) * rng.uniform(-1, 1, (count, 3))


def test_balls_are_answered_as_distance_and_winding_number_say(solid: Mesh, bracket: Bracket):
    rng = np.random.default_rng(0)
    at = around(solid, 400, rng)
    radii = solid.diagonal * rng.uniform(0.002, 0.05, len(at))
    away = np.sqrt(igl.point_mesh_squared_distance(at, solid.vertices, solid.faces)[0])
    inside = np.asarray(igl.fast_winding_number(solid.vertices, solid.faces, at)).ravel() > 0.5
    answers = []
    for centre, radius, distance, within in zip(at, radii, away, inside, strict=True):
        ball, pose = Bracket.ball(radius), placed(centre)
        answers.append(bracket.answer(ball, pose))
        truth = bool(within or distance < radius)
        assert answers[-1] in ("undecided", "collision" if truth else "free")
        assert bracket.collides(ball, pose) == truth
        # The other way round it is the same question.
        assert ball.answer(bracket, np.linalg.inv(pose)) == answers[-1]
    assert answers.count("undecided") <= 0.02 * len(answers)
    assert answers.count("collision") >= 0.05 * len(answers)


def test_solids_are_answered_as_their_intersection_says(solid: Mesh, bracket: Bracket):
    rng = np.random.default_rng(1)
    decided = 0
    for at in around(solid, 60, rng):
        turn = turned(rng)
        moved = hook().transform(np.column_stack([turn, at]))
        truth = (hook() ^ moved).volume() > 1e-9
        answer = bracket.answer(bracket, placed(at, turn))
        assert answer in ("undecided", "collision" if truth else "free")
        assert bracket.collides(bracket, placed(at, turn)) == truth
        decided += answer != "undecided"
    assert decided >= 50


def test_what_is_wholly_inside_touches():
    cube = mesh_of(Manifold.cube([1, 1, 1], True))
    bracket = Bracket(assetpipe.decompose(cube, "1%"))
    for probe in (Bracket.ball(0.01), Bracket.convex(0.01 * CUBE)):
        assert bracket.answer(probe, placed((0.2, 0.1, 0.0))) == "collision"
        assert bracket.meshes_touch(probe, placed((0.2, 0.1, 0.0)))
    for large in (Bracket.ball(10.0), Bracket.convex(10 * CUBE)):
        assert bracket.answer(large, placed((1.0, 0, 0))) == "collision"
        assert bracket.meshes_touch(large, placed((1.0, 0, 0)))


def test_a_void_is_free_though_hulls_may_cover_it():
    hollow = mesh_of(Manifold.cube([2, 2, 2], True) - Manifold.sphere(0.8, 48))
    bracket = Bracket(assetpipe.decompose(hollow, "1%"))
    probe, middle = Bracket.ball(0.1), placed((0, 0, 0))
    assert bracket.answer(probe, middle) == "free"
    covered = Bracket.between(hollow, outer=[mesh_of(Manifold.cube([2, 2, 2], True))], inner=[])
    assert covered.answer(probe, middle) == "undecided"
    assert not covered.collides(probe, middle)


@pytest.mark.parametrize("scale", [1e-4, 1e4])
def test_size_does_not_matter(scale: float):
    small = mesh_of(hook().scale([scale] * 3))
    bracket = Bracket(assetpipe.decompose(small, "1%"))
    ball = Bracket.ball(0.1 * scale)
    assert bracket.answer(ball, placed(np.array((1.0, 0.2, 0.2)) * scale)) == "collision"
    assert bracket.answer(ball, placed(np.array((1.0, 0.2, 1.0)) * scale)) == "free"


def test_a_plate_too_thin_for_the_margin_has_no_inner_side():
    plate = mesh_of(Manifold.cube([1, 1, 1e-7]))
    bracket = Bracket(assetpipe.decompose(plate, "1%"))
    ball = Bracket.ball(0.1)
    assert bracket.answer(ball, placed((0.5, 0.5, 0.05))) == "undecided"
    assert bracket.collides(ball, placed((0.5, 0.5, 0.05)))
    assert bracket.answer(ball, placed((0.5, 0.5, 0.11))) == "free"


def test_without_a_proof_of_cover_there_is_no_bracket(solid: Mesh):
    with pytest.raises(UsageError, match="not proved to cover"):
        Bracket(decompose_with("hull", solid, "1%"))


def test_a_pose_that_is_not_rigid_is_refused(bracket: Bracket):
    ball = Bracket.ball(0.1)
    for pose in (np.diag([2.0, 1, 1, 1]), np.diag([-1.0, 1, 1, 1]), np.full((4, 4), np.nan)):
        with pytest.raises(UsageError, match="rigid"):
            bracket.answer(ball, pose)
    with pytest.raises(UsageError, match="shape"):
        bracket.answer(ball, np.eye(3))
    with pytest.raises(UsageError, match="radius"):
        Bracket.ball(0.0)
