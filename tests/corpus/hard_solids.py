"""Solids on which numerics break, one named row each, with what must come out.

All are about one metre in size unless that is the point; the tests turn, mirror, scale, move
and permute them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import manifold3d
import numpy as np
import trimesh
from mesh_parts import Arrays, box, inverted, join, sphere

from assetpipe.geometry import Mesh


@dataclass(frozen=True)
class Solid:
    """A hard solid and its outcome.

    Attributes:
        family: of the difficulty.
        name: of the row.
        make: the mesh, closed.
        hulls: fewest and most hulls that are right at the tolerance.
        tolerance: share of the bounding box's diagonal.
        metric: what is held below the tolerance.
    """

    family: str
    name: str
    make: Callable[[], Arrays]
    hulls: tuple[int, int]
    tolerance: float = 0.02
    metric: Literal["thickening", "concavity"] = "thickening"

    @property
    def mesh(self) -> Mesh:
        """As :class:`Mesh`."""
        return Mesh(*self.make())

    def epsilon(self, changed: Mesh) -> float:
        """The tolerance in metres on this solid turned, scaled or moved."""
        original = self.mesh
        return self.tolerance * original.diagonal * _radius(changed) / _radius(original)


def _radius(mesh: Mesh) -> float:
    middle = mesh.vertices.mean(axis=0)
    return float(np.linalg.norm(mesh.vertices - middle, axis=1).max())


def arrays(solid: manifold3d.Manifold) -> Arrays:
    mesh = solid.to_mesh64()
    return np.array(mesh.vert_properties[:, :3]), np.array(mesh.tri_verts, dtype=np.int64)


def cube(size, at=(0.0, 0.0, 0.0)) -> manifold3d.Manifold:
    return manifold3d.Manifold.cube(size, True).translate(at)


def rod(radius: float, height: float, sides: int = 32) -> manifold3d.Manifold:
    return manifold3d.Manifold.cylinder(height, radius, radius, sides, True)


def angle_plate(thickness: float) -> Arrays:
    """Two plates at a right angle."""
    return arrays(
        cube((1, 1, thickness), (0.5, 0, thickness / 2))
        + cube((thickness, 1, 1), (thickness / 2, 0, 0.5))
    )


def ball_shell(thickness: float) -> Arrays:
    return join(sphere(2), inverted(sphere(2, 0.5 - thickness)))


def cup(thickness: float) -> Arrays:
    """An open box of thin walls."""
    return arrays(
        cube((1, 1, 1)) - cube((1 - 2 * thickness, 1 - 2 * thickness, 1), (0, 0, thickness))
    )


def tube_wall(thickness: float, sides: int = 24) -> Arrays:
    return arrays(rod(0.5, 1, sides) - rod(0.5 - thickness, 2, sides))


def sliver_box() -> Arrays:
    """A notched box, its top full of triangles with a height of a millionth."""
    vertices, faces = map(np.asarray, notched(0.3))
    top = np.flatnonzero((vertices[faces][:, :, 2] == vertices[:, 2].max()).all(1))
    a, b, c = faces[top[0]]
    middle = (vertices[a] + vertices[b]) / 2 + 1e-6 * (vertices[c] - vertices[a])
    middle[2] = vertices[:, 2].max()
    n = len(vertices)
    rest = np.delete(faces, top[0], axis=0)
    return np.vstack([vertices, middle]), np.vstack([rest, [[a, b, n], [b, c, n], [c, a, n]]])


def bent_needle() -> Arrays:
    return arrays(cube((1, 1e-4, 1e-4), (0.5, 0, 0)) + cube((1e-4, 1e-4, 1), (0.00005, 0, 0.49995)))


def notched(size: float) -> Arrays:
    """A cube without one of its corners."""
    return arrays(cube((1, 1, 1)) - cube((size, size, size), (0.5, 0.5, 0.5)))


def with_bump(size: float) -> Arrays:
    return arrays(cube((1, 1, 1)) + cube((size, size, size), (0.1, 0.2, 0.5)))


def bump_on_angle(size: float) -> Arrays:
    return arrays(
        cube((1, 1, 0.2)) + cube((0.2, 1, 1), (-0.4, 0, 0.4)) + cube((size,) * 3, (0.2, 0.1, 0.1))
    )


def gridded(part: Arrays, times: int) -> Arrays:
    """Every triangle divided into 4^times."""
    vertices, faces = part
    for _ in range(times):
        vertices, faces = trimesh.remesh.subdivide(vertices, faces)
    return np.asarray(vertices), np.asarray(faces)


def voxels(filled) -> Arrays:
    """A union of unit cells of a grid, quads split in two; touching edges come apart."""
    filled = np.pad(np.asarray(filled, dtype=bool), 1)
    solid = manifold3d.Manifold()
    cells = [cube((1, 1, 1), tuple(float(x) for x in at)) for at in np.argwhere(filled)]
    solid = manifold3d.Manifold.batch_boolean(cells, manifold3d.OpType.Add)
    vertices, faces = arrays(solid)
    return vertices / max(filled.shape), faces


def sponge() -> Arrays:
    """The first Menger sponge: six tunnels meet in the middle; genus 5."""
    index = np.indices((3, 3, 3)) == 1
    return voxels(index.sum(axis=0) < 2)


def stairs(steps: int) -> Arrays:
    x, _, z = np.indices((steps, 2, steps))
    return voxels(z <= x)


def checker() -> Arrays:
    """Four columns of which two and two touch along an edge, between two slabs."""
    filled = np.ones((2, 2, 3))
    filled[0, 0, 1] = filled[1, 1, 1] = 0
    return voxels(filled)


def nested_tubes() -> Arrays:
    """Tubes in tubes: a cut across leaves loops in loops in loops."""
    return join(*(arrays(rod(r, 1, 16) - rod(r - 0.05, 2, 16)) for r in (0.5, 0.35, 0.2)))


def holes_with_islands() -> Arrays:
    """A slab with square wells, in each an island, in one a well in the island."""
    solid = cube((1, 1, 0.4))
    for x in (-0.25, 0.25):
        solid -= cube((0.3, 0.3, 0.4), (x, 0, 0.1))
        solid += cube((0.15, 0.15, 0.3), (x, 0, 0.05))
    return arrays(solid - cube((0.05, 0.05, 0.2), (0.25, 0, 0.15)))


def lens_holes() -> Arrays:
    """Two round tunnels whose walls touch in a line."""
    return arrays(
        cube((1, 0.6, 0.3))
        - rod(0.2, 1, 24).translate((-0.2, 0, 0))
        - rod(0.2, 1, 24).translate((0.2, 0, 0))
    )


def torus_knot(p: int, q: int, along: int = 96, around: int = 8, radius: float = 0.06) -> Arrays:
    t = 2 * np.pi * np.arange(along) / along
    r = 0.3 + 0.12 * np.cos(q * t)
    spine = np.stack([r * np.cos(p * t), r * np.sin(p * t), 0.12 * np.sin(q * t)], axis=1)
    ahead = np.roll(spine, -1, axis=0) - np.roll(spine, 1, axis=0)
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    out = spine - 0.3 * np.stack([np.cos(p * t), np.sin(p * t), 0 * t], axis=1)
    u = out - np.einsum("ij,ij->i", out, ahead)[:, None] * ahead
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v = np.cross(ahead, u)
    a = 2 * np.pi * np.arange(around) / around
    rings = np.cos(a)[None, :, None] * u[:, None] + np.sin(a)[None, :, None] * v[:, None]
    vertices = (spine[:, None] + radius * rings).reshape(-1, 3)
    i, k = np.meshgrid(np.arange(along), np.arange(around), indexing="ij")
    at = i * around + k
    right = i * around + (k + 1) % around
    up = (i + 1) % along * around + k
    both = (i + 1) % along * around + (k + 1) % around
    faces = np.concatenate([np.stack([at, right, both], -1), np.stack([at, both, up], -1)]).reshape(
        -1, 3
    )
    return vertices, faces if trimesh.Trimesh(vertices, faces).volume > 0 else faces[:, ::-1]


def ring(at=(0.0, 0.0, 0.0), turned: bool = False) -> Arrays:
    mesh = trimesh.creation.torus(0.3, 0.05, major_sections=20, minor_sections=8)
    vertices = np.asarray(mesh.vertices)
    if turned:
        vertices = vertices[:, [0, 2, 1]] * [1, -1, 1]
    return vertices + np.asarray(at), np.asarray(mesh.faces)


def grate(holes: int) -> Arrays:
    """A plate with holes² square holes: genus holes²."""
    solid = cube((1, 1, 0.1))
    pitch = 1 / holes
    for x in range(holes):
        for y in range(holes):
            at = (-0.5 + (x + 0.5) * pitch, -0.5 + (y + 0.5) * pitch, 0)
            solid -= cube((0.7 * pitch, 0.7 * pitch, 1), at)
    return arrays(solid)


def drilled(width: float, depth: float = 0.9) -> Arrays:
    """A cube with a deep narrow square hole that ends inside."""
    return arrays(cube((1, 1, 1)) - cube((width, width, depth), (0.1, 0.07, 0.5 - depth / 2)))


def vessel(opening: float) -> Arrays:
    """A hollow box whose room is reached through a narrow opening only."""
    return arrays(
        cube((1, 1, 1)) - cube((0.6, 0.6, 0.6)) - cube((opening, opening, 0.4), (0.03, 0.02, 0.45))
    )


def far_balls(gap: float) -> Arrays:
    """A ball at a corner and three at the ends of its edges, about as large as one together."""
    ends = np.vstack([np.zeros(3), np.eye(3)])
    return join(*(sphere(1, 0.5 / gap, at) for at in ends))


def quantised(part: Arrays) -> Arrays:
    """As a binary STL stores it."""
    return np.asarray(part[0], dtype=np.float32).astype(float), part[1]


def fine_ring(around: int) -> Arrays:
    """A ring of around² faces."""
    mesh = trimesh.creation.torus(0.35, 0.15, major_sections=around, minor_sections=around // 2)
    return np.asarray(mesh.vertices), np.asarray(mesh.faces)


def prism(sides: int) -> Arrays:
    mesh = trimesh.creation.cylinder(0.5, 0.3, sections=sides)
    return np.asarray(mesh.vertices), np.asarray(mesh.faces)


def bitten_ball(times: int) -> Arrays:
    """A geodesic sphere without an octant: a crowd on a sphere, cut through its middle."""
    ball = trimesh.creation.icosphere(subdivisions=times, radius=0.5)
    solid = manifold3d.Manifold(
        manifold3d.Mesh64(
            np.array(ball.vertices, dtype=np.float64), np.array(ball.faces, dtype=np.uint64)
        )
    )
    return arrays(solid - cube((0.5, 0.5, 0.5), (0.25, 0.25, 0.25)))


def _thin(count: str, thickness: float) -> tuple[Solid, ...]:
    return (
        Solid("thin", f"plate 10^-{count}", lambda: box((1, 1, thickness)), (1, 1)),
        Solid("thin", f"angle of plates 10^-{count}", lambda: angle_plate(thickness), (2, 2)),
        Solid("thin", f"open box of walls 10^-{count}", lambda: cup(thickness), (5, 6)),
    )


SOLIDS: tuple[Solid, ...] = (
    *(row for k in (3, 4, 5, 6) for row in _thin(str(k), 10.0**-k)),
    Solid("thin", "hollow ball 10^-3", lambda: ball_shell(1e-3), (6, 60), 0.1),
    Solid("thin", "hollow ball 10^-6", lambda: ball_shell(1e-6), (6, 60), 0.1),
    Solid("thin", "tube wall 10^-3", lambda: tube_wall(1e-3), (6, 24), 0.03),
    Solid("thin", "tube wall 10^-5", lambda: tube_wall(1e-5), (6, 24), 0.03),
    Solid("needle", "needle", lambda: box((1, 1e-5, 1e-5)), (1, 1)),
    Solid("needle", "bent needle", bent_needle, (2, 2)),
    Solid("needle", "slivers", sliver_box, (1, 7)),
    Solid("needle", "prism of 2000 sides", lambda: prism(2000), (1, 1)),
    Solid("feature", "bump 10^-6", lambda: with_bump(1e-6), (1, 1)),
    Solid("feature", "notch 10^-6", lambda: notched(1e-6), (1, 1)),
    Solid("feature", "bump 10^-6 on an angle", lambda: bump_on_angle(1e-6), (2, 2)),
    Solid("feature", "notch 10^-3", lambda: notched(1e-3), (1, 1)),
    Solid("crowd", "gridded angle", lambda: gridded(angle_plate(0.2), 3), (2, 2)),
    Solid("crowd", "ball without an octant", lambda: bitten_ball(3), (3, 3)),
    Solid("crowd", "geodesic ball", lambda: sphere(3), (1, 1)),
    Solid("crowd", "tube of 200 sides", lambda: tube_wall(0.1, 200), (6, 24), 0.03),
    Solid("lattice", "Menger sponge", sponge, (12, 20)),
    Solid("lattice", "stairs", lambda: stairs(6), (6, 6)),
    Solid("lattice", "checker of columns", checker, (4, 6)),
    Solid("loops", "tubes in tubes", nested_tubes, (20, 60)),
    Solid("loops", "islands in wells", holes_with_islands, (8, 16)),
    Solid("loops", "tunnels that touch", lens_holes, (6, 20)),
    Solid("topology", "trefoil", lambda: torus_knot(2, 3, 64, 6), (10, 40), 0.03),
    Solid("topology", "cinquefoil", lambda: torus_knot(2, 5, 80, 6), (14, 60), 0.03),
    Solid("topology", "interlocked rings", lambda: join(ring(), ring((0.3, 0, 0), True)), (8, 40)),
    Solid("topology", "grate of genus 16", lambda: grate(4), (9, 30)),
    Solid("opening", "deep hole wider than the tolerance", lambda: drilled(0.12), (2, 8)),
    Solid(
        "opening",
        "deep hole wider, by concavity",
        lambda: drilled(0.12),
        (2, 20),
        metric="concavity",
    ),
    Solid("opening", "deep hole narrower", lambda: drilled(0.04), (1, 1)),
    Solid(
        "opening",
        "deep hole narrower, by concavity",
        lambda: drilled(0.04),
        (2, 16),
        metric="concavity",
    ),
    Solid("opening", "vessel with a small opening", lambda: vessel(0.05), (5, 14)),
    Solid(
        "opening",
        "vessel with a small opening, by concavity",
        lambda: vessel(0.05),
        (5, 24),
        metric="concavity",
    ),
    Solid("nested", "cavity", lambda: join(box(), inverted(box((0.5,) * 3))), (4, 8)),
    Solid(
        "nested",
        "cavity below the tolerance",
        lambda: join(box(), inverted(sphere(1, 0.02))),
        (1, 1),
    ),
    Solid(
        "nested",
        "body in a cavity",
        lambda: join(box(), inverted(box((0.6,) * 3)), box((0.3,) * 3)),
        (5, 10),
    ),
    Solid(
        "nested",
        "hollow body in a cavity",
        lambda: join(*(part for k in range(2) for part in _hollow(1 - 0.5 * k))),
        (10, 24),
        0.01,
    ),
    Solid("apart", "balls a hundred thousand sizes apart", lambda: far_balls(1e5), (4, 4)),
    Solid("file", "grate as an STL holds it", lambda: quantised(grate(3)), (6, 20)),
    Solid(
        "file",
        "knot as an STL holds it",
        lambda: quantised(torus_knot(2, 3, 64, 6)),
        (10, 40),
        0.03,
    ),
)

LARGE: tuple[Solid, ...] = (
    Solid("large", "ring of 40,000 faces", lambda: fine_ring(200), (6, 12), 0.03),
    Solid("large", "ring of 10^6 faces", lambda: fine_ring(1000), (6, 12), 0.03),
    Solid("large", "angle of 10^6 faces", lambda: gridded(angle_plate(0.2), 8), (2, 2)),
)


def _hollow(size: float) -> tuple[Arrays, Arrays]:
    return box((size,) * 3), inverted(box((0.7 * size,) * 3))
