"""What a build is asked to do: a frozen, validated value.

Every field is checked when it is made, in Python as in YAML, and an error names
the key, its line, and what would have been allowed.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, cast

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainSerializer,
    ValidationError,
    model_validator,
)

from assetpipe.decomposition.tolerance import Tolerance
from assetpipe.errors import ConfigError, UsageError
from assetpipe.schema import explain, load_yaml
from assetpipe.shipped import find_config

Source = Literal["collision", "visual"]
Metric = Literal["thickening", "concavity"]
Effort = Literal["fast", "balanced", "best"]
Engine = Literal["assetpipe", "coacd", "vhacd", "hull"]
Cavities = Literal["fill", "keep"]
RepairMode = Literal["strict", "auto", "off"]
Openings = Literal["auto", "fill", "sheet", "refuse"]
Shapes = Literal["hulls", "primitives", "primitives_and_capsules"]
Inner = Literal["none", "write"]
Format = Literal["urdf"]
Check = Literal["contact", "self_collision", "engine"]

if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass
else:
    ModelMetaclass = type(BaseModel)

_BYTES = {"B": 1, "KiB": 2**10, "MiB": 2**20, "GiB": 2**30, "kB": 10**3, "MB": 10**6, "GB": 10**9}


def _tolerance(value: Any) -> Tolerance:
    if isinstance(value, bool) or not isinstance(value, str | int | float | Tolerance):
        raise ValueError("write a length or a share, for example 2mm or 1%")  # noqa: TRY004
    if isinstance(value, str) and value.split()[:1] == ["coacd"]:
        try:
            return Tolerance.coacd(float(value.split()[1]))
        except (IndexError, ValueError) as error:
            raise ValueError("write for example: coacd 0.05") from error
    try:
        return Tolerance.parse(value)
    except UsageError as error:
        raise ValueError(error.message) from error


def _write_tolerance(tolerance: Tolerance) -> str:
    """Exact, and readable by :func:`_tolerance`."""
    if tolerance.unit == "metres":
        return f"{tolerance.value!r}m"
    if tolerance.unit == "relative":
        return f"{tolerance.value * 100!r}%"
    return f"coacd {tolerance.value!r}"


def _length(value: Any) -> float:
    """Metres from ``2mm`` or a number; zero is allowed."""
    if isinstance(value, str):
        match = re.fullmatch(r"\s*([0-9.]+(?:[eE][+-]?[0-9]+)?)\s*(m|cm|mm)\s*", value)
        if match is None:
            raise ValueError("write a length, for example 2mm or 0.002m")
        return float(match[1]) * {"m": 1.0, "cm": 1e-2, "mm": 1e-3}[match[2]]
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError("write a length, for example 2mm or 0.002m")  # noqa: TRY004
    return float(value)


def _bytes(value: Any) -> int:
    if isinstance(value, str):
        match = re.fullmatch(r"\s*([0-9.]+)\s*([A-Za-z]+)\s*", value)
        if match is None or match[2] not in _BYTES:
            raise ValueError(f"write a size with one of {', '.join(_BYTES)}, for example 256MiB")
        return int(float(match[1]) * _BYTES[match[2]])
    if isinstance(value, bool) or not isinstance(value, int):
        raise ValueError("write a size, for example 256MiB or a number of bytes")  # noqa: TRY004
    return value


ToleranceField = Annotated[
    Tolerance, BeforeValidator(_tolerance), PlainSerializer(_write_tolerance, return_type=str)
]
Metres = Annotated[float, BeforeValidator(_length), Field(ge=0.0, allow_inf_nan=False)]
Bytes = Annotated[int, BeforeValidator(_bytes), Field(gt=0)]


class _Explained(ModelMetaclass):
    """Turns pydantic's error into ours where a value is made in Python.

    In the metaclass, for an overridden ``__init__`` would also be called for
    nested models and hide where in the whole they are.
    """

    def __call__(cls, *args: Any, **values: Any) -> Any:  # noqa: N805
        try:
            return super().__call__(*args, **values)
        except ValidationError as error:
            raise ConfigError(explain(error, cast(type[BaseModel], cls))) from error


class _Frozen(BaseModel, metaclass=_Explained):
    model_config = ConfigDict(frozen=True, extra="forbid", arbitrary_types_allowed=True)


class RepairSettings(_Frozen):
    """How broken meshes are made solids.

    Attributes:
        mode: ``auto`` repairs; ``strict`` refuses what is no solid as it is;
            ``off`` takes meshes as they are.
        budget: repairs that move the surface further than this are a finding.
        openings: wider than the budget allows to close. ``auto`` gives the surface around them
            a thickness unless they are minor; ``sheet`` always; ``fill`` closes them: the
            part is solid; ``refuse`` makes the mesh a finding.
    """

    mode: RepairMode = "auto"
    budget: ToleranceField = Tolerance.relative(0.01)
    openings: Openings = "auto"


class Limits(_Frozen):
    """What one mesh may cost. Exceeding a limit is a finding on that mesh.

    Attributes:
        faces: triangles read.
        file_size: bytes of the mesh file.
        seconds: wall-clock time from reading to hulls, again for inner hulls, and again for
            validation.
        memory: bytes of address space of the process that works on the mesh.
    """

    faces: int = Field(default=2_000_000, gt=0)
    file_size: Bytes = 256 * 2**20
    seconds: float = Field(default=600.0, gt=0.0, allow_inf_nan=False)
    memory: Bytes = 8 * 2**30


class ValidationSettings(_Frozen):
    """How a result is proved.

    Attributes:
        checks: which checks run; an empty list runs none.
        samples: probe poses near the surface, a mesh.
        poses: sampled joint configurations for self-collision, besides home.
        seed: of the sampling.
    """

    checks: tuple[Check, ...] = ("contact", "self_collision", "engine")
    samples: int = Field(default=400, ge=1, le=1_000_000)
    poses: int = Field(default=1000, ge=0, le=1_000_000)
    seed: int = Field(default=0, ge=0, lt=2**63)


class LinkSettings(_Frozen):
    """What is different for one link; ``None`` takes the general value.

    Attributes:
        tolerance: of this link.
        max_hulls: budget of this link's meshes.
        max_hull_vertices: of this link's hulls.
        openings: of this link's meshes.
        treatment: ``keep`` leaves the link's collision geometry untouched.
    """

    tolerance: ToleranceField | None = None
    max_hulls: int | None = Field(default=None, ge=1)
    max_hull_vertices: int | None = Field(default=None, ge=4)
    openings: Openings | None = None
    treatment: Literal["decompose", "keep"] = "decompose"


class Config(_Frozen):
    """Everything that a build is asked to do.

    Two equal configurations and equal inputs give equal bytes; ``jobs`` only
    says how many processes work at it.

    Attributes:
        tolerance: in metres, or a share of each mesh's bounding-box diagonal.
        metric: what the tolerance bounds.
        source: decompose the collision or the visual meshes.
        effort: how hard the search tries for few hulls.
        engine: ``assetpipe``, or another one for comparison.
        seed: of the search.
        max_hulls: budget a mesh.
        max_hull_vertices: budget a hull.
        cavities: whether sealed voids count as solid.
        reach: metres; space that no ball of this radius can enter counts as solid.
        shapes: ``primitives`` writes boxes, cylinders and spheres instead of hulls where they
            are proved to stay within the tolerance; ``primitives_and_capsules`` capsules too,
            which not every URDF reader knows.
        overlap: metres by which neighbouring hulls overlap across their seams, as far as that
            is proved.
        inner: ``write`` writes convex polytopes proved to be inside the repaired mesh into
            ``inner_hulls``, beside the hulls; no URDF refers to them.
        formats: robot descriptions to write.
        jobs: meshes worked on at once; ``None`` is one a core.
        repair: how broken meshes are made solids.
        limits: what one mesh may cost.
        validation: how the result is proved.
        links: exceptions by link name.

    Raises:
        ConfigError: a key or value that does not fit; names what is allowed.
    """

    tolerance: ToleranceField = Tolerance.relative(0.01)
    metric: Metric = "thickening"
    source: Source = "collision"
    effort: Effort = "balanced"
    engine: Engine = "assetpipe"
    seed: int = Field(default=0, ge=0, lt=2**63)
    max_hulls: int | None = Field(default=None, ge=1)
    max_hull_vertices: int | None = Field(default=None, ge=4)
    cavities: Cavities = "fill"
    reach: Metres = 0.0
    shapes: Shapes = "hulls"
    overlap: Metres = 0.0
    inner: Inner = "none"
    formats: tuple[Format, ...] = Field(default=("urdf",), min_length=1)
    jobs: int | None = Field(default=None, ge=1, le=1024)
    repair: RepairSettings = RepairSettings()
    limits: Limits = Limits()
    validation: ValidationSettings = ValidationSettings()
    links: Mapping[str, LinkSettings] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _shapes_are_proved(self) -> Config:
        if self.engine == "assetpipe" and self.metric != "thickening":
            for name, asked in (("shapes", self.shapes != "hulls"), ("overlap", self.overlap > 0)):
                if asked:
                    raise ValueError(f"{name} needs metric thickening, not {self.metric}")
        return self

    def with_changes(self, **changes: Any) -> Config:
        """A copy with some fields changed, checked like a new one."""
        return Config(**{**self.model_dump(), **changes})

    def as_dict(self) -> dict[str, Any]:
        """What decides the output, JSON-ready: all but ``jobs``."""
        return self.model_dump(mode="json", exclude={"jobs"})


def load_config(name: str | Path) -> Config:
    """A configuration from a YAML file, or a shipped one by name (``planning``).

    Raises:
        ConfigError: not found, or does not fit; names key, line and what is allowed.
    """
    return load_yaml(find_config(name), Config)
