"""Write a URDF that differs from the one read in named ``<collision>`` elements only.

Nothing is serialised again: the bytes of those elements are exchanged in the source, so
comments, attribute order, quotes, white space, line endings, encoding and tags that we know
nothing of stay byte for byte. Each new element is a copy of the old one's text in which the
shape and, where there is one, the name are exchanged; its ``<origin>`` and everything else in
it stays.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from assetpipe.errors import InputError, Location, UsageError, unknown_name
from assetpipe.geometry.mesh import FloatArray
from assetpipe.robot.markup import Element, Markup, read_markup
from assetpipe.robot.model import Box, Capsule, Cylinder, Robot, Sphere
from assetpipe.robot.splice import (
    Edit,
    attribute_text,
    indentation,
    newline,
    removal_edit,
    spliced,
    value_edit,
)


@dataclass(frozen=True)
class HullMesh:
    """A mesh file in the shape's frame, scale baked in: the element gets no ``scale``."""

    uri: str


NewShape = HullMesh | Box | Cylinder | Sphere | Capsule


@dataclass(frozen=True, eq=False)
class NewCollision:
    """One ``<collision>`` element to write.

    Attributes:
        shape: what it holds.
        origin: ``"kept"``: as written in the element that it replaces; else (4, 4)
            ``link_from_shape``.
    """

    shape: NewShape
    origin: FloatArray | Literal["kept"] = "kept"


def write_urdf(
    robot: Robot,
    replacements: Mapping[tuple[str, int], Sequence[NewCollision]],
    additions: Mapping[str, Sequence[NewCollision]] | None = None,
) -> bytes:
    """The robot's URDF with some collision elements exchanged.

    Args:
        robot: as read; :attr:`Robot.source` is what is patched.
        replacements: by link name and index among the link's collision elements; several
            elements may take the place of one, and none takes it away.
        additions: elements for links, by name, to stand after their last collision or
            visual element; their origin must be given.

    Returns:
        The file's bytes; the very same as read when nothing is asked.

    Raises:
        UsageError: no such link or collision element, or an addition without origin.
        InputError: bytes in a legacy encoding that don't come back the same.
    """
    markup = read_markup(robot.source, robot.path)
    links = _links(markup)
    edits: list[Edit] = []
    for name, index in replacements:
        if name not in links:
            raise UsageError(unknown_name("link", name, links))
        count = len(links[name].all("collision"))
        if not 0 <= index < count:
            raise UsageError(f"link '{name}' has no collision {index}; it has {count}")
    taken = _names(markup)
    for (name, index), elements in replacements.items():
        old = links[name].all("collision")[index]
        edits.append(_replacement(markup, old, elements, taken))
    for name, elements in (additions or {}).items():
        if name not in links:
            raise UsageError(unknown_name("link", name, links))
        if elements:
            edits.append(_addition(markup, links[name], elements))
    if not edits:
        return robot.source
    text = spliced(markup.text, edits)
    if markup.encoding == "utf-8":
        return text
    if _encoded(markup.text, markup, robot) != robot.source:
        raise InputError(
            f"its {markup.encoding} cannot be written back to the same bytes; save it as UTF-8",
            location=Location(robot.path),
        )
    return _encoded(text, markup, robot)


def _links(markup: Markup) -> dict[str, Element]:
    """Link elements by name, the first of each as in the reader."""
    found: dict[str, Element] = {}
    for link in markup.root.all("link"):
        if link.attributes.get("name"):
            found.setdefault(link.attributes["name"], link)
    return found


def _names(markup: Markup) -> set[str]:
    """Names of all collision elements."""
    return {
        collision.attributes["name"]
        for link in markup.root.all("link")
        for collision in link.all("collision")
        if "name" in collision.attributes
    }


def _encoded(text: bytes, markup: Markup, robot: Robot) -> bytes:
    """UTF-8 back into the encoding of the source, with the source's byte order mark."""
    if markup.encoding not in ("utf-16", "utf-32"):
        # what the encoding cannot say, character references can
        return text.decode("utf-8").encode(markup.encoding, "xmlcharrefreplace")
    order = "be" if robot.source[:2] == b"\xfe\xff" or robot.source[:2] == b"\x00\x00" else "le"
    return ("\ufeff" + text.decode("utf-8")).encode(f"{markup.encoding}-{order}")


def _replacement(
    markup: Markup, old: Element, elements: Sequence[NewCollision], taken: set[str]
) -> Edit:
    # PyBullet does not read lines of more than 8,190 bytes: each element gets one of its own
    glue = _line_break(markup.text, old.start)
    names = _fresh(old.attributes.get("name"), len(elements), taken)
    # without any element the white space around stays: it is not part of the old one
    copies = [_copy(markup, old, new, name) for new, name in zip(elements, names, strict=True)]
    return Edit(old.start, old.end, glue.join(copies))


def _fresh(name: str | None, count: int, taken: set[str]) -> list[str | None]:
    """Names for the elements that replace one: its own for a single one, else numbered."""
    if name is None or count == 1:
        return [name] * count
    found: list[str | None] = []
    number = 0
    while len(found) < count:
        candidate = f"{name}_{number}"
        number += 1
        if candidate not in taken:
            taken.add(candidate)
            found.append(candidate)
    return found


