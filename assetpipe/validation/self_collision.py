"""Self-collision: which pairs of links touch, before against after.

The core knows bodies and matrices only; where the matrices come from (forward
kinematics at home, sampled configurations, a scene) is the caller's business.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy.typing as npt

from assetpipe.errors import UsageError
from assetpipe.findings import NEGLIGIBLE, Finding, Severity
from assetpipe.validation.contact.pairs import LinkBody, Pair, PairQueries


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

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> PairChange:
        """From :meth:`as_dict`."""
        pair = _pair_of(data["pair"])
        return cls(pair, data["configurations"], data["first"], data["gap"], data["allowed"])


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

    @classmethod
    def of(cls, data: Mapping[str, Any]) -> SelfCollisions:
        """From :meth:`as_dict`."""
        kinds = ("excluded", "home_before", "home_after", "always_before", "never_before")
        return cls(
            configurations=data["configurations"],
            pairs=data["pairs"],
            **{kind: tuple(_pair_of(pair) for pair in data[kind]) for kind in kinds},
            new=tuple(PairChange.of(change) for change in data["new"]),
            vanished=tuple(PairChange.of(change) for change in data["vanished"]),
        )

    def findings(self) -> tuple[Finding, ...]:
        """New and vanished pairs as findings."""
        found = []
        for change in self.new:
            a, b = change.pair
            beyond = change.gap > change.allowed + 1e-7
            worth = Severity.WARNING if change.gap > NEGLIGIBLE * change.allowed else Severity.NOTE
            found.append(
                Finding(
                    "AP401" if beyond else "AP402",
                    Severity.ERROR if beyond else worth,
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


def _pair_of(names: Sequence[str]) -> Pair:
    a, b = names
    return (a, b)


def _pair(a: str, b: str) -> Pair:
    return (a, b) if a <= b else (b, a)


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
        old.place(matrices)
        new.place(matrices)
        for pair in asked:
            was = old.touch(pair)
            now = new.touch(pair)
            touching[pair] += was
            if count == 0:
                for side, yes in zip(home, (was, now), strict=True):
                    if yes:
                        side.append(pair)
            if was != now:
                kind = "new" if now else "vanished"
                gap = old.gap(pair) if now else new.gap(pair)
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
