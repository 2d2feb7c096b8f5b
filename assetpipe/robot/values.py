"""Numbers and names of links and joints, parsed by yourdfpy.

yourdfpy gets a URDF of our own making that holds only what it knows, so that nothing in a
stranger's file reaches its parser unchecked, it loads no mesh, and what it refuses can be
told with the line in the original.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any
from xml.sax.saxutils import quoteattr

import numpy as np

from assetpipe.geometry.mesh import FloatArray, locked
from assetpipe.robot.markup import Element

if TYPE_CHECKING:
    import yourdfpy

_SHAPES = {
    "box": ("box", ("size",)),
    "cylinder": ("cylinder", ("radius", "length")),
    # the same two numbers; yourdfpy does not know capsules
    "capsule": ("cylinder", ("radius", "length")),
    "sphere": ("sphere", ("radius",)),
    "mesh": ("mesh", ("filename", "scale")),
}
KNOWN_SHAPES = frozenset(_SHAPES)
"""Tags inside of ``<geometry>`` that are understood."""

COUNTS = {"xyz": 3, "rpy": 3, "size": 3, "scale": 3}
"""How many numbers an attribute has at most."""

_JOINT_PARTS = {
    "parent": ("link",),
    "child": ("link",),
    "origin": ("xyz", "rpy"),
    "axis": ("xyz",),
    "limit": ("lower", "upper", "effort", "velocity"),
    "mimic": ("joint", "multiplier", "offset"),
}


@dataclass(frozen=True)
class Unreadable:
    """Why an element could not be parsed."""

    reason: str


def parse_shapes(elements: Sequence[Element]) -> list[Any]:
    """``yourdfpy.Collision`` for each collision or visual element, or :class:`Unreadable`."""
    return _parse([_link(element) for element in elements], "links")


def parse_joints(elements: Sequence[Element]) -> list[Any]:
    """``yourdfpy.Joint`` for each joint element, or :class:`Unreadable`."""
    return _parse([_joint(element) for element in elements], "joints")


def shape_of(element: Element) -> Element | None:
    """The first element inside of ``<geometry>``, the one that URDF consumers read."""
    geometry = element.first("geometry")
    return None if geometry is None else next(iter(geometry.children), None)


def pose(matrix: FloatArray | None) -> FloatArray:
    """A locked (4, 4) matrix; the identity for ``None``."""
    found = np.eye(4) if matrix is None else np.array(matrix, dtype=np.float64)
    return locked(found)


def _parse(fragments: list[str], kind: str) -> list[Any]:
    if not fragments:
        return []
    try:
        return _items(_load(fragments), kind)
    except Exception:  # noqa: BLE001 - it raises whatever its conversions raise
        return [_one(fragment, kind) for fragment in fragments]


def _one(fragment: str, kind: str) -> Any:
    try:
        return _items(_load([fragment]), kind)[0]
    except Exception as error:  # noqa: BLE001
        return Unreadable(_reason(error))


def _load(fragments: list[str]) -> yourdfpy.Robot:
    import yourdfpy

    text = f'<robot name="robot">{"".join(fragments)}</robot>'
    # what is not finite is told later
    with np.errstate(all="ignore"):
        model = yourdfpy.URDF.load(
            io.BytesIO(text.encode("utf-8", "xmlcharrefreplace")),
            build_scene_graph=False,
            load_meshes=False,
        )
    return model.robot


def _items(robot: yourdfpy.Robot, kind: str) -> list[Any]:
    if kind == "joints":
        return list(robot.joints)
    return [link.collisions[0] for link in robot.links]


def _reason(error: Exception) -> str:
    if isinstance(error, KeyError):
        return f"attribute {error} is missing"
    if isinstance(error, AttributeError):
        return "an element that it needs is missing"
    return str(error) or type(error).__name__


def _link(element: Element) -> str:
    shape = shape_of(element)
    if shape is not None and shape.tag in _SHAPES:
        tag, names = _SHAPES[shape.tag]
        inside = _tag(tag, shape, names)
    else:
        inside = '<sphere radius="0"/>'
    origin = element.first("origin")
    placed = _tag("origin", origin, ("xyz", "rpy")) if origin is not None else ""
    return f'<link name="link"><collision>{placed}<geometry>{inside}</geometry></collision></link>'


def _joint(element: Element) -> str:
    parts = [
        _tag(tag, found, names)
        for tag, names in _JOINT_PARTS.items()
        if (found := element.first(tag)) is not None
    ]
    return f"{_tag('joint', element, ('name', 'type'))[:-2]}>{''.join(parts)}</joint>"


def _tag(tag: str, element: Element, names: Sequence[str]) -> str:
    given = {name: element.attributes[name] for name in names if name in element.attributes}
    # some write "0, 0, 1" or "1 1 1 1"
    given |= {
        name: " ".join(given[name].replace(",", " ").split()[:count])
        for name, count in COUNTS.items()
        if name in given
    }
    written = "".join(f" {name}={quoteattr(value, _WHITE)}" for name, value in given.items())
    return f"<{tag}{written}/>"


_WHITE = {"\n": "&#10;", "\r": "&#13;", "\t": "&#9;"}
