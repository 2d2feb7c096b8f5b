"""What a repair says about its deviation, against distances that trimesh measures."""

import numpy as np
import pytest
import trimesh
from scipy.spatial import Delaunay

from assetpipe.geometry import Mesh, RepairPolicy, Rung, repair
from assetpipe.geometry.repair.deviation import farthest
from assetpipe.geometry.repair.sheets import thicken
from assetpipe.geometry.repair.surface import Surface


def sphere(subdivisions: int) -> tuple[np.ndarray, np.ndarray]:
    mesh = trimesh.creation.icosphere(subdivisions=subdivisions)
    return np.array(mesh.vertices), np.array(mesh.faces)


def torn(by: float) -> Mesh:
    """A sphere one face of which hangs at a corner that is off by a little."""
    vertices, faces = sphere(3)
    moved = faces.copy()
    moved[0, 0] = len(vertices)
    off = vertices[faces[0, 0]] * (1.0 + by)
    return Mesh(np.vstack([vertices, off[None]]), moved)


def without_a_cap(height: float) -> Mesh:
    vertices, faces = sphere(3)
    return Mesh(vertices, faces[vertices[faces].mean(axis=1)[:, 2] < height])


def without_two_caps() -> Mesh:
    """A wide opening below, and one above that is narrow enough to be closed."""
    vertices, faces = sphere(4)
    x, y, z = vertices[faces].mean(axis=1).T
    narrow = (z > 0.0) & (np.hypot(x, y) < 0.06)
    return Mesh(vertices, faces[(z > -0.4) & ~narrow])


def sheet_with_a_step() -> Mesh:
    x, y = np.meshgrid(np.linspace(0, 1, 12), np.linspace(0, 1, 12), indexing="ij")
    z = 0.2 * np.floor(3.0 * x) + 0.05 * y
    index = np.arange(144).reshape(12, 12)
    a, b, c, d = (
        index[i : 11 + i, j : 11 + j].ravel() for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))
    )
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    return Mesh(np.stack([x, y, z], axis=-1).reshape(-1, 3), faces)


def distances(start: Mesh, end: Mesh, number: int = 4000) -> np.ndarray:
    """From points of one surface to the other."""
    points, _ = trimesh.sample.sample_surface(start.to_trimesh(), number, seed=3)
    return np.abs(trimesh.proximity.closest_point(end.to_trimesh(), points)[1])


@pytest.mark.parametrize(
    "mesh", [torn(5e-4), without_a_cap(0.995), without_a_cap(0.3), sheet_with_a_step()]
)
def test_bounds_hold_and_percentiles_are_of_the_surfaces(mesh: Mesh) -> None:
    result = repair(mesh)
    assert result.solid is not None
    added = distances(result.solid, mesh)
    assert result.deviation.added >= added.max() - 1e-9
    assert result.deviation.added_p99 == pytest.approx(np.quantile(added, 0.99), rel=0.3, abs=1e-5)
    # What lies inside the solid was not removed: the surface is farther than needed.
    removed = distances(mesh, result.solid)
    assert result.deviation.removed_p99 <= np.quantile(removed, 0.99) + 1e-4 * mesh.diagonal


def test_bounds_hold_for_the_thickness_of_caps() -> None:
    mesh = without_two_caps()
    result = repair(mesh, policy=RepairPolicy(budget=0.03, thickness=0.1))
    assert [step.rung for step in result.steps] == [Rung.FILL, Rung.SHEET]
    added = distances(result.solid, mesh, 40_000).max()
    assert added > 0.104
    assert result.steps[-1].moved >= added - 1e-9
    assert result.deviation.added >= added - 1e-9


def test_a_vertex_that_was_moved_does_not_move_the_percentile() -> None:
    mesh = torn(5e-4)
    result = repair(mesh)
    assert result.rung in (Rung.STITCH, Rung.SPLIT, Rung.FILL)
    assert 4e-4 < result.deviation.largest < 2e-3
    assert result.deviation.p99 < 1e-4


@pytest.mark.parametrize("side", ["inward", "centred"])
@pytest.mark.parametrize("mesh", [without_a_cap(0.3), sheet_with_a_step()])
def test_no_point_of_a_slab_is_farther_than_it_says(mesh: Mesh, side: str) -> None:
    slab = thicken(mesh.vertices, mesh.faces, 0.01, side)  # type: ignore[arg-type]
    away = distances(Mesh(slab.vertices, slab.faces), mesh)
    assert away.max() <= slab.away + 1e-9
    assert slab.away <= 0.03 + 1e-12


def test_a_surface_cut_up_otherwise_lies_where_it_was() -> None:
    """Quarters of the two triangles would have to become as small as the resolution."""
    ticks = np.linspace(0.0, 1.0, 38)
    x, y = (axis.ravel() for axis in np.meshgrid(ticks, ticks))
    turn = trimesh.transformations.rotation_matrix(0.7, [1, 2, 3])[:3, :3]
    points = np.stack([x, y, 0.0 * x], axis=1)
    fine = Surface(points @ turn.T, np.asarray(Delaunay(points[:, :2]).simplices, dtype=np.int64))
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]) @ turn.T
    coarse = square[[[0, 1, 2], [0, 2, 3]]]
    assert farthest(fine, coarse, side="surface", resolution=1e-6) < 2e-6
    lifted = coarse + 0.25 * turn[:, 2]
    assert farthest(fine, lifted, side="surface", resolution=1e-6) == pytest.approx(0.25, rel=0.05)
