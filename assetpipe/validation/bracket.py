"""Two-sided collision answers: outer hulls prove freedom, inner hulls prove contact.

A solid S lies between two simple sets: inner hulls ⊂ S ⊂ outer hulls. What is clear of
the outer hulls is clear of S; what touches an inner hull touches S. Only between the two
the mesh itself has to be asked.

FCL answers for all three as triangle surfaces, whose pair tests are closed forms
(``contact/surface.py``). So that its rounding cannot turn a proof, the outer hulls are
enlarged and the inner ones shrunk by :data:`MARGIN` of the diagonal, a hundred times more
than FCL's own tolerance. FCL sees surfaces; what is wholly inside is found by half-spaces.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from assetpipe import _core
from assetpipe.errors import MeshError, UsageError
from assetpipe.geometry.mesh import FloatArray, Mesh
from assetpipe.validation.contact.pairs import LinkBody
from assetpipe.validation.contact.surface import UNITS, ConvexShape, bvh_geometry

if TYPE_CHECKING:
    from assetpipe.decomposition import Decomposition

Answer = Literal["free", "collision", "undecided"]

MARGIN = 1e-7
"""How far outer hulls are moved out and inner ones in, as a share of the diagonal."""


class _Side:
    """One of the three sets of a bracket, for FCL and for points."""

    def __init__(self, meshes: Sequence[Mesh], holder: Any, seeds: FloatArray) -> None:
        self._mesh = LinkBody("", tuple(meshes))
        self._holder = holder
        self._seeds = seeds
        corners = self._mesh.vertices
        self.box = np.stack([corners.min(axis=0), corners.max(axis=0)])
        self._objects: dict[float, tuple[Any, Any]] = {}

    def objects_at(self, scale: float) -> tuple[Any, Any]:
        """For FCL, in units of ``1 / scale`` metres: one that stays, one to be moved."""
        if scale not in self._objects:
            geometry = bvh_geometry(self._mesh.vertices * scale, self._mesh.faces)
            self._objects[scale] = _two_of(geometry)
        return self._objects[scale]

    def holds(self, other: _Side | _Ball, pose: FloatArray) -> bool:
        """Whether a component of the other, at ``pose`` in this one's frame, has its seed here."""
        return bool(self._holder.holds_any(other.seeds, pose))

    @property
    def seeds(self) -> FloatArray:
        """(k, 3): one point of every component."""
        return self._seeds


class _Ball:
    """A ball is its own inner and outer side; to FCL it is solid, so it needs no inside test."""

    def __init__(self, radius: float) -> None:
        self.radius = radius
        self.seeds = np.zeros((1, 3))
        self.box = np.array([[-radius] * 3, [radius] * 3])
        self._objects: dict[float, tuple[Any, Any]] = {}

    def objects_at(self, scale: float) -> tuple[Any, Any]:
        """For FCL, in units of ``1 / scale`` metres: one that stays, one to be moved."""
        import fcl

        if scale not in self._objects:
            self._objects[scale] = _two_of(fcl.Sphere(self.radius * scale))
        return self._objects[scale]

    def holds(self, other: _Side | _Ball, pose: FloatArray) -> bool:
        """Two balls are compared by FCL, everything else inside a ball as well."""
        return False


@dataclass(frozen=True)
class _Sides:
    outer: _Side | _Ball
    inner: _Side | _Ball | None
    exact: _Side | _Ball


