"""Make a scene's assets: read robots, make bodies, decompose what is not convex."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Literal, Protocol

import numpy as np

from assetpipe.decomposition.tolerance import Tolerance
from assetpipe.errors import ConfigError, InputError, Location, unknown_name
from assetpipe.geometry.mesh import FloatArray, Mesh
from assetpipe.validation.scenes.asset_spec import AssetSpec, Collision
from assetpipe.validation.scenes.assets import (
    Inertial,
    JointKind,
    Round,
    SceneAsset,
    SceneJoint,
    SceneLink,
    matrix_of,
    pose_matrix,
)
from assetpipe.validation.scenes.bodies import body_mesh, is_convex, mesh_path
from assetpipe.validation.scenes.schema import Scene

if TYPE_CHECKING:
    from assetpipe.decomposition import EngineName
    from assetpipe.robot.model import Collision as RobotCollision
    from assetpipe.robot.model import Robot

DENSITY = 500.0
"""kg/m³ of bodies and links that state no mass: between wood and plastic parts."""

_HERE = Path(__file__).resolve()


@dataclass(frozen=True, eq=False)
class Convexes:
    """Meshes that stand for a solid, and their certificate's upper bound, metres.

    ``kind`` is ``surface`` where they are the original, which need not be convex.
    """

    shapes: tuple[Mesh, ...]
    certificate: float
    kind: Literal["surface", "hulls"] = "hulls"


class AssetProvider(Protocol):
    """Where hulls come from: computed here, or taken from a cache of builds."""

    def convexes(self, mesh: Mesh, engine: EngineName, tolerance: Tolerance) -> Convexes:
        """Hulls of a mesh (its own frame, metres)."""
        ...


@dataclass
class DirectProvider:
    """Decomposes on the spot, each distinct mesh once."""

    effort: str = "fast"
    _known: dict[tuple[str, str, str], Convexes] = field(default_factory=dict)

    def convexes(self, mesh: Mesh, engine: EngineName, tolerance: Tolerance) -> Convexes:
        """Hulls of a mesh; see :class:`AssetProvider`."""
        from assetpipe.decomposition import decompose_with

        key = (mesh.digest, engine, str(tolerance))
        if key not in self._known:
            options = {"effort": self.effort} if engine == "assetpipe" else {}
            found = decompose_with(engine, mesh, tolerance, **options)
            self._known[key] = Convexes(tuple(h.mesh for h in found.hulls), found.certificate.upper)
        return self._known[key]


def build_assets(
    scene: Scene, scene_file: Path | None = None, *, provider: AssetProvider | None = None
) -> dict[str, SceneAsset]:
    """Make every asset of a scene.

    Args:
        scene: what to make.
        scene_file: where relative paths start, and packages are looked for first.
        provider: of hulls; by default they are computed on the spot.

    Raises:
        ConfigError: a package, link or joint that does not exist, or a shape that is none.
        InputError: a file that cannot be read.
        MeshError: a mesh that cannot be made a solid.
    """
    source = provider or DirectProvider()
    assets = {}
    for name, spec in scene.assets.items():
        if spec.body is not None:
            assets[name] = _body(name, spec, scene_file, source)
        else:
            assets[name] = _robot_asset(name, spec, scene_file, source)
    return assets


def _convex(
    mesh: Mesh, collision: Collision, tolerance: Tolerance, source: AssetProvider
) -> Convexes:
    if collision == "original":
        return Convexes((mesh,), 0.0, "surface")
    engine: EngineName = "assetpipe" if collision == "built" else collision
    return source.convexes(mesh, engine, tolerance)


# -- bodies -------------------------------------------------------------------


def _body(name: str, spec: AssetSpec, scene_file: Path | None, source: AssetProvider) -> SceneAsset:
    if spec.body == "mesh":
        from assetpipe.geometry import read_mesh

        mesh = read_mesh(mesh_path(spec, scene_file)).mesh
    else:
        try:
            mesh = body_mesh(spec)
        except ConfigError as error:
            raise ConfigError(f"asset '{name}': {error.message}") from error
    found = (
        Convexes((mesh,), 0.0)
        if is_convex(spec)
        else _convex(mesh, spec.collision, spec.tolerance, source)
    )
    inertial = None
    if spec.base != "fixed":
        mass = spec.mass if spec.mass is not None else max(DENSITY * abs(mesh.volume), 1e-3)
        inertial = Inertial.uniform((mesh,), mass)
    rolls: Round | None = None
    if spec.body in ("sphere", "cylinder", "capsule") and spec.radius is not None:
        rolls = Round(spec.body, spec.radius)
    link = SceneLink("body", found.shapes, found.certificate, inertial, rolls, found.kind)
    return SceneAsset(
        name,
        (link,),
        world_from_base=pose_matrix(spec.pose),
        base=spec.base,
        material=spec.material,
    )


# -- robots -------------------------------------------------------------------


def package_folders(scene_file: Path | None) -> Iterator[Path]:
    """Where packages are looked for: around the scene's file, then our own samples."""
    if scene_file is not None:
        for above in scene_file.resolve().parents[:4]:
            yield above
            yield above / "sample_assets"
    for root in (_HERE.parents[2], _HERE.parents[3]):
        yield root / "sample_assets"


