"""Certified intervals: what is proved about a hull, in metres."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Interval:
    """``[lower, upper]`` in metres, which provably holds the true value."""

    lower: float
    upper: float

    def as_dict(self) -> dict[str, float]:
        """JSON-ready."""
        return {"lower": self.lower, "upper": self.upper}


@dataclass(frozen=True)
class Certificate:
    """What is proved about one hull, or about all hulls of a decomposition.

    Attributes:
        thickening: sup over the hull's points q of d(q, solid): how far the hull
            reaches into free space. Towards the *whole* solid: what a user cares about.
        concavity: Eq. 4 of Wei et al. 2022 between the hull and its *part*:
            max(H_b, H_i). ``None`` for hulls that have no part (other engines).
    """

    thickening: Interval
    concavity: Interval | None

    @property
    def lower(self) -> float:
        """Lower bound of the thickening, metres."""
        return self.thickening.lower

    @property
    def upper(self) -> float:
        """Upper bound of the thickening, metres."""
        return self.thickening.upper

    def as_dict(self) -> dict[str, object]:
        """JSON-ready."""
        return {
            "thickening": self.thickening.as_dict(),
            "concavity": self.concavity.as_dict() if self.concavity else None,
        }
