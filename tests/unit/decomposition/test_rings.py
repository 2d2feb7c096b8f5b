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