def _copy(markup: Markup, old: Element, new: NewCollision, name: str | None) -> bytes:
    """The old element's text with its name, origin and shape exchanged."""
    text = markup.text
    edits: list[Edit | None] = []
    if name is not None:
        edits.append(value_edit(text, old, "name", name))
    geometry = old.first("geometry")
    if not isinstance(new.origin, str):
        edits.append(_origin_edit(markup, old, geometry, new.origin))
    edits += _shape_edits(markup, old, geometry, new)
    shifted = [Edit(e.start - old.start, e.end - old.start, e.text) for e in edits if e is not None]
    return spliced(markup.of(old), shifted)


def _shape_edits(
    markup: Markup, old: Element, geometry: Element | None, new: NewCollision
) -> Iterable[Edit | None]:
    text = markup.text
    shapes = geometry.children if geometry is not None else ()
    if len(shapes) == 1 and shapes[0].tag == "mesh" and isinstance(new.shape, HullMesh):
        mesh = shapes[0]
        named = value_edit(text, mesh, "filename", new.shape.uri)
        if named is not None:
            return [named, removal_edit(text, mesh, "scale")]
    written = _shape_text(new)
    if shapes:
        return [
            Edit(shapes[0].start, shapes[0].end, written),
            *(Edit(other.start, other.end, b"") for other in shapes[1:]),
        ]
    whole = b"<geometry>" + written + b"</geometry>"
    if geometry is not None:
        return [Edit(geometry.start, geometry.end, whole)]
    if old.inner_end is not None:
        return [Edit(old.inner_end, old.inner_end, whole)]
    # <collision/>: its "/>" becomes ">…</collision>"
    closing = b">" + whole + b"</" + old.tag.encode("utf-8") + b">"
    return [Edit(old.end - 2, old.end, closing)]


def _origin_edit(
    markup: Markup, old: Element, geometry: Element | None, origin: FloatArray
) -> Edit | None:
    written = _origin_text(origin)
    element = old.first("origin")
    if element is not None:
        return Edit(element.start, element.end, written)
    if geometry is None:
        raise UsageError("a collision element without <geometry> cannot get an origin")
    indent = indentation(markup.text, geometry.start)
    glue = b"" if indent is None else newline(markup.text, geometry.start) + indent
    return Edit(geometry.start, geometry.start, written + glue)


def _line_break(text: bytes, at: int) -> bytes:
    """The end of a line, and the indentation of the element at an offset."""
    return newline(text, at) + (indentation(text, at) or b"")


def _addition(markup: Markup, link: Element, elements: Sequence[NewCollision]) -> Edit:
    text = markup.text
    written = []
    for new in elements:
        if isinstance(new.origin, str):
            raise UsageError("an added collision element needs an origin")
        written.append(
            b"<collision>" + _origin_text(new.origin) + b"<geometry>" + _shape_text(new)
            + b"</geometry></collision>"
        )  # fmt: skip
    before = [child for child in link.children if child.tag in ("collision", "visual")]
    if not before:
        before = list(link.children)
    if before:
        last = before[-1]
        glue = _line_break(text, last.start)
        return Edit(last.end, last.end, glue + glue.join(written))
    outer = _line_break(text, link.start)
    inner = outer + (b"\t" if b"\t" in outer else b"  ")
    body = inner + inner.join(written)
    if link.inner_end is not None:
        # the white space before </link> stays where it is
        start = len(text[: link.inner_end].rstrip())
        return Edit(start, start, body if start < link.inner_end else body + outer)
    return Edit(link.end - 2, link.end, b">" + body + outer + b"</link>")


def _shape_text(new: NewCollision) -> bytes:
    shape = new.shape
    if isinstance(shape, HullMesh):
        return b'<mesh filename="' + attribute_text(shape.uri, b'"') + b'"/>'
    if isinstance(shape, Box):
        return f'<box size="{_row(shape.size)}"/>'.encode()
    if isinstance(shape, Sphere):
        return f'<sphere radius="{shape.radius!r}"/>'.encode()
    tag = "cylinder" if isinstance(shape, Cylinder) else "capsule"
    return f'<{tag} radius="{shape.radius!r}" length="{shape.length!r}"/>'.encode()


def _origin_text(matrix: FloatArray) -> bytes:
    m = np.asarray(matrix, dtype=np.float64)
    return f'<origin xyz="{_row(m[:3, 3])}" rpy="{_row(roll_pitch_yaw(m[:3, :3]))}"/>'.encode()


def _row(values: Iterable[float]) -> str:
    return " ".join(repr(float(v) + 0.0) for v in values)


def roll_pitch_yaw(rotation: FloatArray) -> tuple[float, float, float]:
    """Angles about the fixed x, y and z axes, radians: R = Rz(yaw) · Ry(pitch) · Rx(roll).

    At a pitch of ±90°, where only a sum of the others is defined, roll is zero.
    """
    r = np.asarray(rotation, dtype=np.float64)
    across = float(np.hypot(r[0, 0], r[1, 0]))
    pitch = float(np.arctan2(-r[2, 0], across))
    if across > 1e-9:
        return float(np.arctan2(r[2, 1], r[2, 2])), pitch, float(np.arctan2(r[1, 0], r[0, 0]))
    return 0.0, pitch, float(np.arctan2(-r[0, 1], r[1, 1]))
