"""Every link of every asset for queries: contact, distance, and where it is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy.typing as npt

from assetpipe.geometry.mesh import FloatArray
from assetpipe.validation.self_collision import LinkBody, Pair, PairQueries

if TYPE_CHECKING:
    from assetpipe.validation.effects.plan import Ref
    from assetpipe.validation.scenes.assets import SceneAsset


def key(ref: Ref) -> str:
    """The name of a link among all assets."""
    return f"{ref[0]}/{ref[1]}"


class QueryWorld:
    """Links of some assets, asked pair by pair (FCL); nothing is simulated."""

    def __init__(self, assets: Mapping[str, SceneAsset], refs: set[Ref]) -> None:
        self._assets = assets
        bodies = [LinkBody(key(ref), assets[ref[0]].link[ref[1]].shapes) for ref in sorted(refs)]
        self._queries = PairQueries(bodies)
        self._placed: dict[str, FloatArray] = {}

    def place(
        self,
        positions: Mapping[str, Mapping[str, float]] | None = None,
        bases: Mapping[str, npt.ArrayLike] | None = None,
    ) -> None:
        """Move everything.

        Args:
            positions: joint positions by asset; others stay at their start.
            bases: world-from-base matrices (4, 4) by asset; others stay where they are.
        """
        frames: dict[str, FloatArray] = {}
        for name, asset in self._assets.items():
            at = asset.frames((positions or {}).get(name), (bases or {}).get(name))
            frames |= {key((name, link)): matrix for link, matrix in at.items()}
        self._placed = self._queries.place(frames)

    def touch(self, a: Ref, b: Ref) -> bool:
        """Whether two links have a point in common."""
        return self._queries.touch(_pair(a, b), self._placed)

    def gap(self, a: Ref, b: Ref) -> float:
        """Separation in metres; 0 in contact."""
        return self._queries.gap(_pair(a, b), self._placed)


def _pair(a: Ref, b: Ref) -> Pair:
    return key(a), key(b)
