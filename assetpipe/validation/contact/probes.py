"""Probes and where to put them: near contact, because far from it every rate is zero."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from assetpipe.geometry.mesh import FloatArray, IntArray
from assetpipe.validation.contact.surface import (
    ConvexShape,
    Frame,
    Surface,
    bvh_geometry,
    convex_geometry,
    outside_hulls,
)

ProbeKind = Literal["sphere", "box", "finger"]

STANDOFFS = ((-2.0, -1.0), (-1.0, 0.0), (0.0, 1.0), (1.0, 2.0), (2.0, 4.0))
"""Strata of the stand-off from the surface, in units of the band (about ε)."""

_BOX_FACES: IntArray = np.array(
    [
        [0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4],
        [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5],
    ],
    dtype=np.int64,
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Probe:
    """A convex shape that is brought near a surface.

    Attributes:
        kind: what it is.
        size: metres: a sphere's radius, a box's edge, a finger's length.
        vertices: (k, 3) metres, centred on the origin; empty for a sphere.
        faces: (f, 3); empty for a sphere.
    """

    kind: ProbeKind
    size: float
    vertices: FloatArray
    faces: IntArray

    @classmethod
    def sphere(cls, radius: float) -> Probe:
        """A sphere."""
        return cls("sphere", radius, np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64))

    @classmethod
    def box(cls, edge: float) -> Probe:
        """A cube; vertex ``4z + 2y + x`` is the corner with those signs."""
        corners = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)])
        return cls("box", edge, corners * (edge / 2.0), _BOX_FACES)

    @classmethod
    def finger(cls, length: float) -> Probe:
        """A gripper's finger: a bar a quarter as wide as long that tapers to a thin tip."""
        base = Probe.box(1.0).vertices
        tip = base[:, 2:] > 0
        width = np.where(tip, [[0.2, 0.08]], [[0.25, 0.2]])
        vertices = np.hstack([base[:, :2] * width, base[:, 2:]]) * length
        return cls("finger", length, vertices, _BOX_FACES)

    def reach(self, direction: FloatArray) -> float:
        """Support function: how far the probe extends along a unit direction (3,), metres."""
        if self.kind == "sphere":
            return self.size
        return float((self.vertices @ direction).max())

    def geometry(self, frame: Frame) -> Any:
        """The FCL geometry for yes/no and separation, in the frame's units."""
        import fcl

        if self.kind == "sphere":
            return fcl.Sphere(self.size * frame.scale)
        return bvh_geometry(self.vertices * frame.scale, self.faces)

    def solid_geometry(self, frame: Frame) -> Any:
        """The FCL geometry for penetration depth, in the frame's units."""
        import fcl

        if self.kind == "sphere":
            return fcl.Sphere(self.size * frame.scale)
        return convex_geometry(self.vertices * frame.scale, self.faces)


@dataclass(frozen=True, eq=False)
class Pose:
    """Where a probe is: index of the probe, rotation (3, 3), position (3,) in metres."""

    probe: int
    rotation: FloatArray
    position: FloatArray


def probe_set(diagonal: float, band: float) -> tuple[Probe, ...]:
    """Spheres, boxes and fingers from the band's size up to a tenth of the body.

    Args:
        diagonal: of the body's bounding box, metres.
        band: the distance around the surface that matters, metres.
    """
    small = max(band, 1e-4 * diagonal)
    return (
        Probe.sphere(small / 2.0),
        Probe.sphere(2.0 * small),
        Probe.sphere(max(8.0 * small, 0.03 * diagonal)),
        Probe.box(2.0 * small),
        Probe.box(max(8.0 * small, 0.05 * diagonal)),
        Probe.finger(max(16.0 * small, 0.15 * diagonal)),
    )


