"""What repair did: steps, measured deviations and the solid."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import Any, Literal

from assetpipe.findings import Finding
from assetpipe.geometry.mesh import Mesh
from assetpipe.geometry.products import added


class Rung(Enum):
    """The steps of the ladder, the gentlest first."""

    WELD = "weld"
    ORIENT = "orient"
    CLEAN = "clean"
    STITCH = "stitch"
    SPLIT = "split"
    UNTANGLE = "untangle"
    UNITE = "unite"
    FILL = "fill"
    WINDING = "winding"
    SHEET = "sheet"


@dataclass(frozen=True)
class Deviation:
    """How far one surface lies from another, metres.

    ``removed`` looks from the old surface: the distance of its points to the new solid,
    zero for what lies inside. ``added`` looks from the new surface to the old one.

    Attributes:
        removed: an upper bound on the largest such distance.
        added: an upper bound on the largest such distance.
        removed_p99: 99th percentile over the area (fixed sample).
        added_p99: 99th percentile over the area (fixed sample).
        proof: ``"exact"``: nothing moved; ``"bound"``: ``removed`` and ``added`` hold for
            every point of the surface, by displacement or branch and bound.
    """

    removed: float = 0.0
    added: float = 0.0
    removed_p99: float = 0.0
    added_p99: float = 0.0
    proof: Literal["exact", "bound"] = "exact"

    @property
    def largest(self) -> float:
        """The larger of both directions, metres."""
        return max(self.removed, self.added)

    @property
    def p99(self) -> float:
        """The larger of both 99th percentiles, metres."""
        return max(self.removed_p99, self.added_p99)

    @classmethod
    def displacement(cls, distance: float) -> Deviation:
        """No point moved farther than ``distance``."""
        if distance == 0.0:
            return cls()
        return cls(distance, distance, distance, distance, "bound")

    def plus(self, other: Deviation) -> Deviation:
        """Both, one after the other (triangle inequality)."""
        return Deviation(
            self.removed + other.removed,
            self.added + other.added,
            self.removed_p99 + other.removed_p99,
            self.added_p99 + other.added_p99,
            "exact" if self.proof == other.proof == "exact" else "bound",
        )

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready, metres."""
        return {
            "removed": self.removed,
            "added": self.added,
            "removed_p99": self.removed_p99,
            "added_p99": self.added_p99,
            "proof": self.proof,
        }


@dataclass(frozen=True)
class Step:
    """One step that was taken.

    Attributes:
        rung: which.
        what: one sentence.
        moved: upper bound in metres on how far it moved the surface, either way.
        volume_change: m³ that it added (negative: removed), where both states enclose
            a volume; ``None`` where the state before enclosed none.
        seconds: processor time; not part of :meth:`as_dict`, which is reproducible.
    """

    rung: Rung
    what: str
    moved: float = 0.0
    volume_change: float | None = 0.0
    seconds: float = field(default=0.0, compare=False)

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {
            "rung": self.rung.value,
            "what": self.what,
            "moved": self.moved,
            "volume_change": self.volume_change,
        }


@dataclass(frozen=True)
class Repaired:
    """A mesh made a solid, or the reason why not.

    Attributes:
        solid: closed, outward, every edge with exactly two faces; ``None`` if the mesh
            could not be made one within the policy.
        steps: what was done, in order; empty for a mesh that was a solid already.
        deviation: between the input's surface and the solid's, both ways.
        findings: what the user should know; an error among them if ``solid`` is None.
        cavities: enclosed voids that were kept, and filled.
        notes: what else is worth saying.
    """

    solid: Mesh | None
    steps: tuple[Step, ...] = ()
    deviation: Deviation = Deviation()
    findings: tuple[Finding, ...] = ()
    cavities_kept: int = 0
    cavities_filled: int = 0
    notes: tuple[str, ...] = ()

    @property
    def moved(self) -> float:
        """Upper bound in metres on how far the surface moved, either way."""
        return self.deviation.largest

    @property
    def rung(self) -> Rung | None:
        """The highest rung that was needed; ``None`` if none was."""
        order = list(Rung)
        return max((step.rung for step in self.steps), key=order.index, default=None)

    @property
    def volume_change(self) -> float:
        """m³ that the steps added to the enclosed volume, as far as it was defined."""
        return added(step.volume_change or 0.0 for step in self.steps)

    @property
    def seconds(self) -> float:
        """Processor time of all steps."""
        return sum(step.seconds for step in self.steps)

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready and reproducible: lengths in metres, no times."""
        return {
            "solid": self.solid is not None,
            "rung": self.rung.value if self.rung else None,
            "moved": self.moved,
            "deviation": self.deviation.as_dict(),
            "volume_change": self.volume_change,
            "cavities_kept": self.cavities_kept,
            "cavities_filled": self.cavities_filled,
            "steps": [step.as_dict() for step in self.steps],
            "findings": [finding.as_dict() for finding in self.findings],
            "notes": list(self.notes),
        }
