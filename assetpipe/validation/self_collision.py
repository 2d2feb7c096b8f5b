"""Self-collision: which pairs of links touch, before against after.

The core knows bodies and matrices only; where the matrices come from (forward
kinematics at home, sampled configurations, a scene) is the caller's business.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Any

import numpy as np
import numpy.typing as npt

from assetpipe.errors import UsageError, unknown_name
from assetpipe.findings import Finding, Severity
from assetpipe.geometry.mesh import FloatArray, IntArray, Mesh
from assetpipe.validation.contact.surface import UNITS, bvh_geometry

Pair = tuple[str, str]


@dataclass(frozen=True, eq=False)
class LinkBody:
    """A link's collision geometry in its own frame.

    Attributes:
        link: name.
        shapes: closed meshes in the link's frame, metres: the original's shapes, or
            one mesh a hull. A link without shapes touches nothing.
        certificate: metres by which the shapes may reach beyond the original's; 0 for
            the original itself.
    """

    link: str
    shapes: tuple[Mesh, ...]
    certificate: float = 0.0

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
    def seeds(self) -> FloatArray:
        """(k, 3) one vertex of every connected component: tells whether it lies inside."""
        from scipy.sparse import coo_matrix
        from scipy.sparse.csgraph import connected_components

        merged, index = np.unique(self.vertices, axis=0, return_inverse=True)
        index = index.ravel()
        f = index[self.faces]
        rows, columns = np.hstack([f[:, 0], f[:, 1]]), np.hstack([f[:, 1], f[:, 2]])
        graph = coo_matrix((np.ones(len(rows)), (rows, columns)), shape=(len(merged),) * 2)
        _, label = connected_components(graph, directed=False)
        used = np.unique(f)
        _, first = np.unique(label[used], return_index=True)
        seeds: FloatArray = merged[used[first]]
        return seeds

    def contains(self, points: FloatArray) -> bool:
        """Whether any of the points (k, 3), link frame, lies inside the body."""
        import igl

        low, high = self.vertices.min(axis=0), self.vertices.max(axis=0)
        near = points[((points > low) & (points < high)).all(axis=1)]
        if not len(near):
            return False
        number = igl.fast_winding_number(self.vertices, self.faces, np.ascontiguousarray(near))
        return bool((np.asarray(number) > 0.5).any())


@dataclass(frozen=True)
class PairChange:
    """A pair whose answer differs.

    Attributes:
        pair: link names, sorted.
        configurations: in how many it differs.
        first: index of the first of them.
        gap: metres between the two in the answer that says "free": the largest over
            those configurations. For a new pair this must not exceed ``allowed``.
        allowed: metres, the two certificates together (the solids are that near).
    """

    pair: Pair
    configurations: int
    first: int
    gap: float
    allowed: float

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {
            "pair": list(self.pair),
            "configurations": self.configurations,
            "first": self.first,
            "gap": self.gap,
            "allowed": self.allowed,
        }


@dataclass(frozen=True)
class SelfCollisions:
    """Touching pairs before and after, over configurations.

    Attributes:
        configurations: how many were asked; the first is home.
        pairs: how many pairs were asked in each.
        excluded: pairs left out because they are adjacent (see :func:`adjacent_pairs`).
        home_before, home_after: pairs that touch in the first configuration.
        always_before: pairs that touch in every configuration.
        never_before: pairs that touch in none.
        new, vanished: pairs that touch only after, only before.
    """

    configurations: int
    pairs: int
    excluded: tuple[Pair, ...]
    home_before: tuple[Pair, ...]
    home_after: tuple[Pair, ...]
    always_before: tuple[Pair, ...]
    never_before: tuple[Pair, ...]
    new: tuple[PairChange, ...]
    vanished: tuple[PairChange, ...]

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {
            "configurations": self.configurations,
            "pairs": self.pairs,
            "excluded": [list(p) for p in self.excluded],
            "home_before": [list(p) for p in self.home_before],
            "home_after": [list(p) for p in self.home_after],
            "always_before": [list(p) for p in self.always_before],
            "never_before": [list(p) for p in self.never_before],
            "new": [c.as_dict() for c in self.new],
            "vanished": [c.as_dict() for c in self.vanished],
        }

    def findings(self) -> tuple[Finding, ...]:
        """New and vanished pairs as findings."""
        found = []
        for change in self.new:
            a, b = change.pair
            beyond = change.gap > change.allowed + 1e-7
            found.append(
                Finding(
                    "AP401" if beyond else "AP402",
                    Severity.ERROR if beyond else Severity.WARNING,
                    f"'{a}' and '{b}' touch in {change.configurations} of "
                    f"{self.configurations} configurations in which the originals are up to "
                    f"{change.gap * 1000:.3g} mm apart (allowed {change.allowed * 1000:.3g} mm)",
                    link=a,
                    hint="a smaller tolerance on these links keeps them apart",
                )
            )
        for change in self.vanished:
            a, b = change.pair
            found.append(
                Finding(
                    "AP403",
                    Severity.WARNING,
                    f"'{a}' and '{b}' touched in {change.configurations} of "
                    f"{self.configurations} configurations and no longer do; "
                    f"{change.gap * 1000:.3g} mm apart now",
                    link=a,
                )
            )
        return tuple(found)


def adjacent_pairs(joints: Iterable[tuple[str, str, str]]) -> tuple[Pair, ...]:
    """Pairs that no planner asks about: same rigid group, or groups joined by one joint.

    Links behind fixed joints move as one (what MoveIt and Bullet merge), so a pair is
    adjacent when its groups are the same or share a moving joint.

    Args:
        joints: (parent link, child link, joint type) of every joint.
    """
    joints = list(joints)
    group = {name: name for joint in joints for name in joint[:2]}

    def root(name: str) -> str:
        while group[name] != name:
            name = group[name]
        return name

    for parent, child, kind in joints:
        if kind == "fixed":
            group[root(child)] = root(parent)
    members: dict[str, list[str]] = {}
    for name in group:
        members.setdefault(root(name), []).append(name)
    pairs = {_pair(a, b) for names in members.values() for a, b in combinations(names, 2)}
    for parent, child, kind in joints:
        if kind != "fixed":
            pairs |= {_pair(a, b) for a in members[root(parent)] for b in members[root(child)]}
    return tuple(sorted(p for p in pairs if p[0] != p[1]))


def _pair(a: str, b: str) -> Pair:
    return (a, b) if a <= b else (b, a)


class PairQueries:
    """Contact and separation between the links of one robot (FCL, scaled units)."""

    def __init__(self, bodies: Sequence[LinkBody]) -> None:
        import fcl

        self._bodies = {b.link: b for b in bodies if b.shapes and len(b.faces)}
        radii = [b.ball[1] for b in self._bodies.values()]
        self._scale = UNITS / (2.0 * max(radii)) if radii and max(radii) > 0 else 1.0
        self._objects = {
            name: fcl.CollisionObject(bvh_geometry(b.vertices * self._scale, b.faces))
            for name, b in self._bodies.items()
        }

    @property
    def links(self) -> tuple[str, ...]:
        """Links with geometry, sorted."""
        return tuple(sorted(self._bodies))

    def place(self, world_from_link: Mapping[str, npt.ArrayLike]) -> dict[str, FloatArray]:
        """Move every link; the matrices (4, 4), metres."""
        import fcl

        placed = {}
        for name, item in self._objects.items():
            if name not in world_from_link:
                raise UsageError(unknown_name("link", name, world_from_link))
            matrix = np.asarray(world_from_link[name], dtype=np.float64)
            item.setTransform(fcl.Transform(matrix[:3, :3], matrix[:3, 3] * self._scale))
            placed[name] = matrix
        return placed

    def may_touch(self, pair: Pair, placed: Mapping[str, FloatArray]) -> bool:
        """Whether the bounding balls meet."""
        (ca, ra), (cb, rb) = (self._bodies[n].ball for n in pair)
        a, b = (placed[n] for n in pair)
        apart = (a[:3, :3] @ ca + a[:3, 3]) - (b[:3, :3] @ cb + b[:3, 3])
        return float(np.linalg.norm(apart)) <= ra + rb

    def touch(self, pair: Pair, placed: Mapping[str, FloatArray]) -> bool:
        """Whether the two solids have a point in common."""
        import fcl

        if not self.may_touch(pair, placed):
            return False
        result = fcl.CollisionResult()
        first, second = (self._objects[n] for n in pair)
        fcl.collide(first, second, fcl.CollisionRequest(), result)
        if result.is_collision:
            return True
        a, b = pair
        return self._holds(a, b, placed) or self._holds(b, a, placed)

    def gap(self, pair: Pair, placed: Mapping[str, FloatArray]) -> float:
        """Separation of the two surfaces, metres; 0 where they touch."""
        import fcl

        if self.touch(pair, placed):
            return 0.0
        first, second = (self._objects[n] for n in pair)
        result = fcl.DistanceResult()
        return max(0.0, float(fcl.distance(first, second, fcl.DistanceRequest(), result))) / (
            self._scale
        )

    def _holds(self, outer: str, inner: str, placed: Mapping[str, FloatArray]) -> bool:
        outer_from_inner = np.linalg.inv(placed[outer]) @ placed[inner]
        seeds = self._bodies[inner].seeds
        return self._bodies[outer].contains(
            seeds @ outer_from_inner[:3, :3].T + outer_from_inner[:3, 3]
        )


def self_collisions(
    before: Sequence[LinkBody],
    after: Sequence[LinkBody],
    configurations: Iterable[Mapping[str, npt.ArrayLike]],
    *,
    excluded: Iterable[Pair] = (),
) -> SelfCollisions:
    """Compare which pairs touch, configuration by configuration.

    Args:
        before: the original geometry, a body a link.
        after: what replaces it; the same links.
        configurations: ``world_from_link`` (4, 4) matrices by link; home first.
        excluded: pairs that are not asked, usually :func:`adjacent_pairs`.

    Raises:
        UsageError: no configuration, or one that lacks a link.
    """
    old, new = PairQueries(before), PairQueries(after)
    left_out = {_pair(a, b) for a, b in excluded}
    links = sorted(set(old.links) & set(new.links))
    asked = [p for p in combinations(links, 2) if p not in left_out]
    certificates = {b.link: b.certificate for b in after}
    touching: dict[Pair, int] = dict.fromkeys(asked, 0)
    changes: dict[tuple[str, Pair], list[tuple[int, float]]] = {}
    home: tuple[list[Pair], list[Pair]] = ([], [])
    count = 0
    for matrices in configurations:
        was_placed, is_placed = old.place(matrices), new.place(matrices)
        for pair in asked:
            was = old.touch(pair, was_placed)
            now = new.touch(pair, is_placed)
            touching[pair] += was
            if count == 0:
                for side, yes in zip(home, (was, now), strict=True):
                    if yes:
                        side.append(pair)
            if was != now:
                kind = "new" if now else "vanished"
                gap = old.gap(pair, was_placed) if now else new.gap(pair, is_placed)
                changes.setdefault((kind, pair), []).append((count, gap))
        count += 1
    if count == 0:
        raise UsageError("self-collision needs at least one configuration")

    def changed(kind: str) -> tuple[PairChange, ...]:
        return tuple(
            PairChange(
                pair,
                len(seen),
                seen[0][0],
                max(gap for _, gap in seen),
                certificates.get(pair[0], 0.0) + certificates.get(pair[1], 0.0),
            )
            for (which, pair), seen in sorted(changes.items())
            if which == kind
        )

    return SelfCollisions(
        configurations=count,
        pairs=len(asked),
        excluded=tuple(sorted(left_out)),
        home_before=tuple(home[0]),
        home_after=tuple(home[1]),
        always_before=tuple(p for p in asked if touching[p] == count),
        never_before=tuple(p for p in asked if touching[p] == 0),
        new=changed("new"),
        vanished=changed("vanished"),
    )
