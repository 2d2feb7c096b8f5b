"""A scene: assets in a situation, what drives them, and the question asked.

Every key is checked when the file is read; a combination that cannot be meant is an
error that names what could have been.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, PlainSerializer, model_validator

from assetpipe.decomposition.tolerance import Tolerance
from assetpipe.errors import ConfigError, UsageError, unknown_name
from assetpipe.schema import load_yaml
from assetpipe.shipped import find_config

Question = Literal[
    "clearance", "contact", "self_collision", "reach", "settle", "hold", "open", "slide"
]
EffectName = Literal[
    "gravity",
    "friction",
    "rolling_friction",
    "spinning_friction",
    "restitution",
    "joint_limits",
    "motors",
    "self_collision",
    "continuous_collision",
    "damping",
    "contact_margin",
]
Switch = Literal["on", "off"]
Collision = Literal["built", "original", "hull", "coacd", "vhacd"]
BodyKind = Literal["box", "sphere", "cylinder", "capsule", "extrusion", "mesh"]
Base = Literal["fixed", "free", "driven"]

_LENGTH = re.compile(r"\s*(-?[0-9.]+(?:[eE][+-]?[0-9]+)?)\s*(mm|cm|m)\s*")
_DIMENSIONS: Mapping[BodyKind, tuple[str, ...]] = {
    "box": ("size",),
    "sphere": ("radius",),
    "cylinder": ("radius", "length"),
    "capsule": ("radius", "length"),
    "extrusion": ("outline", "length"),
    "mesh": ("mesh",),
}


def _length(value: Any) -> Any:
    match = _LENGTH.fullmatch(value) if isinstance(value, str) else None
    if match is None:
        return value
    return float(match[1]) * {"m": 1.0, "cm": 1e-2, "mm": 1e-3}[match[2]]


def _switch(value: Any) -> Any:
    # YAML 1.1 reads a bare on/off as true/false.
    return {True: "on", False: "off"}.get(value, value) if isinstance(value, bool) else value


def _answer(value: Any) -> Any:
    return {True: "yes", False: "no"}.get(value, value) if isinstance(value, bool) else value


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


class _Frozen(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", arbitrary_types_allowed=True)


class Pose(_Frozen):
    """Position (metres) and roll, pitch, yaw (radians) in the world, as in URDF."""

    xyz: Vector = (0.0, 0.0, 0.0)
    rpy: tuple[Finite, Finite, Finite] = (0.0, 0.0, 0.0)


class Material(_Frozen):
    """Surface properties; what is not stated is not part of the scene.

    Attributes:
        friction: Coulomb coefficient.
        rolling_friction, spinning_friction: metres, as engines take them.
        restitution: 0 (dead) to 1 (elastic).
    """

    friction: Annotated[float, Field(ge=0.0, le=10.0)] | None = None
    rolling_friction: NotNegative | None = None
    spinning_friction: NotNegative | None = None
    restitution: Annotated[float, Field(ge=0.0, le=1.0)] | None = None


class AssetSpec(_Frozen):
    """One thing in the scene: a robot package, a URDF, or a body of a stated shape.

    Attributes:
        package: name of a ROS package; its only URDF is taken.
        urdf: path of a URDF, relative to the scene's file.
        body: kind of a single rigid body.
        link: with ``package`` or ``urdf``: only this link, as a single rigid body.
        collision: which geometry stands for the shapes that are not convex.
        tolerance: of ``built``, ``coacd`` and ``vhacd``.
        pose: of the base link's frame in the world.
        base: ``fixed`` to the world, ``free`` to move, or ``driven`` along a path.
        joints: positions to start from, by joint name; others start at home.
        moving: joints that may move; all others are frozen where they are.
        size: of a box, along x, y, z.
        radius, length: of a sphere, cylinder, capsule (along z, caps not counted).
        outline: corners (x, y) of an extrusion, counter-clockwise; ``length`` along z.
        mesh: path of a mesh, relative to the scene's file.
        mass: kilograms; needed by a body that is free.
        resistance: force (N) or torque (Nm) by joint that holds it until overcome.
        material: of all its surfaces.
    """

    package: str | None = None
    urdf: str | None = None
    body: BodyKind | None = None
    link: str | None = None
    collision: Collision = "built"
    tolerance: ToleranceField = Tolerance.relative(0.01)
    pose: Pose = Pose()
    base: Base = "fixed"
    joints: Mapping[str, Length] = Field(default_factory=dict)
    moving: tuple[str, ...] = ()
    size: tuple[Positive, Positive, Positive] | None = None
    radius: Positive | None = None
    length: Positive | None = None
    outline: tuple[tuple[Length, Length], ...] | None = Field(default=None, min_length=3)
    mesh: str | None = None
    mass: Positive | None = None
    resistance: Mapping[str, NotNegative] = Field(default_factory=dict)
    material: Material = Material()

    @model_validator(mode="after")
    def _meant(self) -> AssetSpec:
        kinds = [k for k in ("package", "urdf", "body") if getattr(self, k) is not None]
        if len(kinds) != 1:
            said = " and ".join(kinds) if kinds else "none of them"
            raise ValueError(f"an asset is one of package, urdf or body, not {said}")
        if self.body is None:
            dimensions = [k for k in _all_dimensions() if getattr(self, k) is not None]
            if dimensions:
                raise ValueError(f"'{dimensions[0]}' belongs to a body, not to a {kinds[0]}")
        else:
            self._body(self.body)
        if self.link is not None and (self.moving or self.joints):
            raise ValueError("a single link has no joints: leave out 'joints' and 'moving'")
        for joint in self.resistance:
            if joint not in self.moving:
                raise ValueError(unknown_name("moving joint", joint, self.moving))
        return self

    def _body(self, body: BodyKind) -> None:
        needed = _DIMENSIONS[body]
        for key in needed:
            if getattr(self, key) is None:
                raise ValueError(f"a {body} needs {' and '.join(needed)}; '{key}' is missing")
        for key in _all_dimensions():
            if key not in needed and getattr(self, key) is not None:
                raise ValueError(f"a {body} has no '{key}'; it has {' and '.join(needed)}")
        for key in ("joints", "moving", "resistance", "link"):
            if getattr(self, key):
                raise ValueError(f"a body has no joints: '{key}' belongs to a package or urdf")
        if self.base == "free" and self.mass is None:
            raise ValueError("a free body needs a 'mass'; or set base: fixed or driven")
        if self.base == "fixed" and self.mass is not None:
            raise ValueError("a fixed body has no 'mass'; or set base: free or driven")
        convex = body not in ("extrusion", "mesh")
        if convex and self.collision != "built":
            raise ValueError(
                f"a {body} is convex as it is: 'collision' belongs to a package, a urdf, "
                "an extrusion or a mesh"
            )


def _all_dimensions() -> tuple[str, ...]:
    return tuple(sorted({key for keys in _DIMENSIONS.values() for key in keys}))


class Waypoint(_Frozen):
    """A pose relative to the asset's own, and when it is reached (seconds)."""

    xyz: Vector = (0.0, 0.0, 0.0)
    rpy: tuple[Finite, Finite, Finite] = (0.0, 0.0, 0.0)
    at: Annotated[float, Field(gt=0.0, allow_inf_nan=False)]


