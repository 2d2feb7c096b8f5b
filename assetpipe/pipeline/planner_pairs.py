"""Pairs of links that a planner need not ask, from a comparison of two robots."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from assetpipe.validation.srdf import DisabledPair


def planner_pairs(
    self_collision: Mapping[str, Any], links: Collection[str], whole: Collection[str]
) -> tuple[DisabledPair, ...]:
    """What :func:`assetpipe.validation.srdf.disabled_pairs` says, as far as it was asked.

    A comparison asks the elements of a link that differ. That two links never touched says
    nothing about elements that were not asked, so it is told of links that were asked whole;
    that they touch holds with more geometry, too.

    Args:
        self_collision: :meth:`assetpipe.validation.SelfCollisions.as_dict`.
        links: that have collision geometry; others need no entry.
        whole: those of which every element was asked.
    """
    from assetpipe.validation import SelfCollisions
    from assetpipe.validation.srdf import disabled_pairs

    found = disabled_pairs(SelfCollisions.of(self_collision), with_geometry=links)
    return tuple(p for p in found if p.reason != "Never" or set(p.pair) <= set(whole))
