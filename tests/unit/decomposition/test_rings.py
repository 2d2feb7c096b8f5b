"""Rings and tubes need few more hulls than sectors of equal sagitta, however they lie."""

from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh

import assetpipe

TOLERANCE = 0.05


def fewest(inner: float) -> int:
    """Sectors of a ring: each lines 2 acos(1 − ε/r) of the inner wall."""
    return math.ceil(math.pi / math.acos(1 - TOLERANCE / inner))


@pytest.mark.parametrize("turned", [False, True], ids=["plain", "turned"])
@pytest.mark.parametrize(("inner", "length"), [(0.9, 0.3), (0.65, 0.6), (0.4, 2.0)])
def test_rings_are_cut_into_sectors(inner, length, turned):
    ring = trimesh.creation.annulus(r_min=inner, r_max=1.0, height=length, sections=96)
    if turned:
        ring.apply_transform(trimesh.transformations.random_rotation_matrix(np.full(3, 0.37)))
    found = assetpipe.decompose(ring, tolerance=TOLERANCE)
    assert len(found.hulls) <= 1.2 * fewest(inner)
    assert found.certificate.upper <= TOLERANCE


def test_best_takes_no_more_hulls_and_the_same_on_any_threads():
    spiky = trimesh.util.concatenate(
        [trimesh.creation.box((2, 0.2, 0.2)), trimesh.creation.box((0.2, 0.2, 2))]
    )
    ring = trimesh.creation.annulus(r_min=0.7, r_max=1.0, height=0.4, sections=48)
    for shape in (ring, spiky):
        balanced = assetpipe.decompose(shape, tolerance=TOLERANCE)
        best = assetpipe.decompose(shape, tolerance=TOLERANCE, effort="best", threads=1)
        again = assetpipe.decompose(shape, tolerance=TOLERANCE, effort="best", threads=2)
        assert len(best.hulls) <= len(balanced.hulls)
        for a, b in zip(best.hulls, again.hulls, strict=True):
            assert a.vertices.tobytes() == b.vertices.tobytes()


def test_seed_is_what_tree_search_draws_from():
    mesh = trimesh.creation.annulus(r_min=0.6, r_max=1.0, height=0.4, sections=24)
    search = {"policy": "mcts", "sectors": "ignored", "iterations": 20, "prisms": "search"}

    def points(seed):
        found = assetpipe.decompose(
            mesh, tolerance=TOLERANCE, seed=seed, params=assetpipe.decomposition.Params(search)
        )
        return b"".join(hull.vertices.tobytes() for hull in found.hulls)

    assert points(0) == points(0)
    assert any(points(seed) != points(0) for seed in range(1, 4))
