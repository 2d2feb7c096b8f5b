"""What drives a scene: gravity, a path, a trajectory of joints, motors."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Annotated

from pydantic import Field, model_validator

from assetpipe.validation.scenes.fields import Finite, Frozen, Length, Vector


class Waypoint(Frozen):
    """A pose relative to the asset's own, and when it is reached (seconds)."""

    xyz: Vector = (0.0, 0.0, 0.0)
    rpy: tuple[Finite, Finite, Finite] = (0.0, 0.0, 0.0)
    at: Annotated[float, Field(gt=0.0, allow_inf_nan=False)]


class PathDrive(Frozen):
    """A driven asset follows waypoints, from its own pose at time 0, straight between them.

    Attributes:
        asset: which; its base is ``driven``.
        waypoints: in order of time.
        force: newtons that the drive can exert where it meets resistance.
    """

    asset: str
    waypoints: tuple[Waypoint, ...] = Field(min_length=1)
    force: Annotated[float, Field(gt=0.0, allow_inf_nan=False)] = 100.0

    @model_validator(mode="after")
    def _ordered(self) -> PathDrive:
        times = [w.at for w in self.waypoints]
        if any(b <= a for a, b in itertools.pairwise(times)):
            raise ValueError("waypoints must come in order of time, each later than the one before")
        return self


class TrajectoryDrive(Frozen):
    """Joints follow positions, evenly spread over ``seconds``, straight between them."""

    asset: str
    joints: Mapping[str, tuple[Length, ...]] = Field(min_length=1)
    seconds: Annotated[float, Field(gt=0.0, allow_inf_nan=False)]

    @model_validator(mode="after")
    def _even(self) -> TrajectoryDrive:
        counts = {name: len(values) for name, values in self.joints.items()}
        if len(set(counts.values())) != 1 or min(counts.values()) < 2:
            raise ValueError(f"every joint needs the same number of positions, 2 or more: {counts}")
        return self


class MotorDrive(Frozen):
    """Joints are held at, or driven to, target positions by motors."""

    targets: Mapping[str, Length] = Field(min_length=1)
    force: Annotated[float, Field(gt=0.0, allow_inf_nan=False)] | None = None


class Drive(Frozen):
    """What drives the scene; nothing by default.

    Attributes:
        gravity: m/s² downwards (along -z).
        path: a driven asset follows waypoints.
        trajectory: joints follow positions exactly (kinematically).
        motors: joints under motors, by asset.
    """

    gravity: Annotated[float, Field(ge=0.0, le=1000.0)] = 0.0
    path: PathDrive | None = None
    trajectory: TrajectoryDrive | None = None
    motors: Mapping[str, MotorDrive] = Field(default_factory=dict)
