import numpy as np
import pytest
import trimesh

from assetpipe.errors import UsageError
from assetpipe.findings import Severity
from assetpipe.geometry.mesh import Mesh
from assetpipe.validation.contact.pairs import PairQueries
from assetpipe.validation.contact.probes import random_rotations
from assetpipe.validation.self_collision import (
    LinkBody,
    PairChange,
    SelfCollisions,
    adjacent_pairs,
    self_collisions,
)


def at(x, y=0.0, z=0.0):
    matrix = np.eye(4)
    matrix[:3, 3] = (x, y, z)
    return matrix


def box(size):
    return Mesh.of(trimesh.creation.box(size))


def ring():
    return Mesh.of(trimesh.creation.annulus(0.8, 1.0, 0.2))


def test_a_hull_over_a_ring_makes_a_new_pair_with_its_gap():
    ball = Mesh.of(trimesh.creation.icosphere(3, 0.1))
    before = [LinkBody("ring", (ring(),)), LinkBody("ball", (ball,))]
    hull = Mesh.of(ring().to_trimesh().convex_hull)
    after = [LinkBody("ring", (hull,), certificate=0.8), LinkBody("ball", (ball,))]
    result = self_collisions(before, after, [{"ring": np.eye(4), "ball": np.eye(4)}])
    assert result.home_before == ()
    assert result.home_after == (("ball", "ring"),)
    assert [c.pair for c in result.new] == [("ball", "ring")]
    assert result.new[0].gap == pytest.approx(0.7, abs=0.01)
    assert [f.code for f in result.findings()] == ["AP402"]


@pytest.mark.parametrize(("gap", "severity"), [(0.004, Severity.NOTE), (0.006, Severity.WARNING)])
def test_a_hair_of_what_is_allowed_is_a_note(gap, severity):
    change = PairChange(("a", "b"), configurations=1, first=0, gap=gap, allowed=0.5)
    told = SelfCollisions(1000, 1, (), (), (), (), (), (change,), ()).findings()
    assert [f.severity for f in told] == [severity]


def test_a_new_pair_farther_apart_than_proved_is_our_fault():
    ball = Mesh.of(trimesh.creation.icosphere(3, 0.1))
    hull = Mesh.of(ring().to_trimesh().convex_hull)
    result = self_collisions(
        [LinkBody("ring", (ring(),)), LinkBody("ball", (ball,))],
        [LinkBody("ring", (hull,), certificate=0.1), LinkBody("ball", (ball,))],
        [{"ring": np.eye(4), "ball": np.eye(4)}],
    )
    assert [f.code for f in result.findings()] == ["AP401"]


def test_a_pair_that_vanished():
    before = [LinkBody("a", (box((1, 1, 1)),)), LinkBody("b", (box((1, 1, 1)),))]
    after = [LinkBody("a", (box((0.5, 1, 1)),)), LinkBody("b", (box((1, 1, 1)),))]
    result = self_collisions(before, after, [{"a": at(0), "b": at(0.9)}])
    assert [c.pair for c in result.vanished] == [("a", "b")]
    assert result.vanished[0].gap == pytest.approx(0.15)
    assert [f.code for f in result.findings()] == ["AP403"]


def test_one_link_wholly_inside_another_touches():
    bodies = [LinkBody("case", (box((1, 1, 1)),)), LinkBody("core", (box((0.1, 0.1, 0.1)),))]
    result = self_collisions(bodies, bodies, [{"case": at(0), "core": at(0.2)}])
    assert result.home_before == (("case", "core"),)
    hollow = Mesh.of(
        trimesh.util.concatenate(
            [trimesh.creation.box((1, 1, 1)), _inverted(trimesh.creation.box((0.8, 0.8, 0.8)))]
        )
    )
    bodies = [LinkBody("case", (hollow,)), bodies[1]]
    assert self_collisions(bodies, bodies, [{"case": at(0), "core": at(0.2)}]).home_before == ()


def _inverted(mesh):
    mesh.invert()
    return mesh