def random_rotations(count: int, rng: np.random.Generator) -> FloatArray:
    """(count, 3, 3) rotations, uniform (Shoemake 1992: a normalised Gaussian quaternion)."""
    q = rng.normal(size=(count, 4))
    w, x, y, z = (q / np.linalg.norm(q, axis=1, keepdims=True)).T
    return np.stack(
        [
            np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], -1),
            np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], -1),
            np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], -1),
        ],
        axis=1,
    )


def surface_samples(
    vertices: FloatArray, faces: IntArray, count: int, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Points (count, 3) spread over a surface by area, with outward unit normals.

    Systematic sampling along the cumulated area: every region gets its share, so the
    rates scatter less than with independent draws.
    """
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    cross = np.cross(b - a, c - a)
    doubled = np.linalg.norm(cross, axis=1)
    cumulated = np.cumsum(doubled)
    if count == 0 or not cumulated.size or not cumulated[-1] > 0.0:
        return np.zeros((0, 3)), np.zeros((0, 3))
    marks = (np.arange(count) + rng.random(count)) * (cumulated[-1] / count)
    chosen = np.minimum(np.searchsorted(cumulated, marks, side="right"), len(faces) - 1)
    # A mark can round onto a face without area; its neighbour in the list has some.
    chosen = np.where(doubled[chosen] > 0.0, chosen, int(np.argmax(doubled)))
    root, v = np.sqrt(rng.random((count, 1))), rng.random((count, 1))
    points = (1 - root) * a[chosen] + root * (1 - v) * b[chosen] + root * v * c[chosen]
    return points, cross[chosen] / doubled[chosen, None]


def _free_hull_points(
    solid: Surface,
    hulls: Sequence[ConvexShape],
    count: int,
    away: float,
    rng: np.random.Generator,
) -> tuple[FloatArray, FloatArray]:
    """Points of the hulls' outer surface that are off the solid: where the shape grew."""
    joined = Surface.of_hulls(hulls, solid.frame)
    points, normals = surface_samples(joined.vertices, joined.faces, 4 * count, rng)
    if not len(points):
        return points, normals
    outer = outside_hulls(points + normals * (away / 4.0), hulls) > 0.0
    points, normals = points[outer], normals[outer]
    off = solid.distances(points) > away
    points, normals = points[off], normals[off]
    pick = rng.permutation(len(points))[:count]
    return points[pick], normals[pick]


def near_contact(
    solid: Surface,
    hulls: Sequence[ConvexShape],
    probes: Sequence[Probe],
    *,
    samples: int,
    band: float,
    away: float,
    rng: np.random.Generator,
) -> tuple[Pose, ...]:
    """Poses within a few bands of contact, stratified over probes and stand-offs.

    Half start from the hulls' surface where it is off the solid (there the contacts can
    be false), the others, and all where there is no such surface, from the solid's own.

    Args:
        solid: the original surface.
        hulls: what stands for it.
        probes: shapes to place; each gets the same share.
        samples: number of poses.
        band: unit of the stand-offs, metres.
        away: how far a hull's surface must be from the solid to count as off it, metres.
        rng: seeded generator.
    """
    grown, grown_normals = _free_hull_points(solid, hulls, samples // 2, away, rng)
    own, own_normals = surface_samples(solid.vertices, solid.faces, samples - len(grown), rng)
    points, normals = np.vstack([grown, own]), np.vstack([grown_normals, own_normals])
    order = rng.permutation(len(points))
    points, normals = points[order], normals[order]
    rotations = random_rotations(len(points), rng)
    shares = rng.random(len(points))
    poses = []
    for i, (point, normal) in enumerate(zip(points, normals, strict=True)):
        probe = probes[i % len(probes)]
        low, high = STANDOFFS[(i // len(probes)) % len(STANDOFFS)]
        standoff = (low + (high - low) * shares[i]) * band
        reach = probe.reach(-(rotations[i].T @ normal))
        poses.append(Pose(i % len(probes), rotations[i], point + normal * (standoff + reach)))
    return tuple(poses)
