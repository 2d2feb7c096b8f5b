"""Simple shapes in the place of hulls: what physics engines are fastest with.

A box, cylinder, capsule or sphere that encloses a hull may stand for it if no point of the
shape is farther than the tolerance from the solid. Both are proved: the shape's half-spaces,
or its distance to its axis, hold every vertex of the hull with a margin above rounding; and
the certificate is that of a polytope *around* the shape, so it holds for the shape too.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from assetpipe.decomposition.certificate import Certificate, Interval
from assetpipe.decomposition.hull import Hull
from assetpipe.geometry.mesh import FloatArray, Mesh, locked
from assetpipe.geometry.products import moved, turned

Kind = Literal["box", "cylinder", "capsule", "sphere"]
KINDS: tuple[Kind, ...] = ("box", "cylinder", "capsule", "sphere")

SIDES = 32
"""Of the polytopes around round shapes: they reach 0.5% of the radius beyond."""
_MARGIN = 1e-11
"""Of the size: room for the rounding of angles and of numbers in a file."""
_DIGITS, _WIDER = 12, 1e-9
"""Of cosines, and by how much of the radius polytopes are wider for their sake."""
_PRICES: dict[Kind, float] = {"box": 1.0, "sphere": 1.0, "cylinder": 1.01, "capsule": 1.03}
"""Of a unit of volume: shapes about as small are chosen for being simple."""
_SLIM = (0.1, 0.03, 0.01)
"""How far slimming may reach outward, in tolerances, as in the engine."""
_FEW = 8
"""Hulls with fewer vertices gain nothing from slimming."""
_BULKY = 3.0
"""Times the hull's volume: shapes beyond that are not worth a proof."""


