"""Rates and distributions that say how sure they are."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

Z_95 = 1.959963984540054
"""Two-sided 95% quantile of the normal distribution."""


@dataclass(frozen=True)
class Rate:
    """A share of yes-answers with its 95% confidence interval.

    The interval is Wilson's (1927) score interval, which stays inside [0, 1] and is
    honest for counts of zero: none in 100 still allows 3.7%.

    Attributes:
        count: how many were yes.
        of: how many were asked.
        low, high: ends of the interval; (0, 1) where nothing was asked.
    """

    count: int
    of: int
    low: float
    high: float

    @classmethod
    def wilson(cls, count: int, of: int) -> Rate:
        """The rate ``count / of`` with its interval."""
        if not 0 <= count <= of:
            raise ValueError(f"count {count} is not between 0 and {of}")
        if of == 0:
            return cls(0, 0, 0.0, 1.0)
        p, z2 = count / of, Z_95 * Z_95
        centre = (p + z2 / (2 * of)) / (1 + z2 / of)
        half = Z_95 / (1 + z2 / of) * math.sqrt(p * (1 - p) / of + z2 / (4 * of * of))
        low = 0.0 if count == 0 else max(0.0, centre - half)
        high = 1.0 if count == of else min(1.0, centre + half)
        return cls(count, of, low, high)

    @property
    def value(self) -> float:
        """``count / of``; 0 where nothing was asked."""
        return self.count / self.of if self.of else 0.0

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {
            "count": self.count,
            "of": self.of,
            "rate": self.value,
            "interval_95": [self.low, self.high],
        }

    def __str__(self) -> str:
        return f"{self.count}/{self.of} [{self.low:.1%}, {self.high:.1%}]"


@dataclass(frozen=True)
class Distribution:
    """Quantiles of a signed quantity; all zero where there are no samples.

    Attributes:
        samples: how many values.
        p50, p95: quantiles of the *absolute* values.
        worst: the value with the largest absolute value, with its sign.
        least, greatest: smallest and largest signed value.
    """

    samples: int
    p50: float
    p95: float
    worst: float
    least: float
    greatest: float

    @classmethod
    def over(cls, values: npt.ArrayLike) -> Distribution:
        """The distribution of an array of numbers."""
        array = np.asarray(values, dtype=np.float64).ravel()
        if not array.size:
            return cls(0, 0.0, 0.0, 0.0, 0.0, 0.0)
        size = np.abs(array)
        return cls(
            samples=int(array.size),
            p50=float(np.quantile(size, 0.5)),
            p95=float(np.quantile(size, 0.95)),
            worst=float(array[int(np.argmax(size))]),
            least=float(array.min()),
            greatest=float(array.max()),
        )

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {
            "samples": self.samples,
            "p50": self.p50,
            "p95": self.p95,
            "worst": self.worst,
            "least": self.least,
            "greatest": self.greatest,
        }