def find_package(name: str, scene_file: Path | None) -> Path:
    """The URDF (or xacro) of a package.

    Raises:
        ConfigError: no such package, or not exactly one robot in it.
    """
    known: dict[str, Path] = {}
    for folder in package_folders(scene_file):
        if not folder.is_dir():
            continue
        for manifest in sorted(folder.glob("*/package.xml")):
            known.setdefault(manifest.parent.name, manifest.parent)
    if name not in known:
        raise ConfigError(unknown_name("package", name, known))
    robots = sorted(known[name].rglob("*.urdf")) or sorted(known[name].rglob("*.urdf.xacro"))
    if len(robots) != 1:
        told = ", ".join(r.name for r in robots) or "none"
        raise ConfigError(f"package '{name}' must hold one URDF, it holds {told}: write 'urdf'")
    return robots[0]


def _robot_asset(
    name: str, spec: AssetSpec, scene_file: Path | None, source: AssetProvider
) -> SceneAsset:
    from assetpipe.robot import read_robot

    if spec.package is not None:
        path = find_package(spec.package, scene_file)
    else:
        path = ((scene_file.parent if scene_file else Path()) / str(spec.urdf)).resolve()
        if not path.is_file():
            raise InputError("URDF does not exist", location=Location(path))
    read = read_robot(path)
    robot = read.robot
    if spec.link is not None and spec.link not in {item.name for item in robot.links}:
        known = [item.name for item in robot.links]
        raise ConfigError(f"'{path.name}': " + unknown_name("link", spec.link, known))
    extras = _Extras.of(robot)
    wanted = [item for item in _ordered(robot) if spec.link in (None, item)]
    links = tuple(_link(robot, item, spec, extras, source) for item in wanted)
    joints = () if spec.link is not None else _joints(robot, extras)
    return SceneAsset(
        name,
        links,
        joints,
        world_from_base=pose_matrix(spec.pose),
        base=spec.base,
        start=dict(spec.joints),
        moving=spec.moving,
        resistance=dict(spec.resistance),
        material=spec.material,
    )


def _ordered(robot: Robot) -> list[str]:
    """Link names, the base first and parents before children."""
    children: dict[str, list[str]] = {}
    for joint in robot.joints:
        children.setdefault(joint.parent, []).append(joint.child)
    carried = {joint.child for joint in robot.joints}
    waiting = [item.name for item in robot.links if item.name not in carried][:1]
    ordered: list[str] = []
    while waiting:
        name = waiting.pop(0)
        ordered.append(name)
        waiting += [c for c in children.get(name, []) if c not in ordered]
    return ordered


def _link(
    robot: Robot, name: str, spec: AssetSpec, extras: _Extras, source: AssetProvider
) -> SceneLink:
    shapes: list[Mesh] = []
    certificate = 0.0
    kind: Literal["surface", "hulls"] = "hulls"
    for collision in robot.link(name).collisions:
        found = _shape(robot, collision, spec, source)
        shapes += [m.transformed(collision.link_from_shape) for m in found.shapes]
        certificate = max(certificate, found.certificate)
        kind = found.kind if found.kind == "surface" else kind
    inertial = extras.inertials.get(name)
    if spec.mass is not None:
        inertial = Inertial.uniform(shapes, spec.mass)
    elif inertial is None or (spec.link is not None and spec.base != "fixed" and not inertial.mass):
        volume = sum(abs(m.volume) for m in shapes)
        inertial = Inertial.uniform(shapes, max(DENSITY * volume, 1e-3))
    return SceneLink(name, tuple(shapes), certificate, inertial, kind=kind)


