"""One thing in a scene: a robot package, a URDF, or a body of a stated shape."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import Field, model_validator

from assetpipe.decomposition.tolerance import Tolerance
from assetpipe.errors import unknown_name
from assetpipe.validation.scenes.fields import (
    Finite,
    Frozen,
    Length,
    NotNegative,
    Positive,
    ToleranceField,
    Vector,
)

Collision = Literal["built", "original", "hull", "coacd", "vhacd"]
BodyKind = Literal["box", "sphere", "cylinder", "capsule", "extrusion", "mesh"]
Base = Literal["fixed", "free", "driven"]

_DIMENSIONS: Mapping[BodyKind, tuple[str, ...]] = {
    "box": ("size",),
    "sphere": ("radius",),
    "cylinder": ("radius", "length"),
    "capsule": ("radius", "length"),
    "extrusion": ("outline", "length"),
    "mesh": ("mesh",),
}


class Pose(Frozen):
    """Position (metres) and roll, pitch, yaw (radians) in the world, as in URDF."""

    xyz: Vector = (0.0, 0.0, 0.0)
    rpy: tuple[Finite, Finite, Finite] = (0.0, 0.0, 0.0)


class Material(Frozen):
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


class AssetSpec(Frozen):
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
