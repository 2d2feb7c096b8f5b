"""An independent score for any set of convex hulls: shares no code with the engine.

Distances come from libigl, booleans from manifold3d, hull planes from Qhull. All
numbers are measured on samples, so each is a lower bound of the true value: a
number above the tolerance disproves a claim, one below it only fails to.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass

import igl
import numpy as np
from manifold3d import Manifold
from scipy.spatial import ConvexHull, QhullError


@dataclass(frozen=True)
class Score:
    """Measured on one mesh; lengths in the mesh's unit.

    Attributes:
        surface_outside: farthest sampled point of a hull's surface from the solid.
        volume_outside: the same over points inside the hulls (voids that a hull fills).
        uncovered: farthest sampled point of the solid's surface outside all hulls.
        depth: deepest sampled point of the solid's surface inside a hull.
        excess: volume of the hulls' union over the solid's volume, minus one.
        eq10: max(H_b, H_i) between S ∩ CH_i and CH_i (Eq. 10 of Wei et al. 2022), sampled.
        hulls, vertices: how many.
    """

    surface_outside: float
    volume_outside: float
    uncovered: float
    depth: float
    excess: float
    eq10: float
    hulls: int
    vertices: int

    def as_dict(self) -> dict[str, float]:
        return asdict(self)


def surface_points(vertices, faces, count, rng):
    """Area-weighted random points on triangles, with all vertices."""
    corners = vertices[faces]
    area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    if not area.sum() > 0:
        return vertices
    pick = rng.choice(len(faces), size=count, p=area / area.sum())
    u, v = rng.random((2, count, 1))
    flip = u + v > 1
    u, v = np.where(flip, 1 - u, u), np.where(flip, 1 - v, v)
    tri = corners[pick]
    inner = tri[:, 0] + u * (tri[:, 1] - tri[:, 0]) + v * (tri[:, 2] - tri[:, 0])
    return np.vstack([vertices, inner])


def referenced(vertices, faces):
    """Without the vertices that no face names: they are no part of the surface."""
    names, renamed = np.unique(faces, return_inverse=True)
    return vertices[names], renamed.reshape(faces.shape)


def distance_outside(points, vertices, faces):
    """Distance to the solid; zero inside it (winding number above one half)."""
    squared, *_ = igl.point_mesh_squared_distance(points, vertices, faces)
    winding = (
        igl.winding_number(vertices, faces, points)
        if len(faces) < 2000
        else (igl.fast_winding_number(vertices, faces, points))
    )
    return np.where(np.abs(winding) > 0.5, 0.0, np.sqrt(np.maximum(squared, 0.0)))


def half_spaces(hull):
    """Unit outward planes (k, 4): normal · x + offset <= 0 inside."""
    try:
        return np.unique(ConvexHull(np.asarray(hull)).equations, axis=0)
    except QhullError:
        return None


def score(vertices, faces, hulls, *, samples: int = 20_000, seed: int = 0) -> Score:
    """Score hulls, each a (k, 3) array of points, against a closed mesh."""
    rng = np.random.default_rng(seed)
    vertices = np.ascontiguousarray(vertices, dtype=np.float64)
    faces = np.ascontiguousarray(faces, dtype=np.int64)
    planes = [half_spaces(h) for h in hulls]
    shells = [
        ConvexHull(np.asarray(h)) if p is not None else None
        for h, p in zip(hulls, planes, strict=True)
    ]
    per_hull = max(400, samples // max(1, len(hulls)))

    surface, volume = [], []
    for hull, shell in zip(hulls, shells, strict=True):
        points = np.asarray(hull, dtype=np.float64)
        if shell is None:
            surface.append(points)
            continue
        surface.append(surface_points(points, shell.simplices, per_hull, rng))
        weights = rng.dirichlet(np.full(4, 1.0), size=per_hull)
        corners = rng.integers(0, len(shell.vertices), size=(per_hull, 4))
        volume.append((points[shell.vertices][corners] * weights[..., None]).sum(axis=1))
    outside = [distance_outside(p, vertices, faces) for p in surface]
    inner = distance_outside(np.vstack(volume), vertices, faces) if volume else np.zeros(1)

    skin = surface_points(*referenced(vertices, faces), samples, rng)
    reach = np.full(len(skin), np.inf)
    depth = np.full(len(skin), 0.0)
    eq10 = 0.0
    solid = manifold(vertices, faces)
    for hull, eq in zip(hulls, planes, strict=True):
        if eq is None:
            continue
        signed = (skin @ eq[:, :3].T + eq[:, 3]).max(axis=1)
        reach = np.minimum(reach, signed)
        depth = np.maximum(depth, -signed)
        if solid is not None:
            eq10 = max(eq10, eq10_of(solid, np.asarray(hull), eq, rng))
    union = Manifold.batch_boolean(
        [Manifold.hull_points(np.asarray(h)) for h in hulls], _union()
    ).volume()
    own = abs(float(signed_volume(vertices, faces)))
    return Score(
        surface_outside=float(max(o.max() for o in outside)),
        volume_outside=float(max(inner.max(), *(o.max() for o in outside))),
        uncovered=float(max(0.0, reach.max())),
        depth=float(depth.max()),
        excess=float(union / own - 1.0) if own else float("nan"),
        eq10=float(eq10),
        hulls=len(hulls),
        vertices=int(sum(len(np.asarray(h)) for h in hulls)),
    )


def eq10_of(solid, hull, planes, rng, samples: int = 3000) -> float:
    """max(H_b, H_i) of the part S ∩ CH against CH, both directions sampled."""
    part = solid ^ Manifold.hull_points(hull)
    if part.is_empty():
        return 0.0
    mesh = part.to_mesh64() if hasattr(part, "to_mesh64") else part.to_mesh()
    pv = np.ascontiguousarray(np.asarray(mesh.vert_properties)[:, :3], dtype=np.float64)
    pf = np.ascontiguousarray(np.asarray(mesh.tri_verts), dtype=np.int64)
    if not len(pf):
        return 0.0
    shell = ConvexHull(hull)
    on_hull = surface_points(hull, shell.simplices, samples, rng)
    squared, *_ = igl.point_mesh_squared_distance(on_hull, pv, pf)
    to_part = float(np.sqrt(squared.max()))
    on_part = surface_points(pv, pf, samples, rng)
    to_hull = float((-(on_part @ planes[:, :3].T + planes[:, 3])).min(axis=1).max())
    weights = rng.dirichlet(np.full(4, 1.0), size=samples)
    corners = rng.integers(0, len(hull), size=(samples, 4))
    inside = (hull[corners] * weights[..., None]).sum(axis=1)
    return max(to_part, to_hull, float(distance_outside(inside, pv, pf).max()))


def manifold(vertices, faces):
    """The solid for booleans, or None where manifold3d refuses it."""
    from manifold3d import Mesh64

    body = Manifold(Mesh64(vertices.copy(), faces.astype(np.uint64)))
    return None if body.is_empty() else body


def signed_volume(vertices, faces) -> float:
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def _union():
    from manifold3d import OpType

    return OpType.Add