def _shape(
    robot: Robot, collision: RobotCollision, spec: AssetSpec, source: AssetProvider
) -> Convexes:
    from assetpipe.geometry import read_mesh
    from assetpipe.robot.model import Box, Capsule, Cylinder, MeshShape, Sphere

    shape = collision.shape
    if isinstance(shape, MeshShape):
        where = Location(robot.path, collision.line)
        if shape.path is None:
            raise InputError(f"mesh '{shape.uri}' cannot be resolved", location=where)
        mesh = read_mesh(shape.path).mesh.scaled(shape.scale)
        return _convex(mesh, spec.collision, spec.tolerance, source)
    if isinstance(shape, Box):
        body = AssetSpec(body="box", size=shape.size)
    elif isinstance(shape, Sphere):
        body = AssetSpec(body="sphere", radius=shape.radius)
    elif isinstance(shape, Cylinder):
        body = AssetSpec(body="cylinder", radius=shape.radius, length=shape.length)
    elif isinstance(shape, Capsule):
        body = AssetSpec(body="capsule", radius=shape.radius, length=shape.length)
    else:
        return Convexes((), 0.0)
    return Convexes((body_mesh(body),), 0.0)


def _joints(robot: Robot, extras: _Extras) -> tuple[SceneJoint, ...]:
    """Joints, parents before children; floating and planar ones are taken as fixed."""
    rank = {name: i for i, name in enumerate(_ordered(robot))}
    joints = []
    for joint in sorted(robot.joints, key=lambda j: rank.get(j.child, len(rank))):
        if joint.child not in rank:
            continue
        kind: JointKind = "fixed"
        if joint.type in ("revolute", "continuous", "prismatic"):
            kind = joint.type
        limit = joint.limit
        bounded = kind in ("revolute", "prismatic") and limit is not None
        damping, friction = extras.dynamics.get(joint.name, (0.0, 0.0))
        mimic = joint.mimic
        joints.append(
            SceneJoint(
                joint.name,
                kind,
                joint.parent,
                joint.child,
                joint.parent_from_joint,
                np.asarray(joint.axis, dtype=np.float64),
                lower=_or(limit.lower if limit and bounded else None, -math.inf),
                upper=_or(limit.upper if limit and bounded else None, math.inf),
                velocity=_or((limit.velocity if limit else None) or None, math.inf),
                effort=_or((limit.effort if limit else None) or None, math.inf),
                damping=damping,
                friction=friction,
                mimic=(mimic.joint, mimic.multiplier, mimic.offset) if mimic else None,
            )
        )
    return tuple(joints)


def _or(value: float | None, default: float) -> float:
    return default if value is None else float(value)


@dataclass(frozen=True, eq=False)
class _Extras:
    """What only physics asks of a URDF: inertials by link, damping and friction by joint."""

    inertials: Mapping[str, Inertial]
    dynamics: Mapping[str, tuple[float, float]]

    @classmethod
    def of(cls, robot: Robot) -> _Extras:
        from lxml import etree

        parser = etree.XMLParser(
            resolve_entities=False, no_network=True, load_dtd=False, huge_tree=False
        )
        root = etree.fromstring(robot.source, parser)
        inertials = {}
        for link in root.iterchildren("link"):
            element = link.find("inertial")
            mass = element.find("mass") if element is not None else None
            if element is None or mass is None:
                continue
            inertials[link.get("name", "")] = _inertial(element, float(mass.get("value", "0")))
        dynamics = {
            joint.get("name", ""): (
                float(found.get("damping", "0")),
                float(found.get("friction", "0")),
            )
            for joint in root.iterchildren("joint")
            for found in joint.iterchildren("dynamics")
        }
        return cls(inertials, dynamics)


_TENSOR = {
    (0, 0): "ixx",
    (1, 1): "iyy",
    (2, 2): "izz",
    (0, 1): "ixy",
    (0, 2): "ixz",
    (1, 2): "iyz",
}


def _inertial(element: object, mass: float) -> Inertial:
    origin = element.find("origin")  # type: ignore[attr-defined]
    tensor = element.find("inertia")  # type: ignore[attr-defined]
    matrix = np.eye(4)
    if origin is not None:
        xyz, rpy = ([float(v) for v in origin.get(k, "0 0 0").split()] for k in ("xyz", "rpy"))
        matrix = matrix_of(xyz, rpy)
    inertia: FloatArray = np.zeros((3, 3))
    if tensor is not None:
        for (i, j), key in _TENSOR.items():
            inertia[i, j] = inertia[j, i] = float(tensor.get(key, "0"))
    turn = matrix[:3, :3]
    return Inertial(mass, matrix[:3, 3].copy(), turn @ inertia @ turn.T)
