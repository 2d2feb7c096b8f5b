"""Read a URDF or xacro file into a :class:`Robot`, telling whatever is wrong with it.

What concerns one element is a finding and the rest is read all the same; only a file that is
no robot description at all is an error.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, TypeVar

import numpy as np

from assetpipe.errors import InputError, Location, unknown_name
from assetpipe.findings import Finding, Severity
from assetpipe.geometry.mesh import locked
from assetpipe.robot import checks, values
from assetpipe.robot.lookup import Lookup
from assetpipe.robot.markup import MAX_BYTES, Element, Markup, read_markup
from assetpipe.robot.model import (
    Box,
    Capsule,
    Collision,
    Cylinder,
    Joint,
    Limit,
    Link,
    MeshShape,
    Mimic,
    OtherShape,
    Reference,
    Robot,
    Shape,
    Sphere,
    Visual,
)
from assetpipe.robot.resources import Resolver
from assetpipe.robot.values import shape_of
from assetpipe.robot.xacro import expand

_Placed = TypeVar("_Placed", Collision, Visual)
_Role = Literal["collision", "visual", "texture", "other"]
_SEVERITY = {
    "collision": Severity.ERROR,
    "visual": Severity.WARNING,
    "texture": Severity.WARNING,
    "other": Severity.NOTE,
}
"""How much it matters that a file is missing, by what it is for."""


@dataclass(frozen=True)
class ReadRobot:
    """A robot and what was found out on reading it, in document order."""

    robot: Robot
    findings: tuple[Finding, ...]


def read_robot(
    path: Path | str,
    *,
    resolver: Resolver | None = None,
    arguments: Mapping[str, str] | None = None,
) -> ReadRobot:
    """Read a robot description.

    Args:
        path: a URDF, or a xacro file, which is expanded first (:mod:`assetpipe.robot.xacro`).
        resolver: where packages may be found; from the environment unless given.
        arguments: values of ``<xacro:arg>``.

    Raises:
        InputError: missing, not well formed, no ``<robot>``; with file and line. For xacro a
            :class:`assetpipe.robot.xacro.XacroError`.
        LimitError: too large, or xacro took too long.
    """
    path = Path(path)
    resolver = resolver or Resolver.from_environment()
    lookup = resolver.beside(path)
    includes: tuple[Path, ...] = ()
    if path.suffix.lower() == ".xacro":
        source, includes = expand(path, lookup, arguments or {})
    else:
        source = _bytes(path)
    return _Reader(path, source, lookup).read(includes)


def finding_of(error: InputError) -> Finding:
    """The finding that stands for a description that could not be read (AP104, AP108)."""
    code = getattr(error, "code", "AP104")
    return Finding(code, Severity.ERROR, error.message, location=error.location)


def _bytes(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            return file.read(MAX_BYTES + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"cannot be read: {reason}", location=Location(path)) from error


class _Reader:
    """Gathers the parts of one robot and the findings about them."""

    def __init__(self, path: Path, source: bytes, lookup: Lookup) -> None:
        self._path = path
        self._source = source
        self._lookup = lookup
        self._markup: Markup = read_markup(source, path)
        self._findings: list[Finding] = []
        self._references: list[Reference] = []

    def read(self, includes: tuple[Path, ...]) -> ReadRobot:
        root = self._markup.root
        if root.tag != "robot":
            raise InputError(
                f"root element is <{root.tag}>, not <robot>", location=self._at(root.line)
            )
        for slip in self._markup.slips:
            self._say("AP104", slip.line, f"{slip.message}; other programs may refuse the file")
        elements = self._named(root.all("link"), "link")
        links = self._links(elements)
        joints = self._joints(self._named(root.all("joint"), "joint"), {e.name for e in links})
        self._other_references(root)
        if not any(link.collisions for link in links):
            self._say("AP107", root.line, "no link has a <collision> element")
        robot = Robot(
            name=root.attributes.get("name", ""),
            path=self._path,
            source=self._source,
            links=links,
            joints=joints,
            package=self._lookup.package,
            home=self._lookup.home,
            references=tuple(self._references),
            includes=includes,
        )
        return ReadRobot(robot, tuple(self._findings))

    def _at(self, line: int | None) -> Location:
        return Location(self._path, line)

    def _say(
        self,
        code: str,
        line: int,
        message: str,
        *,
        severity: Severity = Severity.WARNING,
        link: str | None = None,
        mesh: str | None = None,
    ) -> None:
        self._findings.append(
            Finding(code, severity, message, location=self._at(line), link=link, mesh=mesh)
        )

    def _named(self, elements: Sequence[Element], kind: str) -> list[Element]:
        """Elements with a name of their own; the first one of each name."""
        found: dict[str, Element] = {}
        for element in elements:
            name = element.attributes.get("name", "")
            if not name:
                message = f"<{kind}> without a name"
                self._say("AP105", element.line, message, severity=Severity.ERROR)
            elif name in found:
                self._say(
                    "AP109",
                    element.line,
                    f"a second {kind} '{name}'; the first one is in line {found[name].line} and "
                    "this one is left as it is",
                    severity=Severity.ERROR,
                    link=name if kind == "link" else None,
                )
            else:
                found[name] = element
        return list(found.values())

    def _links(self, elements: Sequence[Element]) -> tuple[Link, ...]:
        shapes = [c for e in elements for c in e.children if c.tag in ("collision", "visual")]
        parsed = dict(zip(map(id, shapes), values.parse_shapes(shapes), strict=True))
        links = []
        for element in elements:
            name = element.attributes["name"]
            collisions = [
                self._placed(Collision, e, parsed[id(e)], link=name, index=k)
                for k, e in enumerate(element.all("collision"))
            ]
            visuals = [
                self._placed(Visual, e, parsed[id(e)], link=name, index=k)
                for k, e in enumerate(element.all("visual"))
            ]
            links.append(Link(name, tuple(collisions), tuple(visuals), element.line))
        return tuple(links)

    def _placed(
        self,
        kind: type[_Placed],
        element: Element,
        parsed: Any,
        *,
        link: str,
        index: int,
    ) -> _Placed:
        name = element.attributes.get("name")
        for odd in checks.odd_shape(element):
            self._say("AP105", element.line, f"<{element.tag}> {odd}", link=link)
        wrong = checks.wrong_shape(element, parsed)
        if wrong is not None:
            severity = Severity.ERROR if kind is Collision else Severity.WARNING
            message = f"<{element.tag}> {wrong}; left as it is"
            self._say("AP105", element.line, message, severity=severity, link=link)
            for mesh in element.walk():
                if mesh.tag == "mesh" and mesh.attributes.get("filename", "").strip():
                    # what stays as it is needs its files all the same
                    uri = mesh.attributes["filename"]
                    self._refer(_role(element), uri, mesh.line, link=link, index=index)
            inner = shape_of(element)
            other = OtherShape(inner.tag if inner is not None else "")
            return kind(link, index, name, values.pose(None), other, element.line)
        shape = self._shape(element, parsed, link, index)
        return kind(link, index, name, values.pose(parsed.origin), shape, element.line)

    def _shape(self, element: Element, parsed: Any, link: str, index: int) -> Shape:
        inner = shape_of(element)
        tag = inner.tag if inner is not None else ""
        geometry = parsed.geometry
        if tag == "box":
            x, y, z = (float(v) for v in geometry.box.size)
            return Box((x, y, z))
        if tag == "sphere":
            return Sphere(float(geometry.sphere.radius))
        if tag in ("cylinder", "capsule"):
            kind = Cylinder if tag == "cylinder" else Capsule
            return kind(float(geometry.cylinder.radius), float(geometry.cylinder.length))
        factors = 1.0 if geometry.mesh.scale is None else geometry.mesh.scale
        x, y, z = (float(v) for v in np.broadcast_to(np.asarray(factors, dtype=np.float64), (3,)))
        uri = str(geometry.mesh.filename)
        path = self._refer(_role(element), uri, element.line, link=link, index=index)
        return MeshShape(uri, path, (x, y, z))

    def _refer(
        self,
        role: _Role,
        uri: str,
        line: int,
        *,
        link: str | None = None,
        index: int | None = None,
    ) -> Path | None:
        resolution = self._lookup.resolve(uri)
        self._references.append(Reference(role, uri, resolution, link, index, line))
        finding = resolution.finding(self._at(line), link=link, severity=_SEVERITY[role])
        if finding is not None:
            self._findings.append(finding)
        return resolution.path

    def _other_references(self, root: Element) -> None:
        """Textures, and what extensions (Gazebo, sensors, plugins) name by a package."""
        known = {
            id(part)
            for link in root.all("link")
            for item in link.children
            if item.tag in ("collision", "visual")
            for part in item.walk()
        }
        for element in root.walk():
            uri = element.attributes.get("filename", "")
            if element.tag == "texture" and uri:
                self._refer("texture", uri, element.line)
            elif id(element) in known:
                continue
            elif element.tag == "mesh" and uri:
                self._refer("other", uri, element.line)
            elif not element.children and _is_uri(element.text):
                self._refer("other", element.text.strip(), element.line)

    def _joints(self, elements: Sequence[Element], links: set[str]) -> tuple[Joint, ...]:
        found: dict[str, Joint] = {}
        parents: dict[str, str] = {}
        for element, parsed in zip(elements, values.parse_joints(elements), strict=True):
            name = element.attributes["name"]
            for odd in checks.odd_numbers(element.all("origin") + element.all("axis")):
                self._say("AP105", element.line, f"joint '{name}' {odd}")
            wrong = checks.wrong_joint(parsed, links)
            if wrong is None and parents.get(parsed.child, name) != name:
                wrong = f"is a second parent of link '{parsed.child}' ('{parents[parsed.child]}')"
            if wrong is not None:
                self._say(
                    "AP105",
                    element.line,
                    f"joint '{name}' {wrong}; it is ignored in kinematics",
                    severity=Severity.ERROR,
                )
                continue
            parents[parsed.child] = name
            found[name] = self._joint(element, parsed)
        kept = {n: found[n] for n in _without_loops(found, self)}
        dead = _dead_mimics(kept)
        return tuple(self._with_sound_mimic(joint, dead) for joint in kept.values())

    def _with_sound_mimic(self, joint: Joint, dead: Mapping[str, str]) -> Joint:
        """The joint; without its mimic where that leads nowhere or in a circle."""
        if joint.mimic is None or joint.name not in dead:
            return joint
        self._say(
            "AP105",
            joint.line,
            f"joint '{joint.name}' mimics '{joint.mimic.joint}': {dead[joint.name]}; "
            "it counts as free",
            severity=Severity.ERROR,
        )
        return replace(joint, mimic=None)

    def _joint(self, element: Element, parsed: Any) -> Joint:
        length = float(np.linalg.norm(parsed.axis))
        axis = np.asarray(parsed.axis, dtype=np.float64)
        limit = None
        if parsed.limit is not None:
            numbers = (parsed.limit.lower, parsed.limit.upper, parsed.limit.effort)
            lower, upper, effort = (_finite(v) for v in numbers)
            limit = Limit(lower, upper, effort, _finite(parsed.limit.velocity))
            if lower is not None and upper is not None and lower > upper:
                self._say(
                    "AP105",
                    element.line,
                    f"joint '{parsed.name}' has its lower limit {lower:g} above its upper "
                    f"limit {upper:g}",
                )
        mimic = None
        if parsed.mimic is not None:
            multiplier = 1.0 if parsed.mimic.multiplier is None else parsed.mimic.multiplier
            offset = 0.0 if parsed.mimic.offset is None else parsed.mimic.offset
            mimic = Mimic(str(parsed.mimic.joint), float(multiplier), float(offset))
        return Joint(
            name=str(parsed.name),
            type=parsed.type,
            parent=str(parsed.parent),
            child=str(parsed.child),
            parent_from_joint=values.pose(parsed.origin),
            axis=locked(axis / length if length > 0.0 else np.array([1.0, 0.0, 0.0])),
            limit=limit,
            mimic=mimic,
            line=element.line,
        )


def _role(element: Element) -> _Role:
    return "collision" if element.tag == "collision" else "visual"


def _finite(value: float | None) -> float | None:
    return float(value) if value is not None and math.isfinite(value) else None


def _is_uri(text: str) -> bool:
    return text.strip().lower().startswith(("package://", "model://", "file://"))


def _dead_mimics(joints: Mapping[str, Joint]) -> dict[str, str]:
    """Joints that follow none that is free, and why; each joint is looked at once."""
    dead: dict[str, str] = {}
    sound: set[str] = set()
    for start in joints:
        path: dict[str, None] = {}
        name = start
        why = ""
        while not why and name not in sound:
            if name not in joints:
                why = unknown_name("joint", name, joints)
            elif name in dead:
                why = dead[name]
            elif name in path:
                why = "mimics itself"
            else:
                path[name] = None
                mimic = joints[name].mimic
                if mimic is None:
                    break
                name = mimic.joint
        if why:
            dead |= dict.fromkeys(path, why)
        else:
            sound.update(path)
    return dead


def _without_loops(joints: Mapping[str, Joint], reader: _Reader) -> list[str]:
    """Names of the joints, those that close a loop left out and told."""
    parent_joint = {joint.child: joint for joint in joints.values()}
    order = {name: k for k, name in enumerate(joints)}
    safe: set[str] = set()
    dropped: set[str] = set()
    for start in joints.values():
        path: list[Joint] = []
        joint: Joint | None = start
        while joint is not None and joint.name not in safe and joint not in path:
            path.append(joint)
            joint = parent_joint.get(joint.parent)
        if joint is not None and joint in path:
            closing = max(path[path.index(joint) :], key=lambda item: order[item.name])
            dropped.add(closing.name)
            del parent_joint[closing.child]
            reader._say(
                "AP105",
                closing.line,
                f"joint '{closing.name}' closes a loop; it is ignored in kinematics",
                severity=Severity.ERROR,
            )
        safe.update(item.name for item in path)
    return [name for name in joints if name not in dropped]