class PathDrive(_Frozen):
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


class TrajectoryDrive(_Frozen):
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


class MotorDrive(_Frozen):
    """Joints are held at, or driven to, target positions by motors."""

    targets: Mapping[str, Length] = Field(min_length=1)
    force: Annotated[float, Field(gt=0.0, allow_inf_nan=False)] | None = None


class Drive(_Frozen):
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


class Sampling(_Frozen):
    """Joint configurations to ask, besides the start: uniform within limits, seeded."""

    configurations: int = Field(default=1000, ge=0, le=1_000_000)
    seed: int = Field(default=0, ge=0, lt=2**63)


class Expect(_Frozen):
    """What the answer should be; a scene without it only measures.

    Attributes:
        answer: yes or no.
        measure: the number that goes with it, and
        tolerance: by how much it may differ.
    """

    answer: Annotated[Literal["yes", "no"], BeforeValidator(_answer)] | None = None
    measure: Length | None = None
    tolerance: NotNegative = 1e-3


_WHAT: Mapping[str, str] = {
    "clearance": "how far apart 'between' two parts are",
    "contact": "whether 'between' two parts touch",
    "self_collision": "which links of the 'subject' touch each other",
    "reach": "whether the asset on 'drive.path' gets through without touching",
    "settle": "whether free bodies under 'drive.gravity' stay within 'limit'",
    "hold": "whether the 'subject' stays within 'limit' under gravity or motors",
    "open": "whether the joint 'subject' (asset/joint) is moved by 'limit'",
    "slide": "whether the 'subject' follows 'drive.path' within 'limit'",
}