def test_counts_over_configurations():
    bodies = [LinkBody("a", (box((1, 1, 1)),)), LinkBody("b", (box((1, 1, 1)),))]
    matrices = [{"a": at(0), "b": at(x)} for x in (2.0, 0.5, 0.2)]
    result = self_collisions(bodies, bodies, iter(matrices))
    assert result.configurations == 3
    assert result.always_before == ()
    assert result.never_before == ()
    moved = self_collisions(bodies, bodies, matrices[1:])
    assert moved.always_before == (("a", "b"),)
    assert self_collisions(bodies, bodies, matrices[:1]).never_before == (("a", "b"),)


def test_adjacent_links_through_fixed_joints():
    joints = [
        ("base", "link1", "revolute"),
        ("link1", "flange", "fixed"),
        ("flange", "hand", "fixed"),
        ("hand", "finger", "prismatic"),
    ]
    pairs = set(adjacent_pairs(joints))
    assert ("base", "link1") in pairs
    assert ("base", "hand") in pairs  # the hand is rigid with link1
    assert ("flange", "hand") in pairs
    assert ("finger", "link1") in pairs
    assert ("base", "finger") not in pairs


def test_excluded_pairs_are_not_asked():
    bodies = [LinkBody("a", (box((1, 1, 1)),)), LinkBody("b", (box((1, 1, 1)),))]
    result = self_collisions(bodies, bodies, [{"a": at(0), "b": at(0)}], excluded=[("b", "a")])
    assert result.pairs == 0
    assert result.home_before == ()


def test_links_without_geometry_touch_nothing():
    bodies = [LinkBody("a", (box((1, 1, 1)),)), LinkBody("empty", ())]
    assert self_collisions(bodies, bodies, [{"a": at(0), "empty": at(0)}]).pairs == 0


def test_small_robots_are_asked_in_scaled_units():
    size = 1e-4
    bodies = [LinkBody("a", (box((size,) * 3),)), LinkBody("b", (box((size,) * 3),))]
    touching, apart = (
        self_collisions(bodies, bodies, [{"a": at(0), "b": at(x * size)}]).home_before
        for x in (0.999, 1.001)
    )
    assert touching == (("a", "b"),)
    assert apart == ()


def test_wrong_calls():
    bodies = [LinkBody("a", (box((1, 1, 1)),)), LinkBody("b", (box((1, 1, 1)),))]
    with pytest.raises(UsageError, match="at least one"):
        self_collisions(bodies, bodies, [])
    with pytest.raises(UsageError, match="'b' not found"):
        self_collisions(bodies, bodies, [{"a": at(0)}])


def test_many_configurations_at_once_touch_where_each_does_alone():
    rng = np.random.default_rng(11)
    bodies = [
        LinkBody("ring", (Mesh.of(trimesh.creation.annulus(0.3, 0.4, 0.2)),)),
        LinkBody("bar", (Mesh.of(trimesh.creation.box((0.05, 0.05, 0.9))),)),
        LinkBody("dot", (Mesh.of(trimesh.creation.icosphere(1, 0.08)),)),
        LinkBody("far", (Mesh.of(trimesh.creation.box((0.1, 0.1, 0.1))),)),
    ]
    count = 300
    frames = {}
    for body in bodies:
        matrices = np.broadcast_to(np.eye(4), (count, 4, 4)).copy()
        matrices[:, :3, :3] = random_rotations(count, rng)
        matrices[:, :3, 3] = rng.uniform(-0.3, 0.3, (count, 3)) + (9.0 * (body.link == "far"))
        frames[body.link] = matrices
    queries = PairQueries(bodies)
    pairs = [("bar", "ring"), ("dot", "ring"), ("bar", "dot"), ("dot", "far")]
    together = queries.touching(pairs, frames)
    for index in range(count):
        queries.place({link: matrices[index] for link, matrices in frames.items()})
        for pair in pairs:
            assert bool(together[pair][index]) == queries.touch(pair)
    shares = [float(together[pair].mean()) for pair in pairs]
    assert shares[3] == 0.0
    assert all(0.01 < share < 0.9 for share in shares[:3])
