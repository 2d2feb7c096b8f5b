"""Names of what may be chosen, and the search's parameters for experiments."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal

Metric = Literal["thickening", "concavity"]
Effort = Literal["fast", "balanced", "best"]
Cavities = Literal["keep", "fill"]

METRICS: tuple[Metric, ...] = ("thickening", "concavity")
EFFORTS: tuple[Effort, ...] = ("fast", "balanced", "best")
CAVITIES: tuple[Cavities, ...] = ("keep", "fill")


@dataclass(frozen=True)
class Params:
    """Parameters of the search by name, beyond what ``effort`` sets: for ablations.

    Not part of the stable interface: names and meanings follow the engine
    (``docs/engine.md`` lists them) and may change with any version.

    Attributes:
        search: parameter name → value, for example ``{"policy": "greedy", "planes": 10}``.
    """

    search: Mapping[str, str | float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "search", MappingProxyType(dict(self.search)))
