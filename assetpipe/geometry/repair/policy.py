"""What repair may do, and within which limits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from assetpipe.errors import UsageError, unknown_name
from assetpipe.geometry.mesh import Mesh

Mode = Literal["auto", "strict", "off"]
BudgetUnit = Literal["share", "metres"]
Cavities = Literal["keep", "fill"]
Openings = Literal["auto", "fill", "sheet", "refuse"]


@dataclass(frozen=True)
class RepairPolicy:
    """What repair may do to make a mesh a solid.

    Attributes:
        mode: ``"auto"`` climbs the whole ladder. ``"strict"`` takes only steps that neither
            move the surface nor guess: exact weld, orientation, splitting, union.
            ``"off"`` changes nothing: a mesh that is no solid is a finding.
        budget: how far a step may move the surface before it is a finding instead.
        budget_unit: ``"share"`` of the bounding box's diagonal, or ``"metres"``.
        cavities: what becomes of enclosed voids, ``"keep"`` or ``"fill"``.
        openings: what becomes of openings whose cap would lie farther from the surface
            than the budget. ``"auto"`` closes those that are minor (hold less than 1% of
            their piece's area) and gives the surface around others a thickness, with a
            finding; ``"sheet"`` does so for all; ``"fill"`` closes all; ``"refuse"``
            makes the mesh a finding.
        thickness: of open sheets, metres; ``None`` means a quarter of the budget.
    """

    mode: Mode = "auto"
    budget: float = 0.01
    budget_unit: BudgetUnit = "share"
    cavities: Cavities = "keep"
    openings: Openings = "auto"
    thickness: float | None = None

    def __post_init__(self) -> None:
        for kind, value, allowed in (
            ("mode", self.mode, Mode),
            ("budget_unit", self.budget_unit, BudgetUnit),
            ("cavities", self.cavities, Cavities),
            ("openings", self.openings, Openings),
        ):
            if value not in get_args(allowed):
                raise UsageError(unknown_name(f"repair {kind}", str(value), get_args(allowed)))
        if not 0.0 <= self.budget < float("inf"):
            raise UsageError(f"repair budget must be finite and not negative, not {self.budget}")
        if self.thickness is not None and not 0.0 < self.thickness < float("inf"):
            raise UsageError(f"sheet thickness must be positive and finite, not {self.thickness}")

    def budget_on(self, mesh: Mesh) -> float:
        """The budget in metres on this mesh."""
        return self.budget * (mesh.diagonal if self.budget_unit == "share" else 1.0)

    def thickness_on(self, mesh: Mesh) -> float:
        """The thickness of sheets in metres on this mesh."""
        return self.thickness if self.thickness is not None else self.budget_on(mesh) / 4.0


@dataclass(frozen=True)
class RepairLimits:
    """Bounds on the work; exceeding one is a finding, never a hang.

    Attributes:
        faces: of the input.
        cells: of the grid on which soups become solids.
        seconds: after which no further step begins.
    """

    faces: int = 2_000_000
    cells: int = 8_000_000
    seconds: float = 60.0