class Bracket:
    """A solid between its inner and its outer hulls, ready to be asked.

    Attributes:
        diagonal: of the bounding box, metres.
    """

    def __init__(self, decomposition: Decomposition) -> None:
        """Bracket what a decomposition stands for.

        Computes :attr:`~assetpipe.Decomposition.inner`, which may take a second.

        Args:
            decomposition: of ``assetpipe.decompose``, at any level.

        Raises:
            UsageError: its hulls are not proved to cover the solid (other engines' are not).
        """
        if decomposition.coverage.proof != "construction":
            raise UsageError(
                f"hulls of engine '{decomposition.engine}' are not proved to cover the solid, "
                "so being clear of them proves nothing"
            )
        if decomposition.solid is None:
            raise UsageError("this decomposition has not kept its solid")
        self._build(decomposition.solid, decomposition.hulls, decomposition.inner)

    @classmethod
    def between(
        cls, solid: Mesh, *, outer: Sequence[ConvexShape], inner: Sequence[ConvexShape]
    ) -> Bracket:
        """A bracket of given sets. That inner ⊂ solid ⊂ outer is taken on trust.

        Args:
            solid: closed, wound outward, metres.
            outer: convex hulls whose union holds the solid.
            inner: convex hulls inside the solid; may be empty.

        Raises:
            MeshError: the solid is not closed, or there are no outer hulls.
        """
        made = cls.__new__(cls)
        made._build(solid, outer, inner)
        return made

    @classmethod
    def convex(cls, vertices: npt.ArrayLike) -> Bracket:
        """A convex probe: the hull of points (k, 3), metres; inner, outer and exact at once.

        Raises:
            MeshError: the points span no volume.
        """
        corners, faces = _core.convex_hull(np.ascontiguousarray(vertices, dtype=np.float64))
        hull = Mesh(corners, faces)
        made = cls.__new__(cls)
        made.diagonal = hull.diagonal
        outer = _hull_side([hull], made.diagonal * MARGIN)
        assert outer is not None  # noqa: S101 - moved outward, nothing is left out
        made._sides = _Sides(
            outer,
            _hull_side([hull], -made.diagonal * MARGIN),
            _solid_side(hull),
        )
        return made

    @classmethod
    def ball(cls, radius: float) -> Bracket:
        """A ball around its own origin, radius in metres.

        Raises:
            UsageError: the radius is not positive.
        """
        if not (radius > 0 and math.isfinite(radius)):
            raise UsageError(f"a ball's radius must be positive, not {radius}")
        made = cls.__new__(cls)
        made.diagonal = 2.0 * radius * math.sqrt(3.0)
        side = _Ball(radius)
        made._sides = _Sides(side, side, side)
        return made

    def _build(
        self, solid: Mesh, outer: Sequence[ConvexShape], inner: Sequence[ConvexShape]
    ) -> None:
        if not outer:
            raise MeshError("there are no outer hulls")
        self.diagonal: float = solid.diagonal
        margin = MARGIN * self.diagonal
        around = _hull_side([Mesh(h.vertices, h.faces) for h in outer], margin)
        assert around is not None  # noqa: S101 - moved outward, nothing is left out
        self._sides = _Sides(
            around,
            _hull_side([Mesh(h.vertices, h.faces) for h in inner], -margin),
            _solid_side(solid),
        )

    def answer(self, other: Bracket, self_from_other: npt.ArrayLike) -> Answer:
        """What the hulls alone prove about two bodies; the meshes are not asked.

        Args:
            other: the other body: a bracket, or a probe (:meth:`convex`, :meth:`ball`).
            self_from_other: (4, 4) rigid pose of the other in this one's frame, metres.

        Returns:
            ``"free"``: proved, the solids have no common point. ``"collision"``: proved,
            they have one. ``"undecided"``: neither; see :meth:`collides`.

        Raises:
            UsageError: the pose is no (4, 4) rigid matrix.
        """
        query = _Query(self_from_other, self._scale(other))
        mine, others = self._sides, other._sides
        if not query.touch(mine.outer, others.outer):
            return "free"
        if mine.inner and others.inner and query.touch(mine.inner, others.inner):
            return "collision"
        return "undecided"

    def collides(self, other: Bracket, self_from_other: npt.ArrayLike) -> bool:
        """Whether two solids have a common point: by proof, else from the meshes.

        Args:
            other: the other body.
            self_from_other: (4, 4) rigid pose of the other in this one's frame, metres.

        Raises:
            UsageError: the pose is no (4, 4) rigid matrix.
        """
        known = self.answer(other, self_from_other)
        if known != "undecided":
            return known == "collision"
        return self.meshes_touch(other, self_from_other)

    def meshes_touch(self, other: Bracket, self_from_other: npt.ArrayLike) -> bool:
        """The same from the meshes alone, surfaces and insides: what the hulls save."""
        query = _Query(self_from_other, self._scale(other))
        return query.touch(self._sides.exact, other._sides.exact)

    def _scale(self, other: Bracket) -> float:
        """FCL's units for this pair; powers of two, so that few are ever built."""
        return math.ldexp(1.0, round(math.log2(UNITS / max(self.diagonal, other.diagonal))))


class _Query:
    """A pose (4, 4) and its inverse; for FCL in units of ``1 / scale`` metres, once needed."""

    __slots__ = ("_a_from_b", "_b_from_a", "_placed", "_scale")

    def __init__(self, matrix: npt.ArrayLike, scale: float) -> None:
        self._a_from_b = np.ascontiguousarray(matrix, dtype=np.float64)
        self._b_from_a = _core.rigid_inverse(self._a_from_b)
        self._placed: Any = None
        self._scale = scale

    def touch(self, a: _Side | _Ball, b: _Side | _Ball) -> bool:
        """Whether two sets have a common point."""
        if _core.boxes_apart(a.box, b.box, self._a_from_b, self._b_from_a):
            return False
        import fcl

        if self._placed is None:
            turn = np.ascontiguousarray(self._a_from_b[:3, :3])
            self._placed = fcl.Transform(turn, self._a_from_b[:3, 3] * self._scale)
        first, second = a.objects_at(self._scale)[0], b.objects_at(self._scale)[1]
        second.setTransform(self._placed)
        if fcl.collide(first, second, _request(), fcl.CollisionResult()):
            return True
        return a.holds(b, self._a_from_b) or b.holds(a, self._b_from_a)


def _two_of(geometry: Any) -> tuple[Any, Any]:
    import fcl

    return fcl.CollisionObject(geometry), fcl.CollisionObject(geometry)


@cache
def _request() -> Any:
    import fcl

    return fcl.CollisionRequest()


def _hull_side(hulls: Sequence[Mesh], margin: float) -> _Side | None:
    """Hulls moved outward by ``margin`` (inward, where negative); those too thin are left out."""

    moved = [m for m in (_moved(h, margin) for h in hulls) if m is not None]
    if not moved:
        return None
    return _Side(
        moved,
        _core.ConvexSet([np.ascontiguousarray(m.vertices) for m in moved], margin),
        np.array([m.vertices.mean(axis=0) for m in moved]),
    )


def _moved(hull: Mesh, margin: float) -> Mesh | None:
    """The hull with every facet moved by at least ``margin``."""
    from assetpipe.validation.contact.surface import facet_planes

    centre = hull.vertices.mean(axis=0)
    normals, offsets = facet_planes(hull)
    depth = float((offsets - normals @ centre).min())
    if depth > 20.0 * abs(margin):
        scaled = centre + (hull.vertices - centre) * (1.0 + margin / depth)
        return Mesh(scaled, hull.faces)
    if margin < 0:
        return None
    cube = margin * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    corners = (hull.vertices[:, None, :] + cube).reshape(-1, 3)
    return Mesh(*_core.convex_hull(np.ascontiguousarray(corners)))


def _solid_side(solid: Mesh) -> _Side:

    index = _core.SolidIndex(
        np.ascontiguousarray(solid.vertices), np.ascontiguousarray(solid.faces)
    )
    return _Side([solid], index, np.ascontiguousarray(LinkBody("", (solid,)).seeds))