class Scene(_Frozen):
    """Assets, what drives them, and a question.

    Attributes:
        title: one line.
        question: what is asked.
        assets: by name.
        between: the two parts that clearance and contact are about, ``asset`` or
            ``asset/link``.
        subject: what self_collision, hold, slide (asset) and open (asset/joint) are about.
        drive: what drives the scene.
        seconds: how long; by default as long as the drive lasts, or 1 s.
        limit: metres (or radians for a turning joint) that decide yes or no.
        sampling: for self_collision.
        effects: overrules the planner, effect by effect.
        expect: what the answer should be.
    """

    title: str
    question: Question
    assets: Mapping[str, AssetSpec] = Field(min_length=1)
    between: tuple[str, str] | None = None
    subject: str | None = None
    drive: Drive = Drive()
    seconds: Annotated[float, Field(gt=0.0, le=3600.0)] | None = None
    limit: Positive | None = None
    sampling: Sampling | None = None
    effects: Mapping[EffectName, Annotated[Switch, BeforeValidator(_switch)]] = Field(
        default_factory=dict
    )
    expect: Expect = Expect()

    @model_validator(mode="after")
    def _possible(self) -> Scene:
        self._keys_of_the_question()
        self._references()
        self._drives()
        return self

    def _keys_of_the_question(self) -> None:
        q = self.question
        what = f"question '{q}' asks {_WHAT[q]}"
        if (self.between is not None) != (q in ("clearance", "contact")):
            verb = "is missing" if self.between is None else "has no place here"
            raise ValueError(f"{what}: 'between' {verb}; {_others('between')}")
        needs_subject = q in ("self_collision", "hold", "open", "slide")
        if (self.subject is not None) != needs_subject:
            verb = "is missing" if needs_subject else "has no place here"
            raise ValueError(f"{what}: 'subject' {verb}; {_others('subject')}")
        needs_limit = q in ("settle", "hold", "open", "slide")
        if needs_limit and self.limit is None:
            raise ValueError(f"{what}: 'limit' is missing")
        if self.limit is not None and q in ("contact", "reach", "self_collision"):
            raise ValueError(f"{what}: 'limit' has no place here; {_others('limit')}")
        if self.sampling is not None and q != "self_collision":
            raise ValueError(f"{what}: 'sampling' has no place here; {_others('sampling')}")
        if q in ("reach", "slide") and self.drive.path is None:
            raise ValueError(f"{what}: 'drive.path' is missing")
        if q == "settle" and not self.drive.gravity:
            raise ValueError(f"{what}: 'drive.gravity' is missing, for example 9.81")
        if q == "hold" and not (self.drive.gravity or self.drive.motors):
            raise ValueError(f"{what}: 'drive.gravity' or 'drive.motors' is missing")
        if q == "open" and not (self.drive.path or self.drive.motors or self.drive.gravity):
            raise ValueError(f"{what}: a drive is missing: path, motors or gravity")
        if q == "self_collision" and self.drive != Drive():
            raise ValueError(
                f"{what}, at the start and in sampled configurations: 'drive' has no place "
                "here; for a motion ask 'contact' or 'clearance' between two links"
            )
        if q == "settle" and not any(a.base == "free" for a in self.assets.values()):
            raise ValueError(f"{what}: no asset has base: free")

    def _references(self) -> None:
        names: list[str] = list(self.between or ())
        if self.subject is not None:
            names.append(self.subject)
        for reference in names:
            asset = reference.split("/", 1)[0]
            if asset not in self.assets:
                raise ValueError(unknown_name("asset", asset, self.assets))
        if self.between is not None and self.between[0] == self.between[1]:
            raise ValueError("'between' names the same part twice; name two")
        if self.question == "open" and "/" not in (self.subject or ""):
            raise ValueError("the subject of 'open' is a joint: write asset/joint")
        if self.question in ("slide", "self_collision") and "/" in (self.subject or ""):
            raise ValueError(f"the subject of '{self.question}' is a whole asset")

    def _drives(self) -> None:
        driven = {name for name, a in self.assets.items() if a.base == "driven"}
        path = self.drive.path
        if path is not None:
            if path.asset not in self.assets:
                raise ValueError(unknown_name("asset", path.asset, self.assets))
            if path.asset not in driven:
                raise ValueError(f"drive.path moves '{path.asset}': set its base: driven")
        idle = sorted(driven - ({path.asset} if path else set()))
        if idle:
            raise ValueError(f"asset '{idle[0]}' is driven but no drive.path names it")
        trajectory = self.drive.trajectory
        moved = {trajectory.asset: set(trajectory.joints)} if trajectory else {}
        if trajectory is not None and self.question not in ("clearance", "contact"):
            raise ValueError(
                f"drive.trajectory is kinematic and serves clearance and contact; for "
                f"'{self.question}' use drive.motors"
            )
        for name, motors in self.drive.motors.items():
            moved.setdefault(name, set()).update(motors.targets)
        for name, joints in moved.items():
            if name not in self.assets:
                raise ValueError(unknown_name("asset", name, self.assets))
            for joint in sorted(joints - set(self.assets[name].moving)):
                raise ValueError(
                    f"joint '{joint}' of '{name}' is driven but frozen: add it to 'moving'"
                )
        if self.drive.motors and self.question in ("clearance", "contact", "reach"):
            raise ValueError(
                f"drive.motors needs a physics question (settle, hold, open, slide); for "
                f"'{self.question}' use drive.trajectory or start positions in 'joints'"
            )
        if self.question == "slide" and path is not None and self.subject == path.asset:
            raise ValueError(
                "the subject of 'slide' is pulled by the asset on drive.path, or lies on it: "
                "name a free asset"
            )


def _others(key: str) -> str:
    users = {
        "between": ("clearance", "contact"),
        "subject": ("self_collision", "hold", "open", "slide"),
        "limit": ("clearance", "settle", "hold", "open", "slide"),
        "sampling": ("self_collision",),
    }[key]
    return f"'{key}' belongs to {', '.join(users)}"


def load_scene(name: str | Path) -> tuple[Scene, Path]:
    """A scene from a YAML file, or a shipped one by name, and the file it came from.

    Raises:
        ConfigError: not found, or does not fit; with file, line and what is allowed.
    """
    path = find_config(name, kind="scenes")
    return load_yaml(path, Scene), path


def parse_scene(values: Mapping[str, Any]) -> Scene:
    """A scene from a mapping, with the same errors as a file (without a line).

    Raises:
        ConfigError: does not fit.
    """
    from pydantic import ValidationError

    from assetpipe.schema import explain

    try:
        return Scene.model_validate(values)
    except ValidationError as error:
        raise ConfigError(explain(error, Scene)) from error
