"""Solids damaged as real files are, for ``damage.py``: which damage, and which solid was meant.

The order of draws is what makes a number's mesh; a change of it makes other meshes of all numbers.
Damage is measured in diagonals of the bounding box.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import igl
import numpy as np
from manifold3d import Manifold
from manifold3d import Mesh64 as ManifoldMesh
from random_solids import Arrays, Random, side_by_side

from assetpipe.geometry import Mesh

Damage = Callable[[Random, np.ndarray, np.ndarray], Arrays]


@dataclass(frozen=True)
class Damaged:
    """A mesh with defects.

    Attributes:
        mesh: what a file would hold.
        kinds: of damage, in the order in which they were done.
        meant: the solid that it was, where every damage leaves no doubt which that is.
    """

    mesh: Mesh
    kinds: tuple[str, ...]
    meant: Mesh | None


def one_of(r: Random, *values: float) -> float:
    return float(values[r.integers(len(values))])


def diagonal(v: np.ndarray) -> float:
    return float(np.linalg.norm(np.ptp(v, axis=0)))


def direction(r: Random) -> np.ndarray:
    vector = r.normal(size=3)
    return np.asarray(vector / np.linalg.norm(vector))


def normals(v: np.ndarray, f: np.ndarray) -> np.ndarray:
    """Unit normals of vertices, by area; 0 where faces cancel."""
    corners = v[f]
    face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    total = np.zeros_like(v)
    np.add.at(total, f.ravel(), np.repeat(face, 3, axis=0))
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.asarray(np.divide(total, length, out=np.zeros_like(total), where=length > 0))


def halves(v: np.ndarray, f: np.ndarray, normal: np.ndarray, at: float) -> list[Arrays]:
    """Both sides of a plane, each closed by a cap; the whole if it is no solid."""
    solid = Manifold(ManifoldMesh(np.ascontiguousarray(v), np.ascontiguousarray(f, np.uint64)))
    if solid.is_empty() or solid.volume() <= 0:
        return [(v, f)]
    meshes = [side.to_mesh64() for side in solid.split_by_plane(normal, at) if not side.is_empty()]
    return [(np.array(m.vert_properties[:, :3]), np.array(m.tri_verts, np.int64)) for m in meshes]


def middle(v: np.ndarray, normal: np.ndarray, r: Random) -> float:
    """Where a plane across ``normal`` cuts somewhere in the middle."""
    heights = v @ normal
    low, high = float(heights.min()), float(heights.max())
    return low + (high - low) * r.uniform(0.3, 0.7)


# Damage that leaves no doubt which solid was meant.


def soup(r: Random, v: np.ndarray, f: np.ndarray) -> Arrays:
    """Every face has vertices of its own, exactly or nearly the same as its neighbours'."""
    corners = v[f].reshape(-1, 3)
    noise = one_of(r, 0, 0, 1e-9, 1e-7, 1e-6) * diagonal(v)
    return corners + r.normal(size=corners.shape) * noise, np.arange(len(corners)).reshape(-1, 3)


def flipped(r: Random, v: np.ndarray, f: np.ndarray) -> Arrays:
    """Some faces, or all, are turned over."""
    turned = r.random(len(f)) < one_of(r, 0.01, 0.1, 0.3, 1.1)
    return v, np.where(turned[:, None], f[:, ::-1], f)


def repeated(r: Random, v: np.ndarray, f: np.ndarray) -> Arrays:
    """Some faces are there two or three times, some of them turned over as well."""
    again = [f[r.random(len(f)) < one_of(r, 0.02, 0.2, 1.1)] for _ in range(r.integers(1, 3))]
    if r.integers(3) == 0:
        again[0] = again[0][:, ::-1]
    return v, np.vstack([f, *again])


def pinholes(r: Random, v: np.ndarray, f: np.ndarray) -> Arrays:
    """Faces smaller than half of a percent are missing, most of them apart from each other."""
    corners = v[f]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    gone = (longest < 0.005 * diagonal(v)) & (r.random(len(f)) < one_of(r, 0.01, 0.05))
    return v, f[~gone]


def t_junctions(r: Random, v: np.ndarray, f: np.ndarray) -> Arrays:
    """Faces on one side of a plane have their edges halved, their neighbours have not."""
    centres = v[f].mean(axis=1) @ direction(r)
    fine = centres > np.quantile(centres, r.uniform(0.2, 0.8))
    a, b, c = (v[f[fine, k]] for k in range(3))
    noise = r.normal(size=(len(a), 3)) * one_of(r, 0, 1e-9, 1e-7) * diagonal(v)
    ab, bc, ca = (a + b) / 2 + noise, (b + c) / 2, (c + a) / 2
    small = np.stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca], axis=1).reshape(-1, 3)
    return side_by_side([(v, f[~fine]), (small, np.arange(len(small)).reshape(-1, 3))])


