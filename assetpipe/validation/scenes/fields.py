"""What the numbers of a scene may look like: lengths with units, tolerances, switches."""

from __future__ import annotations

import re
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, PlainSerializer

from assetpipe.decomposition.tolerance import Tolerance
from assetpipe.errors import UsageError

_LENGTH = re.compile(r"\s*(-?[0-9.]+(?:[eE][+-]?[0-9]+)?)\s*(mm|cm|m)?\s*")
_METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, None: 1.0}


def _length(value: Any) -> Any:
    if isinstance(value, bool):
        raise ValueError("write a length, for example 2mm, 3cm or 0.5m")  # noqa: TRY004
    if not isinstance(value, str):
        return value
    match = _LENGTH.fullmatch(value)
    try:
        return float(match[1]) * _METRES[match[2]] if match else float(value)
    except ValueError as error:
        raise ValueError("write a number in mm, cm or m, for example 2mm or 0.002") from error


def _tolerance(value: Any) -> Any:
    if isinstance(value, bool) or not isinstance(value, str | int | float | Tolerance):
        raise ValueError("write a length or a share, for example 2mm or 1%")  # noqa: TRY004
    try:
        return Tolerance.parse(value)
    except UsageError as error:
        raise ValueError(error.message) from error


Finite = Annotated[float, Field(allow_inf_nan=False)]
Length = Annotated[float, BeforeValidator(_length), Field(allow_inf_nan=False)]
Positive = Annotated[float, BeforeValidator(_length), Field(gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, BeforeValidator(_length), Field(ge=0.0, allow_inf_nan=False)]
Vector = tuple[Length, Length, Length]
ToleranceField = Annotated[
    Tolerance, BeforeValidator(_tolerance), PlainSerializer(str, return_type=str)
]


class Frozen(BaseModel):
    """A value whose keys are all known."""

    model_config = ConfigDict(frozen=True, extra="forbid", arbitrary_types_allowed=True)
