"""PLY, ASCII and binary, of triangles or polygons.

Format: Turk, G. "The PLY Polygon File Format", 1994.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt

from assetpipe.errors import InputError, Location
from assetpipe.geometry.formats.polygons import triangulated
from assetpipe.geometry.formats.raw import FileLimits, RawMesh, floats
from assetpipe.geometry.mesh import FloatArray, IntArray

_FORMAT = re.compile(r"^format\s+(ascii|binary_little_endian|binary_big_endian)\s+1\.0\s*$")
_ELEMENT = re.compile(r"^element\s+(\w+)\s+(\d{1,18})\s*$")
_TYPES = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    "float16": "f2",
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    "int64": "i8",
    "uint64": "u8",
    **dict.fromkeys(("double", "float64"), "f8"),
}
_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">", "ascii": ""}
_CORNERS = ("vertex_indices", "vertex_index")


@dataclass(frozen=True)
class _Property:
    """One value, or with ``counted`` as many as a value of that type says before them."""

    name: str
    kind: str
    counted: str | None = None


@dataclass(frozen=True)
class _Element:
    name: str
    rows: int
    properties: tuple[_Property, ...]

    @property
    def lists(self) -> bool:
        return any(p.counted for p in self.properties)


@dataclass(frozen=True)
class _Header:
    """``order`` is a byte order, empty for ASCII; the data begin at ``end``."""

    order: str
    elements: tuple[_Element, ...]
    end: int


@dataclass(frozen=True, eq=False)
class _Rows:
    """What is wanted of an element.

    Attributes:
        columns: (rows,) of each property that is no list, where all rows are alike.
        corners: the lists that name vertices, one after the other.
        counts: (rows,) how long each is.
    """

    columns: dict[str, FloatArray]
    corners: IntArray
    counts: IntArray


def looks_like(data: bytes) -> bool:
    """Whether the data begin as a PLY does."""
    return data[:4] in (b"ply\n", b"ply\r")


def read(data: bytes, path: Path, limits: FileLimits) -> RawMesh:
    """Read a PLY; polygons become triangles.

    Raises:
        InputError: a header that lies, missing data, an index that names no vertex.
        LimitError: more vertices or triangles than allowed.
    """
    header = _header(data, path)
    for element in header.elements:
        # What is neither has a row a vertex, or fewer.
        limits.check("faces" if element.name == "face" else "vertices", element.rows, path)
    rows = (_binary if header.order else _ascii)(data, header, path, limits)
    try:
        vertices = np.stack([rows["vertex"].columns[axis] for axis in "xyz"], axis=1)
    except KeyError as error:
        raise InputError(f"no {error} of vertices", location=Location(path)) from None
    if "face" not in rows:
        return RawMesh(vertices, np.zeros((0, 3), dtype=np.int64))
    corners, sizes = rows["face"].corners, rows["face"].counts
    wrong = np.flatnonzero((corners < 0) | (corners >= len(vertices)))
    if wrong.size:
        raise InputError(
            f"face names vertex {int(corners[wrong[0]])}, but the file has {len(vertices):,}",
            location=Location(path),
        )
    return RawMesh(vertices, triangulated(vertices, corners, sizes))


def _header(data: bytes, path: Path) -> _Header:
    """What the data hold; the least they must hold is compared with what follows."""
    match = re.search(rb"^end_header[ \t]*\r?\n", data[: 1 << 20], re.MULTILINE)
    if not looks_like(data) or match is None:
        raise InputError("not a PLY file: no 'ply … end_header'", location=Location(path, 1))
    order = None
    named: list[tuple[str, int]] = []
    properties: list[list[_Property]] = []
    least = 0
    for line, text in enumerate(data[: match.start()].decode("latin-1").splitlines(), start=1):
        words = text.split()
        if words[:1] == ["format"]:
            kind = _FORMAT.match(text.strip())
            if kind is None:
                raise InputError(f"unknown '{text.strip()[:80]}'", location=Location(path, line))
            order = _ORDERS[kind[1]]
        elif words[:1] == ["element"]:
            element = _ELEMENT.match(text.strip())
            if element is None or element[1] in dict(named):
                raise _unreadable(text, path, line)
            named.append((element[1], int(element[2])))
            properties.append([])
        elif words[:1] == ["property"]:
            known = _property(words)
            if known is None or not named:
                raise _unreadable(text, path, line)
            properties[-1].append(known)
            # a list may be empty, but its count is there
            size = np.dtype(known.counted or known.kind).itemsize if order else 2
            least += named[-1][1] * size
    if order is None:
        raise InputError("no format in the header", location=Location(path, 1))
    if least - 1 > len(data) - match.end():
        raise InputError(
            f"truncated: the header promises at least {least:,} bytes of data, "
            f"{len(data) - match.end():,} follow",
            location=Location(path),
        )
    elements = tuple(
        _Element(name, rows, tuple(own))
        for (name, rows), own in zip(named, properties, strict=True)
        if own
    )
    return _Header(order, elements, match.end())


def _unreadable(text: str, path: Path, line: int) -> InputError:
    return InputError(f"unreadable '{text.strip()[:80]}'", location=Location(path, line))


def _property(words: Sequence[str]) -> _Property | None:
    kinds = [_TYPES.get(word) for word in words[1:-1] if word != "list"]
    if len(words) == 3 and len(kinds) == 1 and kinds[0] is not None:
        return _Property(words[2], kinds[0])
    if len(words) == 5 and words[1] == "list" and len(kinds) == 2:
        counted, kind = kinds
        if counted is not None and kind is not None and counted[0] != "f":
            return _Property(words[4], kind, counted)
    return None


def _binary(data: bytes, header: _Header, path: Path, limits: FileLimits) -> dict[str, _Rows]:
    found: dict[str, _Rows] = {}
    at = header.end
    for element in header.elements:
        sizes = _first_sizes(data, at, element, header.order)
        row = np.dtype(
            [
                field
                for i, (p, n) in enumerate(zip(element.properties, sizes, strict=True))
                for field in (
                    *([(f"count {i}", header.order + p.counted)] if p.counted else []),
                    (f"value {i}", header.order + p.kind, (n,) if p.counted else ()),
                )
            ]
        )
        alike = element.rows * row.itemsize <= len(data) - at
        if alike:
            rows = np.frombuffer(data, row, element.rows, at)
            alike = all(
                (rows[f"count {i}"] == sizes[i]).all()
                for i, p in enumerate(element.properties)
                if p.counted
            )
        if alike:
            values = [rows[f"value {i}"] for i in range(len(sizes))]
            found[element.name] = _of_columns(element, values, path, limits)
            at += rows.nbytes
        elif element.lists:
            places, at = _walked(data, at, element, header.order, path)
            _check_corners(places[:, 1], path, limits)
            found[element.name] = _gathered(data, places, element, header.order)
        else:
            raise _cut_short(element, path)
    return found


def _first_sizes(data: bytes, at: int, element: _Element, order: str) -> list[int]:
    """How long the lists of the first row are; files tend to have all alike."""
    sizes = []
    for p in element.properties:
        size = 1
        if p.counted:
            width = np.dtype(p.counted).itemsize
            raw = data[at : at + width] if element.rows else b""
            size = int(np.frombuffer(raw, order + p.counted)[0]) if len(raw) == width else 0
            at += width
        width = np.dtype(p.kind).itemsize
        sizes.append(min(max(0, size), max(0, len(data) - at) // width))
        at += sizes[-1] * width
    return sizes


def _walked(
    data: bytes, at: int, element: _Element, order: str, path: Path
) -> tuple[IntArray, int]:
    """(rows, 2) place and length of the list of corners in each row, and where rows end."""
    wanted = _corners_of(element)
    signed = [p.counted is not None and p.counted[0] == "i" for p in element.properties]
    widths = [np.dtype(p.counted).itemsize if p.counted else 0 for p in element.properties]
    sizes = [np.dtype(p.kind).itemsize for p in element.properties]
    plan = list(zip(widths, sizes, signed, (i == wanted for i in range(len(sizes))), strict=True))
    endian: Literal["big", "little"] = "big" if order == ">" else "little"
    places = np.zeros((0 if wanted is None else element.rows, 2), dtype=np.int64)
    end = len(data)
    for row in range(element.rows):
        for width, size, sign, is_wanted in plan:
            count = 1
            if width:
                count = int.from_bytes(data[at : at + width], endian, signed=sign)
                at += width
            start = at
            at += count * size
            if count < 0 or at > end:
                raise _cut_short(element, path)
            if is_wanted:
                places[row] = start, count
    return places, at


def _gathered(data: bytes, places: IntArray, element: _Element, order: str) -> _Rows:
    """The corners at these places, see :func:`_walked`."""
    wanted = _corners_of(element)
    if wanted is None:
        return _Rows({}, np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64))
    kind = np.dtype(order + element.properties[wanted].kind)
    counts = places[:, 1]
    before = np.repeat(np.cumsum(counts) - counts, counts)
    starts = np.repeat(places[:, 0], counts) + (np.arange(len(before)) - before) * kind.itemsize
    raw = np.frombuffer(data, np.uint8)[starts[:, None] + np.arange(kind.itemsize)]
    corners = np.ascontiguousarray(raw).view(kind).ravel()
    return _Rows({}, corners.astype(np.int64), counts)


def _ascii(data: bytes, header: _Header, path: Path, limits: FileLimits) -> dict[str, _Rows]:
    values = floats(data[header.end :], "data", Location(path))
    found: dict[str, _Rows] = {}
    at = 0
    for element in header.elements:
        if not element.lists:
            size = element.rows * len(element.properties)
            if at + size > len(values):
                raise _cut_short(element, path)
            table = values[at : at + size].reshape(element.rows, len(element.properties))
            found[element.name] = _of_columns(element, list(table.T), path, limits)
            at += size
            continue
        wanted = _corners_of(element)
        lists: list[tuple[int, int]] = []
        for _ in range(element.rows):
            for i, p in enumerate(element.properties):
                count = 1.0
                if p.counted:
                    count = float(values[at]) if at < len(values) else -1.0
                    at += 1
                if not (0 <= count <= len(values) - at and count == int(count)):
                    raise _cut_short(element, path)
                if i == wanted:
                    lists.append((at, int(count)))
                at += int(count)
        found[element.name] = _of_lists(values, lists, path, limits)
    return found


def _check_corners(counts: IntArray, path: Path, limits: FileLimits) -> None:
    """Refuse polygons of more triangles than allowed, before they are gathered."""
    limits.check("faces", int(np.maximum(counts - 2, 0).sum()), path)


def _of_lists(
    values: FloatArray, lists: list[tuple[int, int]], path: Path, limits: FileLimits
) -> _Rows:
    counts = np.array([count for _, count in lists], dtype=np.int64)
    _check_corners(counts, path, limits)
    starts = np.array([start for start, _ in lists], dtype=np.int64)
    before = np.repeat(np.cumsum(counts) - counts, counts)
    corners = values[np.repeat(starts, counts) + np.arange(len(before)) - before]
    return _Rows({}, _whole(corners), counts)


def _of_columns(
    element: _Element,
    values: Sequence[npt.NDArray[np.generic]],
    path: Path,
    limits: FileLimits,
) -> _Rows:
    """Of rows that are all alike, values by property."""
    columns = {
        p.name: v.astype(np.float64)
        for p, v in zip(element.properties, values, strict=True)
        if not p.counted
    }
    wanted = _corners_of(element)
    none = np.zeros(0, dtype=np.int64)
    if wanted is None:
        return _Rows(columns, none, none)
    table = values[wanted]
    counts = np.full(element.rows, table.shape[1], dtype=np.int64)
    _check_corners(counts, path, limits)
    return _Rows(columns, _whole(table.astype(np.float64).ravel()), counts)


def _corners_of(element: _Element) -> int | None:
    """Which property names the corners of faces."""
    for i, p in enumerate(element.properties):
        if p.counted and p.name in _CORNERS:
            return i
    return None


def _whole(values: FloatArray) -> IntArray:
    """Indices; -1, which names no vertex, for what is none."""
    fit = np.isfinite(values) & (np.abs(values) < 2**53)
    safe = np.where(fit, values, -1.0)
    return np.where(safe == np.floor(safe), safe, -1.0).astype(np.int64)


def _cut_short(element: _Element, path: Path) -> InputError:
    return InputError(
        f"truncated: fewer data than {element.rows:,} of '{element.name}' need",
        location=Location(path),
    )