def needles(r: Random, v: np.ndarray, f: np.ndarray) -> Arrays:
    """Faces are split at points on or nearly on their edges."""
    split = r.random(len(f)) < one_of(r, 0.05, 0.3)
    weight = r.dirichlet((0.05, 0.05, 0.05), int(split.sum()))
    points = np.einsum("ij,ijk->ik", weight, v[f[split]])
    points += r.normal(size=points.shape) * one_of(r, 0, 1e-15, 1e-12, 1e-9) * diagonal(v)
    new = len(v) + np.arange(len(points))
    a, b, c = f[split].T
    fans = [np.stack(t, axis=1) for t in ((a, b, new), (b, c, new), (c, a, new))]
    return np.vstack([v, points]), np.vstack([f[~split], *fans])


def quantised(r: Random, v: np.ndarray, f: np.ndarray) -> Arrays:
    """Coordinates of few digits, as decimals, halves or far from the origin; faces collapse."""
    way, size = r.integers(3), diagonal(v)
    if way == 0:
        step = one_of(r, 1e-3, 1e-4, 1e-5) * size
        return np.round(v / step) * step, f
    if way == 1:
        low = v.min(axis=0)
        return low + ((v - low) / size).astype(np.float16).astype(float) * size, f
    away = direction(r) * size * one_of(r, 100, 1000)
    return (v + away).astype(np.float32).astype(float) - away, f


def cracked(r: Random, v: np.ndarray, f: np.ndarray) -> Arrays:
    """Each face keeps to itself by a hair: all edges are cracks."""
    corners = v[f]
    shrunk = corners.mean(axis=1, keepdims=True)
    shrunk = corners + (shrunk - corners) * one_of(r, 1e-6, 1e-4, 1e-3)
    return shrunk.reshape(-1, 3), np.arange(3 * len(f)).reshape(-1, 3)


def walled(r: Random, v: np.ndarray, f: np.ndarray) -> Arrays:
    """Two closed halves with a wall twice between them, touching or a hair into each other."""
    normal = direction(r)
    sides = halves(v, f, normal, middle(v, normal, r))
    into = normal * one_of(r, 0, 0, 1e-7, 1e-5) * diagonal(v)
    return side_by_side([sides[0], *((v_ + into, f_) for v_, f_ in sides[1:])])


def inner_body(r: Random, v: np.ndarray, f: np.ndarray) -> Arrays:
    """A small copy inside, where there is most room of a few places: a part inside a part."""
    places = r.uniform(v.min(axis=0), v.max(axis=0), (300, 3))
    v_, f_ = np.ascontiguousarray(v), np.ascontiguousarray(f)
    inside = np.asarray(igl.winding_number(v_, f_, places)) > 0.99
    room = np.sqrt(np.asarray(igl.point_mesh_squared_distance(places, v_, f_)[0])) * inside
    best = int(room.argmax())
    small = (v - (v.min(axis=0) + v.max(axis=0)) / 2) / diagonal(v) * room[best] * r.uniform(0.2, 1)
    return side_by_side([(v, f), (places[best] + small, f)]) if room[best] else (v, f)


def finned(r: Random, v: np.ndarray, f: np.ndarray) -> Arrays:
    """Flaps of two faces back to back stand on edges and reach a tenth of a percent."""
    chosen = f[r.choice(len(f), min(len(f), int(r.integers(1, 12))))]
    tips = v[chosen].mean(axis=1) + normals(v, f)[chosen[:, 0]] * 0.001 * diagonal(v)
    new = len(v) + np.arange(len(tips))
    flap = np.stack([chosen[:, 0], chosen[:, 1], new], axis=1)
    return np.vstack([v, tips]), np.vstack([f, flap, flap[:, ::-1]])


def shuffled(r: Random, v: np.ndarray, f: np.ndarray) -> Arrays:
    """Vertices and faces in another order, vertices that nothing uses between them."""
    stray = v[r.integers(len(v), size=5)] + r.normal(size=(5, 3)) * diagonal(v)
    order = r.permutation(len(v) + 5)
    place = np.argsort(order)
    return np.vstack([v, stray])[order], place[f][r.permutation(len(f))]


# Damage after which nobody knows what was meant.


def torn(r: Random, v: np.ndarray, f: np.ndarray) -> Arrays:
    """Faces are missing, at random or around points."""
    if r.integers(2):
        return v, f[r.random(len(f)) > one_of(r, 0.01, 0.1, 0.4)]
    centres, kept = v[f].mean(axis=1), np.ones(len(f), dtype=bool)
    for _ in range(r.integers(1, 4)):
        around = np.linalg.norm(centres - centres[r.integers(len(f))], axis=1)
        kept &= around > one_of(r, 0.02, 0.1, 0.25) * diagonal(v)
    return v, f[kept]


