"""The surfaces in a COLLADA ``<geometry>`` (COLLADA 1.4.1 §5: mesh and its primitives)."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np

from assetpipe.errors import InputError, Location
from assetpipe.geometry.formats.polygons import fan_triangles, strip_triangles, triangulated
from assetpipe.geometry.formats.raw import FileLimits, Part, floats, integers
from assetpipe.geometry.mesh import FloatArray, IntArray

if TYPE_CHECKING:
    from lxml.etree import _Element as Element

_NO_SURFACE = {"lines", "linestrips"}


def local(element: Element) -> str:
    """The tag without its namespace."""
    return str(element.tag).rpartition("}")[2]


def children(element: Element, *names: str) -> list[Element]:
    """Direct children with one of these tags."""
    return [child for child in element if local(child) in names]


def child(element: Element, name: str) -> Element | None:
    """The first direct child with this tag."""
    return next(iter(children(element, name)), None)


Ids = dict[tuple[str, str], "Element"]
"""Elements by tag and id."""


@dataclass(frozen=True)
class Document:
    """A COLLADA document and its ids.

    Ids should be unique in a document. In files merged from several they are not: each
    geometry then means its own sources, and of the rest the first one is taken.

    Attributes:
        file: for messages.
        limits: how much is read.
        ids: of the whole document; the first one wins.
        repeated: tags and ids that stand more than once.
        read: numbers of ``<float_array>`` read so far; any number of sources may share one.
        notes: what was guessed.
    """

    file: Path
    limits: FileLimits
    ids: Ids
    repeated: frozenset[tuple[str, str]] = frozenset()
    read: dict[Element, FloatArray] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    _own: dict[Element, Ids] = field(default_factory=dict)

    @classmethod
    def of(cls, root: Element, file: Path, limits: FileLimits) -> Document:
        """The document with this root element."""
        ids, repeated = _ids(root)
        return cls(file, limits, ids, repeated)

    def at(self, element: Element) -> Location:
        """Where an element stands."""
        return Location(self.file, cast("int | None", element.sourceline))

    def target(self, element: Element, attribute: str, kind: str) -> Element:
        """The element of this kind that a ``#id`` reference names.

        Raises:
            InputError: a reference to another file, to nothing, or to another kind.
        """
        value = element.get(attribute, "")
        if not value.startswith("#"):
            raise InputError(
                f"<{local(element)}> refers to '{value[:80]}': only references within the "
                "file are followed",
                location=self.at(element),
            )
        name = (kind, value[1:])
        if name in self.repeated:
            around = next(element.iterancestors("{*}geometry"), None)
            if around is not None and around not in self._own:
                self._own[around] = _ids(around)[0]
            if around is not None and name in self._own[around]:
                return self._own[around][name]
            self.notes.append(f"several <{kind}> are called '{value[1:81]}': the first was taken")
        if name not in self.ids:
            raise InputError(
                f"<{local(element)}> refers to <{kind}> '{value[1:81]}', which does not exist",
                location=self.at(element),
            )
        return self.ids[name]

    def numbers(self, array: Element) -> FloatArray:
        """What a ``<float_array>`` holds.

        Raises:
            InputError: a word that is no number.
        """
        if array not in self.read:
            self.read[array] = floats(array.text, "float_array", self.at(array))
        return self.read[array]

    def integer(self, element: Element, attribute: str, default: int) -> int:
        """A whole number in an attribute.

        Raises:
            InputError: no number, or negative.
        """
        text = element.get(attribute)
        if text is None:
            return default
        values = integers(text, attribute, self.at(element))
        if len(values) != 1 or values[0] < 0:
            raise InputError(f"{attribute}='{text[:40]}'", location=self.at(element))
        return int(values[0])


def _ids(root: Element) -> tuple[Ids, frozenset[tuple[str, str]]]:
    """Elements below one by tag and id, and which of these stand more than once."""
    ids: Ids = {}
    repeated = set()
    for element in root.iter():
        name = element.get("id")
        if name is not None and ids.setdefault((local(element), name), element) is not element:
            repeated.add((local(element), name))
    return ids, frozenset(repeated)


def surface(document: Document, geometry: Element) -> tuple[Part, tuple[str, ...]]:
    """The triangles of one ``<geometry>`` and notes on what in it is no surface.

    Raises:
        InputError: broken references, indices that name no vertex, unsupported content.
        LimitError: more vertices than allowed.
    """
    mesh = next(iter(children(geometry, "mesh", "convex_mesh")), None)
    if mesh is None:
        kind = local(geometry[0]) if len(geometry) else "nothing"
        return Part(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)), (
            f"geometry '{geometry.get('id', '')}' is {kind}, no mesh: ignored",
        )
    placed: dict[Element, tuple[int, FloatArray]] = {}
    faces: list[IntArray] = []
    notes: list[str] = []
    total = 0
    for primitive in mesh:
        kind = local(primitive)
        if kind in ("source", "vertices", "extra"):
            continue
        if kind in _NO_SURFACE:
            notes.append(f"<{kind}> in geometry '{geometry.get('id', '')}' ignored")
            continue
        if kind not in _READERS:
            raise InputError(f"unsupported <{kind}> in a mesh", location=document.at(primitive))
        source, offset, stride = _vertex_input(document, primitive)
        if source not in placed:
            placed[source] = total, _positions(document, source)
            total += len(placed[source][1])
            document.limits.check("vertices", total, document.file)
        start, points = placed[source]
        faces.append(_READERS[kind](document, primitive, points, offset, stride) + start)
    if not placed:
        return Part(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64)), tuple(notes)
    vertices = np.concatenate([points for _, points in placed.values()])
    return Part(vertices, np.concatenate(faces)), tuple(notes)


def _vertex_input(document: Document, primitive: Element) -> tuple[Element, int, int]:
    """The position source of a primitive, its offset in ``<p>`` and the stride of ``<p>``."""
    inputs = children(primitive, "input")
    stride = 1 + max((document.integer(i, "offset", 0) for i in inputs), default=0)
    for item in inputs:
        if item.get("semantic") == "VERTEX":
            vertices = document.target(item, "source", "vertices")
            for position in children(vertices, "input"):
                if position.get("semantic") == "POSITION":
                    source = document.target(position, "source", "source")
                    return source, document.integer(item, "offset", 0), stride
            raise InputError("<vertices> without POSITION", location=document.at(vertices))
    raise InputError(f"<{local(primitive)}> without VERTEX input", location=document.at(primitive))


def _positions(document: Document, source: Element) -> FloatArray:
    """(n, 3) coordinates through the accessor's offset, stride and named parameters."""
    technique = child(source, "technique_common")
    accessor = child(technique, "accessor") if technique is not None else None
    if accessor is None:
        raise InputError("<source> without accessor", location=document.at(source))
    array = document.target(accessor, "source", "float_array")
    values = document.numbers(array)
    count = document.integer(accessor, "count", 0)
    stride = document.integer(accessor, "stride", 1)
    offset = document.integer(accessor, "offset", 0)
    named = [k for k, param in enumerate(children(accessor, "param")) if param.get("name")]
    columns = np.array(named[:3] if len(named) >= 3 else [0, 1, 2])
    if stride < 3 or int(columns.max()) >= stride:
        raise InputError(f"positions with stride {stride}", location=document.at(accessor))
    if count and offset + (count - 1) * stride + int(columns.max()) >= len(values):
        raise InputError(
            f"{count:,} positions promised, the array holds {len(values):,} numbers",
            location=document.at(accessor),
        )
    document.limits.check("vertices", count, document.file)
    rows = offset + stride * np.arange(count)
    positions: FloatArray = values[rows[:, None] + columns]
    return positions


