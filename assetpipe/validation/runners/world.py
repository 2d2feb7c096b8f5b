"""Every link of every asset for queries: contact, distance, and where it is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from assetpipe.geometry.mesh import FloatArray
from assetpipe.validation.contact.pairs import LinkBody, Pair, PairQueries

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
        links = [(ref, assets[ref[0]].link[ref[1]]) for ref in sorted(refs)]
        self._queries = PairQueries(
            [LinkBody(key(ref), link.shapes, kind=link.kind) for ref, link in links]
        )

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
        self._queries.place(frames)

    def place_links(self, frames: Mapping[str, FloatArray]) -> None:
        """Move everything; world-from-link matrices (4, 4) by :func:`key`."""
        self._queries.place(frames)

    def touching(
        self, pairs: Sequence[tuple[Ref, Ref]], frames: Mapping[str, FloatArray]
    ) -> dict[tuple[Ref, Ref], npt.NDArray[np.bool_]]:
        """Whether pairs touch: (n,) answers for world-from-link matrices (n, 4, 4) by
        :func:`key`."""
        found = self._queries.touching([_pair(a, b) for a, b in pairs], frames)
        return {(a, b): found[_pair(a, b)] for a, b in pairs}

    def touch(self, a: Ref, b: Ref) -> bool:
        """Whether two links have a point in common."""
        return self._queries.touch(_pair(a, b))

    def gap(self, a: Ref, b: Ref) -> float:
        """Separation in metres; 0 in contact."""
        return self._queries.gap(_pair(a, b))

    def surface_gap(self, a: Ref, b: Ref) -> float:
        """Distance of the surfaces in metres; positive also where one is wholly inside."""
        return self._queries.surface_gap(_pair(a, b))


def _pair(a: Ref, b: Ref) -> Pair:
    return key(a), key(b)
