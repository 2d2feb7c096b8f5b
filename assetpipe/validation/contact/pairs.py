"""Contact and separation between placed links: exact, in scaled units, inside included."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from assetpipe.errors import UsageError, unknown_name
from assetpipe.geometry.mesh import FloatArray, IntArray, Mesh
from assetpipe.validation.contact.surface import UNITS, bvh_geometry, facet_planes

Pair = tuple[str, str]
"""Two link names."""


@dataclass(frozen=True, eq=False)
class LinkBody:
    """A link's collision geometry in its own frame.

    Attributes:
        link: name.
        shapes: closed meshes in the link's frame, metres: the original's shapes, or
            one mesh a hull. A link without shapes touches nothing.
        certificate: metres by which the shapes may reach beyond the original's; 0 for
            the original itself.
        kind: ``hulls`` where every shape is convex: what is inside is then decided by
            facets instead of winding numbers, which is exact and much cheaper.
    """

    link: str
    shapes: tuple[Mesh, ...]
    certificate: float = 0.0
    kind: Literal["surface", "hulls"] = "surface"

    @cached_property
    def vertices(self) -> FloatArray:
        """(n, 3) of all shapes."""
        if not self.shapes:
            return np.zeros((0, 3))
        return np.vstack([m.vertices for m in self.shapes])

    @cached_property
    def faces(self) -> IntArray:
        """(m, 3) of all shapes, into :attr:`vertices`."""
        if not self.shapes:
            return np.zeros((0, 3), dtype=np.int64)
        starts = np.cumsum([0, *(len(m.vertices) for m in self.shapes[:-1])])
        return np.vstack([m.faces + s for m, s in zip(self.shapes, starts, strict=True)])

    @cached_property
    def ball(self) -> tuple[FloatArray, float]:
        """Centre (3,) and radius of a ball around the body, link frame."""
        low, high = self.vertices.min(axis=0), self.vertices.max(axis=0)
        centre = (low + high) / 2.0
        return centre, float(np.linalg.norm(self.vertices - centre, axis=1).max())

    @cached_property
    def witnesses(self) -> FloatArray:
        """(k, 6, 3) six far vertices of every connected component.

        Of surfaces that do not meet, a component lies inside another body wholly or not at
        all: one vertex tells, and one outside the other's box tells that it does not.
        """
        if self.kind == "hulls":
            return np.array([_far(m.vertices[np.unique(m.faces)]) for m in self.shapes])
        from scipy.sparse import coo_matrix
        from scipy.sparse.csgraph import connected_components

        merged, index = np.unique(self.vertices, axis=0, return_inverse=True)
        index = index.ravel()
        f = index[self.faces]
        rows, columns = np.hstack([f[:, 0], f[:, 1]]), np.hstack([f[:, 1], f[:, 2]])
        graph = coo_matrix((np.ones(len(rows)), (rows, columns)), shape=(len(merged),) * 2)
        _, label = connected_components(graph, directed=False)
        used = np.unique(f)
        used = used[np.argsort(label[used], kind="stable")]
        starts = np.flatnonzero(np.diff(label[used], prepend=-1))
        return np.array([_far(merged[part]) for part in np.split(used, starts[1:])])

    @property
    def seeds(self) -> FloatArray:
        """(k, 3) one vertex of every connected component: tells whether it lies inside."""
        seeds: FloatArray = self.witnesses[:, 0]
        return seeds

    @cached_property
    def _bounds(self) -> tuple[FloatArray, FloatArray]:
        return self.vertices.min(axis=0), self.vertices.max(axis=0)

    @cached_property
    def box(self) -> tuple[FloatArray, FloatArray]:
        """Centre (3,) and half extents (3,) of the body's box, link frame."""
        low, high = self._bounds
        return (low + high) / 2.0, (high - low) / 2.0

    @cached_property
    def _boxes(self) -> tuple[FloatArray, FloatArray]:
        """Lower and upper corners (h, 3) of every hull's box."""
        return (
            np.array([m.vertices.min(axis=0) for m in self.shapes]),
            np.array([m.vertices.max(axis=0) for m in self.shapes]),
        )

    @cached_property
    def _planes(self) -> list[tuple[FloatArray, FloatArray]]:
        return [facet_planes(m) for m in self.shapes]

    def contains(self, points: FloatArray) -> bool:
        """Whether any of the components with these witnesses (k, 6, 3), link frame, of which
        none crosses the body's surface, lies inside the body."""
        low, high = self._bounds
        near = points[((points > low) & (points < high)).all(axis=(1, 2)), 0]
        if not len(near):
            return False
        if self.kind == "hulls":
            lows, highs = self._boxes
            above, below = near[:, None, :] > lows, near[:, None, :] < highs
            inside = np.logical_and.reduce(above & below, axis=2)
            # Few points lie in the box of few hulls; only those ask the facets.
            for hull in np.flatnonzero(inside.any(axis=0)):
                normals, offsets = self._planes[hull]
                heights = near[inside[:, hull]] @ normals.T - offsets
                if bool((heights.max(axis=1) < 0.0).any()):
                    return True
            return False
        import igl

        number = igl.fast_winding_number(self.vertices, self.faces, np.ascontiguousarray(near))
        return bool((np.asarray(number) > 0.5).any())


def _far(points: FloatArray) -> FloatArray:
    """(6, 3) the points (n, 3) that lie farthest along each axis, both ways."""
    found: FloatArray = points[np.concatenate([points.argmin(axis=0), points.argmax(axis=0)])]
    return found


