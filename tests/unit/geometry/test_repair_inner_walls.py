"""Walls in a solid: what lies inside goes, what stands out of it stays or is told."""

import numpy as np
import pytest
import shapely
import trimesh

from assetpipe.geometry import Mesh, Rung, repair

ANGLE = [(0, 0), (1, 0), (1, 0.4), (0.4, 0.4), (0.4, 1), (0, 1)]
VOLUME = 0.64 * 0.4


def angle_with_a_wall(tip: tuple[float, float, float]) -> Mesh:
    """An angle, and a triangle from its edge at (1, 0) through it to a tip."""
    shape = trimesh.creation.extrude_polygon(shapely.Polygon(ANGLE), 0.4)
    ends = np.flatnonzero((shape.vertices[:, :2] == (1, 0)).all(axis=1))
    wall = [*ends, len(shape.vertices)]
    return Mesh(np.vstack([shape.vertices, [tip]]), np.vstack([shape.faces, [wall]]))


def test_a_wall_wholly_inside_goes() -> None:
    result = repair(angle_with_a_wall((0.2, 0.2, 0.2)))
    assert result.solid is not None
    assert result.solid.volume == pytest.approx(VOLUME, rel=1e-12)
    assert result.deviation.largest == 0.0


def test_a_wall_that_crosses_free_space_gets_a_thickness() -> None:
    """Its middle is inside and so is its tip; what stands out in the notch is solid then."""
    mesh = angle_with_a_wall((0.05, 0.9, 0.2))
    result = repair(mesh)
    assert result.solid is not None
    assert result.rung is Rung.SHEET
    wall = mesh.vertices[mesh.faces[-1]]
    weights = np.random.default_rng(0).dirichlet((1, 1, 1), 2000)
    solid = result.solid.to_trimesh()
    outside = -trimesh.proximity.signed_distance(solid, weights @ wall)
    assert outside.max() <= result.deviation.removed + 1e-9
    assert result.deviation.largest <= 0.01 * mesh.diagonal
    assert VOLUME < result.solid.volume < 1.02 * VOLUME
