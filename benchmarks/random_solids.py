"""Random nasty solids for ``stress.py``: families, and what is done to each solid afterwards.

The order of draws is what makes a number's solid; a change of it makes other cases of all numbers,
and another version of manifold3d may give the same solids other triangles.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

import numpy as np
import trimesh
from manifold3d import CrossSection, Manifold, OpType

from assetpipe.geometry import Mesh

Random = np.random.Generator
Arrays = tuple[np.ndarray, np.ndarray]


def arrays(solid: Manifold) -> Arrays:
    mesh = solid.to_mesh64()
    return np.array(mesh.vert_properties[:, :3]), np.array(mesh.tri_verts, dtype=np.int64)


def side_by_side(parts: list[Arrays]) -> Arrays:
    """Several meshes as one, nothing united."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in parts[:-1])])
    faces = [faces + start for (_, faces), start in zip(parts, starts, strict=True)]
    return np.vstack([vertices for vertices, _ in parts]), np.vstack(faces)


def cube_at(place: Iterable[float]) -> Manifold:
    return Manifold.cube((1, 1, 1), True).translate(tuple(map(float, place)))


def primitive(r: Random) -> Manifold:
    """A box, cone, ball or ring, on or off a grid, or off it by 1e-3 down to 1e-12."""
    kind = r.integers(4)
    size = np.round(r.uniform(0.1, 1, 3), 1 if r.integers(2) else 12)
    if kind == 0:
        shape = Manifold.cube(size, True)
    elif kind == 1:
        top = size[1] if r.integers(2) else size[2]
        shape = Manifold.cylinder(size[0], size[1] / 2, top / 2, int(r.integers(3, 24)), True)
    elif kind == 2:
        shape = Manifold.sphere(size[0] / 2, int(r.integers(4, 20)))
    else:
        outline = CrossSection.circle(0.1 * size[0] + 0.02, 8).translate((0.35, 0))
        shape = Manifold.revolve(outline, int(r.integers(4, 16)))
    turn = r.integers(3)
    if turn == 0:
        shape = shape.rotate(90.0 * r.integers(0, 4, 3))
    elif turn == 1:
        shape = shape.rotate(r.uniform(0, 360, 3))
    place = r.uniform(-0.5, 0.5, 3)
    if r.integers(2):
        place = np.round(place, 1)
    if r.integers(6) == 0:
        place = place + 10.0 ** -r.integers(3, 13)
    return shape.translate(place)


def added_or_removed(r: Random, solid: Manifold, tool: Manifold) -> Manifold:
    return solid + tool if r.integers(2) else solid - tool


def carved(r: Random) -> Arrays:
    """A box to which up to six primitives were added or from which they were removed."""
    size = (1, 1, 1) if r.integers(2) else np.round(r.uniform(0.3, 1.2, 3), 2)
    solid = Manifold.cube(size, True)
    for _ in range(r.integers(1, 7)):
        solid = added_or_removed(r, solid, primitive(r))
    return arrays(solid)


def thin(r: Random) -> Arrays:
    """A shell or crescent, or a body on a plate, 1e-2 down to 3e-8 thick."""
    thickness = 10.0 ** -r.uniform(2, 7.5)
    body = primitive(r)
    other = body.scale((1 - thickness,) * 3) if r.integers(2) else body.translate((0, 0, thickness))
    plate = Manifold.cube((1, 1, thickness), True).translate((0, 0, 0.3))
    return arrays(body - other if r.integers(2) else body + plate)


def cells(r: Random) -> Arrays:
    """Cubes of a grid, united or as they are: contact in faces, edges and corners."""
    places = np.argwhere(r.random(tuple(r.integers(2, 5, 3))) < 0.6)
    cubes = [cube_at(place) for place in places] or [cube_at((0, 0, 0))]
    if r.integers(2):
        return arrays(Manifold.batch_boolean(cubes, OpType.Add))
    return side_by_side([arrays(cube) for cube in cubes])


def specks(r: Random) -> Arrays:
    """A notched box with features, or steps between features, of 1e-3 down to 1e-9."""
    solid, fine = Manifold.cube((1, 1, 1), True), 10.0 ** -r.uniform(3, 9)
    for _ in range(r.integers(1, 5)):
        size = (fine,) * 3 if r.integers(2) else (0.3, 0.3, 0.3 + fine)
        tool = Manifold.cube(size, True).translate(np.round(r.uniform(-0.5, 0.5, 3), 1))
        solid = added_or_removed(r, solid, tool)
    # Named again: manifold3d puts operations together whose results nobody else holds.
    solid = solid - Manifold.cube((0.5, 0.5, 0.5))
    return arrays(solid)


def overlapping(r: Random) -> Arrays:
    """Bodies that run into each other: no solid until it is repaired."""
    return side_by_side([arrays(primitive(r)) for _ in range(r.integers(2, 5))])


def star(r: Random) -> Arrays:
    """A random star, extruded straight or tapering, as flat as 1e-4."""
    angles = np.linspace(0, 2 * np.pi, int(r.integers(5, 30)), endpoint=False)
    radii = r.uniform(0.2, 1, 30)[: len(angles)]
    # One by one: the last digit of a vector's sines is the processor's.
    points = [(math.cos(a) * q, math.sin(a) * q) for a, q in zip(angles, radii, strict=True)]
    height = float(10.0 ** -r.uniform(0, 4))
    top = (1, 1) if r.integers(2) else (0.7, 0.7)
    return arrays(Manifold.extrude(CrossSection([points]), height, scale_top=top))


FAMILIES: tuple[Callable[[Random], Arrays], ...] = (
    carved,
    carved,
    carved,
    thin,
    cells,
    specks,
    overlapping,
    star,
)
"""Carved bodies are three times as likely as any other."""


def solid_of(r: Random) -> Mesh | None:
    """A solid of a random family, changed; none where nothing was left of it."""
    vertices, faces = FAMILIES[r.integers(len(FAMILIES))](r)
    return Mesh(changed(r, vertices), faces) if len(faces) else None


def changed(r: Random, v: np.ndarray) -> np.ndarray:
    """Stretched, turned, in single precision, 1e-4 to 100 in size, up to 1e4 sizes away."""
    if r.integers(4) == 0:
        v = v * 10.0 ** r.uniform(-3, 0, 3)
    if r.integers(2):
        v = v @ trimesh.transformations.random_rotation_matrix(r.random(3))[:3, :3].T
    if r.integers(4) == 0:
        v = v.astype(np.float32).astype(float)
    v = v * 10.0 ** r.uniform(-4, 2)
    if r.integers(4) == 0:
        v = v + r.normal(size=3) * np.ptp(v, axis=0).max() * 10.0 ** r.uniform(0, 4)
    return v
