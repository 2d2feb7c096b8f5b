"""A centred copy of unit size, so that micron parts and far origins behave alike."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from assetpipe.geometry.mesh import FloatArray
from assetpipe.geometry.products import length
from assetpipe.geometry.repair.rows import as_rows


def doublings(number: float) -> int:
    """Exponent of the least power of two that is no smaller than a positive number."""
    mantissa, exponent = math.frexp(number)
    return exponent - 1 if mantissa == 0.5 else exponent


@dataclass(frozen=True, eq=False)
class Frame:
    """Where the unit copy lies: ``unit = (point - origin) / scale``.

    ``scale`` is a power of two, so that scaling rounds nothing.

    Attributes:
        origin: (3,) metres.
        scale: metres a unit.
    """

    origin: FloatArray
    scale: float

    @classmethod
    def around(cls, vertices: FloatArray) -> Frame:
        """The frame in which ``vertices`` are centred and their diagonal is in (1/2, 1]."""
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        diagonal = length(high - low)
        scale = math.ldexp(1.0, doublings(diagonal)) if diagonal > 0.0 else 1.0
        return cls((low + high) / 2.0, scale)

    def inward(self, points: FloatArray) -> FloatArray:
        """Points in units."""
        result: FloatArray = (points - self.origin) / self.scale
        return result

    def outward(self, points: FloatArray) -> FloatArray:
        """Points in metres."""
        result: FloatArray = points * self.scale + self.origin
        return result

    def restored(self, points: FloatArray, originals: FloatArray) -> tuple[FloatArray, int]:
        """Points in metres, those that came from ``originals`` with their very bits.

        Args:
            points: (n, 3) in units, some of them ``inward(originals[i])`` unchanged.
            originals: (k, 3) metres.

        Returns:
            Points in metres, and how many are new.
        """
        known, first = np.unique(as_rows(self.inward(originals)), return_index=True)
        queried = as_rows(points)
        at = np.minimum(np.searchsorted(known, queried), len(known) - 1)
        same = known[at] == queried
        result = self.outward(points)
        result[same] = originals[first[at[same]]]
        return result, int((~same).sum())