def shaken(r: Random, v: np.ndarray, f: np.ndarray) -> Arrays:
    """Every vertex, or every corner of every face, is moved at random."""
    if r.integers(3) == 0:
        v, f = v[f].reshape(-1, 3), np.arange(3 * len(f)).reshape(-1, 3)
    return v + r.normal(size=v.shape) * one_of(r, 1e-5, 1e-4, 1e-3, 5e-3) * diagonal(v), f


def twisted(r: Random, v: np.ndarray, f: np.ndarray) -> Arrays:
    """Turned about an axis, so far that faces run through each other."""
    v = v - v.mean(axis=0)
    angle = one_of(r, 2, 6, 20) * v[:, 2] / diagonal(v)
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * v[:, 0] - s * v[:, 1], s * v[:, 0] + c * v[:, 1], v[:, 2]], axis=1), f


def clustered(r: Random, v: np.ndarray, f: np.ndarray) -> Arrays:
    """Vertices of a cell are one: folds, walls without thickness, faces twice."""
    step = diagonal(v) / one_of(r, 15, 40, 100, 300)
    places, which = np.unique(np.round(v / step) * step, axis=0, return_inverse=True)
    f = which.reshape(-1)[f]
    return places, f[(f[:, 0] != f[:, 1]) & (f[:, 1] != f[:, 2]) & (f[:, 2] != f[:, 0])]


def doubled(r: Random, v: np.ndarray, f: np.ndarray) -> Arrays:
    """A second skin, off by a hair or a wall's thickness, facing the same way or the other."""
    off = one_of(r, 1e-7, 1e-5, 1e-3, -1e-5, -1e-3, -1e-2) * diagonal(v)
    second = f[:, ::-1] if r.integers(2) else f
    shift = normals(v, f) if r.integers(2) else direction(r)
    return side_by_side([(v, f), (v + off * shift, second)])


def sheeted(r: Random, v: np.ndarray, f: np.ndarray) -> Arrays:
    """Sheets of two triangles stand in and beside the solid."""
    sheets = []
    for _ in range(r.integers(1, 5)):
        along, across = direction(r), direction(r)
        corner = v[r.integers(len(v))]
        u, w = along * r.uniform(0.02, 0.6) * diagonal(v), across * r.uniform(0.02, 0.6)
        w = w * diagonal(v)
        square = np.array([corner, corner + u, corner + u + w, corner + w])
        sheets.append((square, np.array([[0, 1, 2], [0, 2, 3]])))
    return side_by_side([(v, f), *sheets])


def overlaid(r: Random, v: np.ndarray, f: np.ndarray) -> Arrays:
    """Moved, turned and mirrored copies, some inside-out."""
    copies = [(v, f)]
    for _ in range(r.integers(1, 4)):
        turned = v[:, r.permutation(3)] * r.choice([-1.0, 1.0], 3)
        moved = turned + direction(r) * diagonal(v) * r.uniform(0, 0.5)
        copies.append((moved, f[:, ::-1] if r.integers(3) == 0 else f))
    return side_by_side(copies)


def rewired(r: Random, v: np.ndarray, f: np.ndarray) -> Arrays:
    """A few corners of faces are other vertices."""
    f, count = f.copy(), max(1, int(len(f) * one_of(r, 0.002, 0.02)))
    f[r.integers(len(f), size=count), r.integers(3, size=count)] = r.integers(len(v), size=count)
    return v, f


def flattened(r: Random, v: np.ndarray, f: np.ndarray) -> Arrays:
    """A half is pressed onto a plane, or all of it nearly is."""
    normal = direction(r)
    heights = v @ normal
    if r.integers(2):
        above = np.maximum(heights - middle(v, normal, r), 0)
        return v - above[:, None] * normal, f
    share = 1 - one_of(r, 1e-2, 1e-4, 1e-6, 0)
    return v - share * (heights - heights.mean())[:, None] * normal, f


PLAIN: tuple[Damage, ...] = (
    soup,
    flipped,
    repeated,
    pinholes,
    t_junctions,
    needles,
    quantised,
    cracked,
    walled,
    inner_body,
    finned,
    shuffled,
)
"""Damage that leaves no doubt which solid was meant."""

GRAVE: tuple[Damage, ...] = (
    torn,
    shaken,
    twisted,
    clustered,
    doubled,
    sheeted,
    overlaid,
    rewired,
    flattened,
)
"""Damage after which nobody knows."""


def damaged(r: Random, solid: Mesh) -> Damaged:
    """One to three kinds of damage; half of the meshes have plain ones only."""
    plain = bool(r.integers(2))
    among = PLAIN if plain else PLAIN + GRAVE
    chosen = [among[k] for k in r.integers(len(among), size=r.integers(1, 4))]
    if not plain and not set(chosen) & set(GRAVE):
        chosen[0] = GRAVE[r.integers(len(GRAVE))]
    v, f = np.array(solid.vertices), np.array(solid.faces)
    for damage in chosen:
        v, f = damage(r, v, f)
    kinds = tuple(damage.__name__ for damage in chosen)
    return Damaged(Mesh(v, f), kinds, solid if plain else None)