class PairQueries:
    """Links of one robot, or of a scene: placed, then asked pair by pair."""

    def __init__(self, bodies: Sequence[LinkBody]) -> None:
        self._bodies = {b.link: b for b in bodies if b.shapes and len(b.faces)}
        self._balls = {name: b.ball for name, b in self._bodies.items()}
        radii = [radius for _, radius in self._balls.values()]
        self._scale = UNITS / (2.0 * max(radii)) if radii and max(radii) > 0 else 1.0
        self._objects: dict[str, Any] = {}
        self._stale: set[str] = set()
        self._placed: dict[str, FloatArray] = {}
        self._centres: dict[str, list[float]] = {}

    @property
    def links(self) -> tuple[str, ...]:
        """Links with geometry, sorted."""
        return tuple(sorted(self._bodies))

    def place(self, world_from_link: Mapping[str, npt.ArrayLike]) -> None:
        """Move every link.

        Args:
            world_from_link: matrices (4, 4) by link, metres.

        Raises:
            UsageError: a link has no matrix.
        """
        for name in self._bodies:
            if name not in world_from_link:
                raise UsageError(unknown_name("link", name, world_from_link))
            self._put(name, np.asarray(world_from_link[name], dtype=np.float64))

    def _put(self, name: str, matrix: FloatArray) -> None:
        turn, at = matrix[:3, :3], matrix[:3, 3]
        self._stale.add(name)
        self._placed[name] = matrix
        self._centres[name] = (turn @ self._balls[name][0] + at).tolist()

    def _object(self, name: str) -> Any:
        """The link for FCL where it is now; trees are built once somebody asks."""
        import fcl

        if name not in self._objects:
            body = self._bodies[name]
            geometry = bvh_geometry(body.vertices * self._scale, body.faces)
            self._objects[name] = fcl.CollisionObject(geometry)
        if name in self._stale:
            self._stale.discard(name)
            matrix = self._placed[name]
            moved = fcl.Transform(matrix[:3, :3], matrix[:3, 3] * self._scale)
            self._objects[name].setTransform(moved)
        return self._objects[name]

    def may_touch(self, pair: Pair) -> bool:
        """Whether the bounding balls meet."""
        a, b = pair
        reach = self._balls[a][1] + self._balls[b][1]
        return math.dist(self._centres[a], self._centres[b]) <= reach

    def touch(self, pair: Pair) -> bool:
        """Whether the two solids have a point in common."""
        import fcl

        if not self.may_touch(pair):
            return False
        result = fcl.CollisionResult()
        a, b = pair
        fcl.collide(self._object(a), self._object(b), fcl.CollisionRequest(), result)
        return bool(result.is_collision) or self._holds(a, b) or self._holds(b, a)

    def touching(
        self, pairs: Sequence[Pair], world_from_link: Mapping[str, FloatArray]
    ) -> dict[Pair, npt.NDArray[np.bool_]]:
        """Whether pairs touch, in many configurations at once: bounding balls sort out most.

        Args:
            pairs: of links.
            world_from_link: matrices (n, 4, 4) by link, metres.

        Returns:
            (n,) answers by pair; a pair of which one has no geometry touches nowhere.
        """
        count = len(next(iter(world_from_link.values())))
        centres = {
            name: world_from_link[name][:, :3, :3] @ centre + world_from_link[name][:, :3, 3]
            for name, (centre, _) in self._balls.items()
        }
        answers = {pair: np.zeros(count, dtype=bool) for pair in pairs}
        for pair, answer in answers.items():
            if any(name not in self._balls for name in pair):
                continue
            a, b = pair
            reach = self._balls[a][1] + self._balls[b][1]
            near = np.flatnonzero(np.linalg.norm(centres[a] - centres[b], axis=1) <= reach)
            placed = world_from_link[a][near], world_from_link[b][near]
            for index in near[self._boxes_meet(pair, *placed)]:
                for name in pair:
                    self._put(name, world_from_link[name][index])
                answer[index] = self.touch(pair)
        return answers

    def _boxes_meet(
        self, pair: Pair, first: FloatArray, second: FloatArray
    ) -> npt.NDArray[np.bool_]:
        """Whether no face of either link's box separates the boxes; (n, 4, 4) each."""
        meet = np.ones(len(first), dtype=bool)
        for name, other, mine, theirs in (
            (pair[0], pair[1], first, second),
            (pair[1], pair[0], second, first),
        ):
            (centre, half), (away, size) = (self._bodies[n].box for n in (name, other))
            back = np.swapaxes(mine[:, :3, :3], 1, 2)
            turn = back @ theirs[:, :3, :3]
            shift = (back @ (theirs[:, :3, 3] - mine[:, :3, 3])[:, :, None])[:, :, 0]
            between = np.abs(turn @ away + shift - centre)
            # Rounding must not separate what touches.
            meet &= (between <= (half + np.abs(turn) @ size) * (1.0 + 1e-9) + 1e-12).all(axis=1)
        return meet

    def gap(self, pair: Pair) -> float:
        """Separation of the two solids, metres; 0 where they touch."""
        apart = self.surface_gap(pair)
        if apart == 0.0 or not self.may_touch(pair):
            return apart
        a, b = pair
        return 0.0 if self._holds(a, b) or self._holds(b, a) else apart

    def surface_gap(self, pair: Pair) -> float:
        """Distance of the two surfaces, metres: positive also where one is wholly inside."""
        import fcl

        result = fcl.DistanceResult()
        first, second = (self._object(n) for n in pair)
        apart = float(fcl.distance(first, second, fcl.DistanceRequest(), result))
        return max(0.0, apart) / self._scale

    def _holds(self, outer: str, inner: str) -> bool:
        witnesses = self._bodies[inner].witnesses
        mine, other = self._placed[outer], self._placed[inner]
        world = witnesses @ other[:3, :3].T + other[:3, 3]
        return self._bodies[outer].contains((world - mine[:3, 3]) @ mine[:3, :3])
