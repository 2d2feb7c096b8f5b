"""Tolerances: how much thicker a hull may make the shape."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from assetpipe.errors import UsageError
from assetpipe.geometry import Mesh

_UNITS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6}
_PATTERN = re.compile(r"^\s*([0-9.]+(?:[eE][+-]?[0-9]+)?)\s*(%|m|cm|mm|um|µm)\s*$")


@dataclass(frozen=True)
class Tolerance:
    """A tolerance before it meets a mesh.

    Attributes:
        value: positive number.
        unit: ``"metres"``; ``"relative"`` to the bounding box's diagonal; or
            ``"coacd"``, relative to half the longest bounding-box side, which is
            the unit of CoACD's ``threshold``.
    """

    value: float
    unit: Literal["metres", "relative", "coacd"]

    def __post_init__(self) -> None:
        if not (0.0 < self.value < float("inf")):
            raise UsageError(f"tolerance must be a positive, finite number, not {self.value}")

    @classmethod
    def metres(cls, value: float) -> Tolerance:
        """An absolute tolerance in metres."""
        return cls(float(value), "metres")

    @classmethod
    def relative(cls, value: float) -> Tolerance:
        """A fraction of the bounding box's diagonal."""
        return cls(float(value), "relative")

    @classmethod
    def coacd(cls, threshold: float) -> Tolerance:
        """CoACD's ``threshold``: a fraction of half the longest bounding-box side."""
        return cls(float(threshold), "coacd")

    @classmethod
    def parse(cls, text: str | float | Tolerance) -> Tolerance:
        """Read ``2mm``, ``0.5cm``, ``0.002m`` or ``1%``; a bare number means metres.

        Raises:
            UsageError: anything else.
        """
        if isinstance(text, Tolerance):
            return text
        if isinstance(text, int | float):
            return cls.metres(text)
        match = _PATTERN.match(text)
        if match is None:
            raise UsageError(
                f"tolerance '{text}' is not a length or a share; write for example "
                "2mm, 0.5cm, 0.002m or 1% (of the bounding box's diagonal)"
            )
        try:
            number = float(match[1])
        except ValueError as error:
            raise UsageError(f"tolerance '{text}': '{match[1]}' is not a number") from error
        if match[2] == "%":
            return cls.relative(number / 100.0)
        return cls.metres(number * _UNITS[match[2]])

    def on(self, mesh: Mesh) -> float:
        """The tolerance in metres on this mesh."""
        if self.unit == "metres":
            return self.value
        if self.unit == "relative":
            return self.value * mesh.diagonal
        sides = mesh.bounds[1] - mesh.bounds[0]
        return self.value * 0.5 * float(sides.max())

    def __str__(self) -> str:
        if self.unit == "metres":
            return f"{self.value * 1000:g} mm"
        if self.unit == "relative":
            return f"{self.value * 100:g}%"
        return f"coacd {self.value:g}"
