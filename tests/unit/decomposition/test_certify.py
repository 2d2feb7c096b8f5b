"""certify(): bounds for hulls of any origin, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

import assetpipe
from assetpipe.decomposition import decompose_with
from assetpipe.errors import MeshError, UsageError


def test_a_hull_inside_the_solid_has_no_thickening():
    ball = trimesh.creation.icosphere(3)
    (bounds,) = assetpipe.certify(ball, [ball.vertices * 0.5])
    assert bounds.lower == 0.0
    assert bounds.upper <= 1e-4


def test_a_grown_box_is_bounded_by_its_corner():
    cube = trimesh.creation.box((1, 1, 1))
    (bounds,) = assetpipe.certify(cube, [cube.vertices * 1.2])
    truth = 0.1 * np.sqrt(3)
    assert bounds.lower <= truth <= bounds.upper
    assert bounds.upper <= 1.02 * bounds.lower


def test_the_hull_of_an_l_is_bounded_by_its_notch():
    a, b = trimesh.creation.box((2, 1, 1)), trimesh.creation.box((1, 1, 2))
    b.apply_translation([-0.5, 0, 0.5])
    ell = a.union(b, engine="manifold")
    (bounds,) = assetpipe.certify(ell, [ell.vertices])
    # The farthest point of the hull lies on the slope between both arms, where
    # the distances to foot and tower are equal: in the middle of the diagonal.
    truth = 0.5
    assert bounds.lower <= truth + 1e-6
    assert bounds.upper >= truth - 1e-6
    assert bounds.upper <= 1.02 * bounds.lower


def test_flat_hulls_are_refused():
    cube = trimesh.creation.box((1, 1, 1))
    with pytest.raises(MeshError, match="hull 0"):
        assetpipe.certify(cube, [np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0.0]])])


def test_other_engines_are_certified_by_the_same_bounds():
    a, b = trimesh.creation.box((2, 1, 1)), trimesh.creation.box((1, 1, 2))
    b.apply_translation([-0.5, 0, 0.5])
    ell = a.union(b, engine="manifold")
    d = decompose_with("hull", ell, 0.05)
    assert len(d.hulls) == 1
    assert d.engine == "hull"
    assert d.certificate.lower > 0.4
    assert d.coverage.proof == "sample"
    assert d.coverage.complete
    with pytest.raises(UsageError, match="engine"):
        decompose_with("coacdd", ell, 0.05)


@pytest.mark.parametrize("engine", ["coacd", "vhacd"])
def test_installed_engines_run(engine):
    pytest.importorskip({"coacd": "coacd", "vhacd": "vhacdx"}[engine])
    a, b = trimesh.creation.box((2, 1, 1)), trimesh.creation.box((1, 1, 2))
    b.apply_translation([-0.5, 0, 0.5])
    ell = a.union(b, engine="manifold")
    d = decompose_with(engine, ell, assetpipe.Tolerance.coacd(0.1))
    assert len(d.hulls) >= 2
    assert d.certificate.upper < 0.5
