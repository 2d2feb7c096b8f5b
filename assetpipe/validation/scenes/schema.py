"""A scene: assets in a situation, what drives them, and the question asked.

Every key is checked when the file is read; a combination that cannot be meant is an
error that names what could have been.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, model_validator

from assetpipe.errors import ConfigError, unknown_name
from assetpipe.schema import load_yaml
from assetpipe.shipped import find_config
from assetpipe.validation.scenes.asset_spec import AssetSpec
from assetpipe.validation.scenes.drive import Drive
from assetpipe.validation.scenes.fields import Frozen, Length, NotNegative, Positive

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


def _switch(value: Any) -> Any:
    # YAML 1.1 reads a bare on/off as true/false.
    return {True: "on", False: "off"}.get(value, value) if isinstance(value, bool) else value


def _answer(value: Any) -> Any:
    return {True: "yes", False: "no"}.get(value, value) if isinstance(value, bool) else value


class Sampling(Frozen):
    """Joint configurations to ask, besides the start: uniform within limits, seeded."""

    configurations: int = Field(default=1000, ge=0, le=1_000_000)
    seed: int = Field(default=0, ge=0, lt=2**63)


class Expect(Frozen):
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


class Scene(Frozen):
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
        if self.between is not None:
            first, second = sorted(self.between, key=len)
            if first == second:
                raise ValueError("'between' names the same part twice; name two")
            bodies = [name for name, a in self.assets.items() if a.body or a.link]
            if second.startswith(f"{first}/") and first in bodies:
                raise ValueError(f"'between' names '{first}' and a part of it; name two things")
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
        self._contradictions()
        if self.question == "slide" and path is not None and self.subject == path.asset:
            raise ValueError(
                "the subject of 'slide' is pulled by the asset on drive.path, or lies on it: "
                "name a free asset"
            )

    def _contradictions(self) -> None:
        """What the scene itself says both ways; ``--sensitivity`` toggles from outside."""
        driven: dict[EffectName, bool] = {
            "gravity": bool(self.drive.gravity),
            "motors": bool(self.drive.motors),
        }
        for effect, said in driven.items():
            if said and self.effects.get(effect) == "off":
                raise ValueError(
                    f"'drive.{effect}' drives the scene and 'effects' says {effect}: off; "
                    "leave one of them out"
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