def _corners(
    document: Document, p: Element, points: FloatArray, offset: int, stride: int
) -> IntArray:
    """The vertex indices of one ``<p>``."""
    values = integers(p.text, "p", document.at(p))
    if len(values) % stride:
        raise InputError(
            f"<p> has {len(values):,} numbers, no multiple of {stride}", location=document.at(p)
        )
    corners: IntArray = values.reshape(-1, stride)[:, offset]
    if len(corners) and (corners.min() < 0 or corners.max() >= len(points)):
        wrong = int(corners.min()) if corners.min() < 0 else int(corners.max())
        raise InputError(
            f"<p> names vertex {wrong}, but there are {len(points):,}", location=document.at(p)
        )
    return corners


def _triangles(
    document: Document, primitive: Element, points: FloatArray, offset: int, stride: int
) -> IntArray:
    found = [np.zeros((0, 3), dtype=np.int64)]
    for p in children(primitive, "p"):
        corners = _corners(document, p, points, offset, stride)
        if len(corners) % 3:
            raise InputError(
                f"<triangles> with {len(corners):,} corners, no multiple of 3",
                location=document.at(p),
            )
        found.append(corners.reshape(-1, 3))
    return np.concatenate(found)


def _polylist(
    document: Document, primitive: Element, points: FloatArray, offset: int, stride: int
) -> IntArray:
    p, vcount = child(primitive, "p"), child(primitive, "vcount")
    if p is None or vcount is None:
        return np.zeros((0, 3), dtype=np.int64)
    corners = _corners(document, p, points, offset, stride)
    counts = integers(vcount.text, "vcount", document.at(vcount)).astype(np.int64)
    # In Python's numbers: those of numpy would come round to zero.
    total = sum(counts.tolist())
    if (counts < 0).any() or total != len(corners):
        raise InputError(
            f"<vcount> adds up to {total:,} corners, <p> has {len(corners):,}",
            location=document.at(vcount),
        )
    return triangulated(points, corners, counts)


def _polygons(
    document: Document, primitive: Element, points: FloatArray, offset: int, stride: int
) -> IntArray:
    holes = child(primitive, "ph")
    if holes is not None:
        raise InputError("polygons with holes are unsupported", location=document.at(holes))
    loops = [_corners(document, p, points, offset, stride) for p in children(primitive, "p")]
    if not loops:
        return np.zeros((0, 3), dtype=np.int64)
    counts = np.array([len(loop) for loop in loops], dtype=np.int64)
    return triangulated(points, np.concatenate(loops), counts)


def _strips(
    document: Document, primitive: Element, points: FloatArray, offset: int, stride: int
) -> IntArray:
    found = [np.zeros((0, 3), dtype=np.int64)]
    for p in children(primitive, "p"):
        corners = _corners(document, p, points, offset, stride)
        found.append(strip_triangles(corners))
    return np.concatenate(found)


def _fans(
    document: Document, primitive: Element, points: FloatArray, offset: int, stride: int
) -> IntArray:
    found = [np.zeros((0, 3), dtype=np.int64)]
    for p in children(primitive, "p"):
        corners = _corners(document, p, points, offset, stride)
        found.append(fan_triangles(corners))
    return np.concatenate(found)


_READERS = {
    "triangles": _triangles,
    "polylist": _polylist,
    "polygons": _polygons,
    "tristrips": _strips,
    "trifans": _fans,
}