@dataclass(frozen=True, eq=False)
class Primitive:
    """A simple shape.

    Attributes:
        kind: which.
        frame: (4, 4) ``hull_from_shape``: its centre, and its axes; the axis of a
            cylinder or capsule is the third.
        size: metres: the three sides of a box; radius and length of a cylinder; radius and
            length between the centres of the caps of a capsule; radius of a sphere.
    """

    kind: Kind
    frame: FloatArray
    size: tuple[float, ...]

    def __post_init__(self) -> None:
        locked(self.frame)

    @property
    def volume(self) -> float:
        """m³."""
        if self.kind == "box":
            return float(np.prod(self.size))
        area = np.pi * self.size[0] ** 2
        if self.kind == "cylinder":
            return float(area * self.size[1])
        ball = 4.0 / 3.0 * area * self.size[0]
        return float(ball + (area * self.size[1] if self.kind == "capsule" else 0.0))

    def depth(self, points: FloatArray) -> FloatArray:
        """How deep points (n, 3) lie in the shape, metres (n,); negative outside, where it is
        minus the largest excess over one of the bounds."""
        local = turned(points - self.frame[:3, 3], self.frame[:3, :3].T)
        if self.kind == "box":
            deep: FloatArray = (0.5 * np.asarray(self.size) - np.abs(local)).min(axis=1)
            return deep
        if self.kind == "sphere":
            from_centre: FloatArray = np.linalg.norm(local, axis=1)
            return self.size[0] - from_centre
        radius, half = self.size[0], 0.5 * self.size[1]
        across: FloatArray = np.linalg.norm(local[:, :2], axis=1)
        along: FloatArray = np.abs(local[:, 2])
        if self.kind == "cylinder":
            within: FloatArray = np.minimum(radius - across, half - along)
            return within
        to_axis: FloatArray = np.hypot(across, np.maximum(along - half, 0.0))
        return radius - to_axis

    def polytope(self) -> Mesh:
        """A convex polytope around the shape: the box itself; for others one whose faces
        touch it."""
        from assetpipe import _core

        points = moved(self._around(), self.frame)
        return Mesh(*_core.convex_hull(np.ascontiguousarray(points)))

    def _around(self) -> FloatArray:
        """Points whose hull encloses the shape, in its own frame."""
        if self.kind == "box":
            signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
            corners: FloatArray = 0.5 * signs * np.asarray(self.size)
            return corners
        # Rounded, since the last digits of cosines are the machine's, and widened by more.
        turn = 2.0 * np.pi * np.arange(SIDES) / SIDES
        ring = np.round(np.stack([np.cos(turn), np.sin(turn)], axis=1), _DIGITS) + 0.0
        # The regular polygon around the unit circle.
        outer = np.round(1.0 / np.cos(np.pi / SIDES), _DIGITS)
        radius = self.size[0] * (1.0 + _WIDER)
        if self.kind == "cylinder":
            half = 0.5 * self.size[1]
            disk = outer * radius * ring
            return np.vstack([np.insert(disk, 2, z, axis=1) for z in (-half, half)])
        # Each point of the sphere is within half a side of both angles of some point here.
        upright = ring[: SIDES // 2 + 1]
        ball: FloatArray = np.stack(
            [
                np.outer(upright[:, 1], ring[:, 0]).ravel(),
                np.outer(upright[:, 1], ring[:, 1]).ravel(),
                np.repeat(upright[:, 0], SIDES),
            ],
            axis=1,
        )
        ball = np.unique(np.round(ball, _DIGITS), axis=0) * (radius * outer * outer)
        if self.kind == "sphere":
            return ball
        half = 0.5 * self.size[1]
        return np.vstack([ball + np.array([0.0, 0.0, z]) for z in (-half, half)])

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready, metres."""
        return {
            "kind": self.kind,
            "frame": [[float(v) for v in row] for row in self.frame],
            "size": list(self.size),
        }

    @classmethod
    def of(cls, data: dict[str, Any]) -> Primitive:
        """From :meth:`as_dict`."""
        return cls(data["kind"], np.array(data["frame"], dtype=np.float64), tuple(data["size"]))


def enclosing(hull: Mesh, kinds: Sequence[Kind] = KINDS) -> tuple[Primitive, ...]:
    """Shapes around a hull, the smallest first; every vertex lies in each of them."""
    from assetpipe import _core

    margin = _MARGIN * float(np.abs(hull.bounds).max())
    found = []
    fits = _core.enclosing_shapes(np.ascontiguousarray(hull.vertices))
    for name, axes, centre, lengths, _ in fits:
        kind = next((known for known in kinds if known == name), None)
        if kind is None:
            continue
        frame = np.eye(4)
        frame[:3, :3] = np.array(axes).T
        frame[:3, 3] = centre
        shape = Primitive(kind, frame, _grown(kind, lengths, margin))
        if float(shape.depth(hull.vertices).min()) > 0.0:
            found.append(shape)
    return tuple(sorted(found, key=lambda shape: shape.volume * _PRICES[shape.kind]))


def _grown(kind: str, lengths: Sequence[float], margin: float) -> tuple[float, ...]:
    """Sizes from half lengths, each with the margin."""
    if kind == "box":
        return tuple(2.0 * (half + margin) for half in lengths)
    radius, half = lengths[0] + margin, lengths[1]
    if kind == "sphere":
        return (radius,)
    return (radius, 2.0 * (half + margin) if kind == "cylinder" else 2.0 * half)


def with_primitives(
    solid: Mesh,
    hulls: Sequence[Hull],
    epsilon: float,
    *,
    kinds: Sequence[Kind] = KINDS,
    on_progress: Callable[[float], object] | None = None,
) -> tuple[Hull, ...]:
    """The hulls, each replaced by the smallest simple shape around it that is proved to stay
    within ``epsilon`` of the solid, where there is one.

    Such a :class:`Hull` holds the polytope around the shape, its certificate and the shape
    itself. Its concavity is unknown: the shape encloses more than the part.

    Args:
        solid: what the hulls stand for, metres.
        hulls: of a decomposition; hulls that have been slimmed outward fit worse.
        epsilon: metres.
        kinds: which shapes may be used.
        on_progress: as in :func:`assetpipe.decompose`.
    """
    from assetpipe import _core

    tried = [
        (index, shape, shape.polytope())
        for index, hull in enumerate(hulls)
        for shape in enclosing(hull.mesh, kinds)
        if shape.volume <= _BULKY * hull.volume
    ]
    if not tried:
        return tuple(hulls)
    proofs = _core.thickening_within(
        np.ascontiguousarray(solid.vertices),
        np.ascontiguousarray(solid.faces),
        [np.ascontiguousarray(polytope.vertices) for _, _, polytope in tried],
        epsilon,
        on_progress,
    )
    result = list(hulls)
    done: set[int] = set()
    for (index, shape, polytope), proof in zip(tried, proofs, strict=True):
        if index in done or proof is None:
            continue
        done.add(index)
        # The polytope bounds the shape from above, the hull within it from below.
        lower = min(hulls[index].certificate.thickening.lower, proof[1])
        certificate = Certificate(Interval(lower, proof[1]), None)
        result[index] = Hull(polytope.vertices, polytope.faces, polytope.volume, certificate, shape)
    return tuple(result)


def slimmed(solid: Mesh, hull: Hull, epsilon: float) -> Hull:
    """The hull with fewer vertices, outward, if that is proved to stay within ``epsilon``: for
    hulls that were left as they were to find shapes around them."""
    from assetpipe import _core

    for share in _SLIM:
        if len(hull.vertices) <= _FEW:
            return hull
        vertices, faces = _core.simplify_within(hull.vertices, share * epsilon)
        if len(vertices) == len(hull.vertices):
            return hull
        (proof,) = _core.thickening_within(
            np.ascontiguousarray(solid.vertices),
            np.ascontiguousarray(solid.faces),
            [vertices],
            epsilon,
        )
        if proof is not None:
            mesh = Mesh(vertices, faces)
            certificate = Certificate(Interval(*proof), None)
            return Hull(mesh.vertices, mesh.faces, mesh.volume, certificate)
    return hull
