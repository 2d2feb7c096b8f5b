"""What every decomposition promises, held against exact arithmetic and brute force."""

from __future__ import annotations

from fractions import Fraction

import igl
import numpy as np
from exact import contains, is_convex, volume

from assetpipe import _core
from assetpipe.decomposition import Decomposition
from assetpipe.geometry import Mesh

Part = tuple[np.ndarray, np.ndarray]

_SEARCH = {
    "thickening": {"policy": "greedy"},
    "concavity": {"policy": "lookahead", "ways": "2"},
}


def parts_of(solid: Mesh, epsilon: float, metric: str = "thickening") -> list[list[Part]]:
    """The parts under each hull."""
    found: list[list[Part]] = _core.parts(
        np.ascontiguousarray(solid.vertices),
        np.ascontiguousarray(solid.faces),
        epsilon,
        # As `decompose` asks for either metric.
        {"metric": metric, **_SEARCH[metric]},
        1,
    )
    return found


def rounding(solid: Mesh) -> float:
    """What rounding of coordinates may move a point, metres."""
    return 64 * np.finfo(float).eps * float(np.abs(solid.vertices).max())


def points_in(solid: Mesh, count: int, seed: int = 7) -> np.ndarray:
    """(count, 3) points on and around the surface and in the box."""
    random = np.random.default_rng(seed)
    area = np.linalg.norm(
        np.cross(
            solid.vertices[solid.faces[:, 1]] - solid.vertices[solid.faces[:, 0]],
            solid.vertices[solid.faces[:, 2]] - solid.vertices[solid.faces[:, 0]],
        ),
        axis=1,
    )
    chosen = solid.faces[random.choice(len(area), count // 2, p=area / area.sum())]
    weight = random.dirichlet((1, 1, 1), len(chosen))
    near = np.einsum("ij,ijk->ik", weight, solid.vertices[chosen])
    near = near + random.normal(size=near.shape) * 0.01 * solid.diagonal
    low, high = solid.bounds
    return np.vstack([near, random.uniform(low, high, (count - len(near), 3))])


def windings(part: Part, points: np.ndarray) -> np.ndarray:
    """Generalized winding numbers by libigl, about the points' middle for precision."""
    vertices, faces = part
    centre = vertices.mean(axis=0)
    return np.asarray(
        igl.winding_number(
            np.ascontiguousarray(vertices - centre),
            np.ascontiguousarray(faces),
            np.ascontiguousarray(points - centre),
        )
    )


def distance_outside(solid: Mesh, points: np.ndarray) -> np.ndarray:
    """Distance of points from the solid, 0 inside: all triangles, libigl."""
    centre = solid.bounds.mean(axis=0)
    vertices = np.ascontiguousarray(solid.vertices - centre)
    faces = np.ascontiguousarray(solid.faces)
    moved = np.ascontiguousarray(points - centre)
    squared = igl.point_mesh_squared_distance(moved, vertices, faces)[0]
    inside = np.asarray(igl.winding_number(vertices, faces, moved)) > 0.5
    return np.where(inside, 0.0, np.sqrt(np.asarray(squared)))


def check_hulls(solid: Mesh, d: Decomposition) -> None:
    """Convex, outward, no larger than allowed, and over every vertex of the solid: exactly."""
    covered = np.zeros(len(solid.vertices), dtype=bool)
    for hull in d.hulls:
        assert is_convex(hull.vertices, hull.faces)
        exact = volume(hull.vertices, hull.faces)
        assert exact > 0
        slender = np.ptp(hull.vertices, axis=0).max() ** 2 * rounding(solid)
        assert abs(float(Fraction(hull.volume) - exact)) <= float(exact) * 1e-12 + slender
        held = d.metric == "thickening"
        bound = hull.certificate.thickening if held else hull.certificate.concavity
        assert bound is not None
        assert 0 <= bound.lower <= bound.upper <= d.epsilon * (1 + 1e-9)
        open_ones = np.flatnonzero(~covered)
        covered[open_ones] = contains(hull.vertices, hull.faces, solid.vertices[open_ones])
    used = np.unique(solid.faces)
    assert covered[used].all(), f"{(~covered[used]).sum()} vertices of the solid are bare"


def check_cover(solid: Mesh, d: Decomposition, count: int = 300) -> None:
    """Every sampled point of the solid is in a hull."""
    points = points_in(solid, count)
    points = points[windings((solid.vertices, solid.faces), points) > 0.5]
    covered = np.zeros(len(points), dtype=bool)
    for hull in d.hulls:
        covered |= contains(hull.vertices, hull.faces, points)
    # A point within rounding of a seam may be in neither of the two hulls.
    for point in points[~covered]:
        around = point + rounding(solid) * np.vstack([np.eye(3), -np.eye(3)])
        assert any(contains(h.vertices, h.faces, around).any() for h in d.hulls), point


def check_certificate(solid: Mesh, d: Decomposition, seed: int = 3) -> None:
    """lower ≤ truth ≤ upper, the truth enclosed by brute force.

    Points of a hull can only show that the truth is large; a grid over the hull's box, at
    most h from any of its points, shows that it is at most h more than what the grid sees.
    """
    random = np.random.default_rng(seed)
    slack = rounding(solid) + 1e-9 * solid.diagonal
    worst = max(d.hulls, key=lambda hull: hull.certificate.upper)
    for hull in d.hulls:
        weight = random.dirichlet(np.full(len(hull.vertices), 0.3), 60)
        points = np.vstack([hull.vertices, weight @ hull.vertices])
        assert distance_outside(solid, points).max() <= hull.certificate.upper + slack
    if worst.certificate.lower > 0:
        low, high = worst.vertices.min(axis=0), worst.vertices.max(axis=0)
        steps = np.maximum(np.ceil((high - low) / (high - low).max() * 16).astype(int), 1)
        ticks = [
            low[k] + (high[k] - low[k]) * (np.arange(n) + 0.5) / n for k, n in enumerate(steps)
        ]
        grid = np.stack(np.meshgrid(*ticks, indexing="ij"), axis=-1).reshape(-1, 3)
        reach = float(np.linalg.norm((high - low) / steps)) / 2
        a = worst.vertices[worst.faces]
        normals = np.cross(a[:, 1] - a[:, 0], a[:, 2] - a[:, 0])
        lengths = np.linalg.norm(normals, axis=1)
        # Slivers have no direction in double precision.
        wide = lengths > 1e-12 * lengths.max()
        normals, a = normals[wide] / lengths[wide, None], a[wide]
        above = np.einsum("pfk,fk->pf", grid[:, None] - a[None, :, 0], normals).max(axis=1)
        near = grid[above <= reach + slack]
        truth_below = distance_outside(solid, near).max(initial=0.0) + reach
        assert worst.certificate.lower <= truth_below + slack


def check_parts(solid: Mesh, d: Decomposition, groups: list[list[Part]]) -> None:
    """Volumes add up, hulls contain their parts exactly, interiors are disjoint."""
    whole = volume(solid.vertices, solid.faces)
    total = sum((volume(*part) for group in groups for part in group), Fraction(0))
    # One rounding of each new vertex, over the area of the surface: for a solid body
    # far below 1e-12 of the volume, for a sheet of a millionth a little more.
    allowed = max(float(whole) * 1e-12, solid.area * rounding(solid))
    assert abs(float(total - whole)) <= allowed
    assert len(groups) == len(d.hulls)
    for group, hull in zip(groups, d.hulls, strict=True):
        for vertices, faces in group:
            used = vertices[np.unique(faces)]
            assert contains(hull.vertices, hull.faces, used).all()
    points = points_in(solid, 200)
    expected = windings((solid.vertices, solid.faces), points)
    found = np.zeros(len(points))
    for part in (part for group in groups for part in group):
        winding = windings(part, points)
        sure = np.abs(winding - np.round(winding)) < 1e-6
        assert set(np.unique(np.round(winding[sure]))) <= {0.0, 1.0}
        found += winding
    np.testing.assert_allclose(found, expected, atol=1e-6)


def check_levels(solid: Mesh, d: Decomposition) -> None:
    """Coarser levels keep the promises and are never larger."""
    before = len(d.hulls)
    for times in (2.0, 5.0):
        level = d.at(tolerance=times * d.epsilon)
        assert 1 <= len(level.hulls) <= before
        before = len(level.hulls)
        assert level.certificate.upper <= times * d.epsilon * (1 + 1e-9)
        if d.metric == "thickening":
            check_hulls(solid, level)
    assert len(d.at(max_hulls=1).hulls) == 1
