"""STL, binary and ASCII.

The header is no evidence (one binary file in eight begins with ``solid``): a file is binary
when its length fits its triangle count, and ASCII when it has ``facet`` text. Coordinates
are welded nowhere; three vertices a triangle, as in the file.
"""

from __future__ import annotations

import re
from itertools import islice
from pathlib import Path

import numpy as np

from assetpipe.errors import InputError, Location
from assetpipe.geometry.formats.raw import FileLimits, RawMesh, floats
from assetpipe.geometry.mesh import IntArray

_HEADER = 84
_RECORD = np.dtype([("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_VERTEX = re.compile(rb"^[ \t]*vertex\b[ \t]*([^\r\n]*)", re.IGNORECASE | re.MULTILINE)
_END = re.compile(rb"^[ \t]*end[ \t]*loop\b", re.IGNORECASE | re.MULTILINE)


def is_binary(data: bytes) -> bool:
    """Whether the length fits the triangle count of a binary STL."""
    return len(data) >= _HEADER and len(data) == _HEADER + _RECORD.itemsize * _count(data)


def is_ascii(data: bytes) -> bool:
    """Whether the text reads like an ASCII STL."""
    head = data[: 1 << 16].lstrip().lower()
    return head.startswith(b"solid") and (b"facet" in head or b"endsolid" in head)


def read(data: bytes, path: Path, limits: FileLimits) -> RawMesh:
    """Read an STL.

    Raises:
        InputError: truncated, a count that lies, a line that is no vertex.
        LimitError: more triangles than allowed.
    """
    if not is_binary(data) and is_ascii(data):
        return _read_ascii(data, path, limits)
    return _read_binary(data, path, limits)


def _count(data: bytes) -> int:
    return int.from_bytes(data[80:84], "little")


def _read_binary(data: bytes, path: Path, limits: FileLimits) -> RawMesh:
    if len(data) < _HEADER:
        raise InputError(
            f"not an STL: {len(data)} bytes are shorter than the header of a binary STL "
            "and there is no ASCII 'solid'",
            location=Location(path),
        )
    count = _count(data)
    held = (len(data) - _HEADER) // _RECORD.itemsize
    if held < count:
        if data.lstrip()[:1] == b"<":
            raise InputError(
                "not an STL: the file begins as a web page or XML does", location=Location(path)
            )
        raise InputError(
            f"truncated binary STL: the header promises {count:,} triangles, "
            f"the file holds {held:,}",
            location=Location(path),
        )
    limits.check("faces", count, path)
    spare = len(data) - _HEADER - count * _RECORD.itemsize
    notes = () if spare == 0 else (f"{spare} bytes after the last triangle ignored",)
    records = np.frombuffer(data, dtype=_RECORD, count=count, offset=_HEADER)
    vertices = records["corners"].reshape(-1, 3).astype(np.float64)
    return RawMesh(vertices, np.arange(3 * count, dtype=np.int64).reshape(-1, 3), notes=notes)


def _read_ascii(data: bytes, path: Path, limits: FileLimits) -> RawMesh:
    rows = list(islice(_VERTEX.finditer(data), 3 * (limits.max_faces + 1)))
    limits.check("faces", len(rows) // 3, path)
    try:
        values = np.array(b" ".join(row[1] for row in rows).split(), dtype=np.float64)
    except ValueError:
        for row in rows:
            floats(row[1], "vertex", Location(path, _line(data, row.start())))
        raise
    ends = np.array([end.start() for end in _END.finditer(data)], dtype=np.int64)
    starts = np.array([row.start() for row in rows], dtype=np.int64)
    corners = np.diff(np.searchsorted(starts, ends), prepend=0)
    if len(values) != 3 * len(rows) or len(starts) != 3 * len(ends) or (corners != 3).any():
        raise _located(data, path, corners, starts, ends)
    vertices = values.astype(np.float64).reshape(-1, 3)
    return RawMesh(vertices, np.arange(len(vertices), dtype=np.int64).reshape(-1, 3))


def _located(
    data: bytes,
    path: Path,
    corners: IntArray,
    starts: IntArray,
    ends: IntArray,
) -> InputError:
    """Find the first line that breaks the grammar."""
    for match in _VERTEX.finditer(data):
        if len(match[1].split()) != 3:
            return InputError(
                f"vertex with {len(match[1].split())} coordinates instead of 3",
                location=Location(path, _line(data, match.start())),
            )
    wrong = np.flatnonzero(corners != 3)
    if wrong.size:
        return InputError(
            f"facet with {int(corners[wrong[0]])} vertices instead of 3",
            location=Location(path, _line(data, int(ends[wrong[0]]))),
        )
    last = int(starts[3 * len(ends)]) if len(starts) > 3 * len(ends) else len(data)
    return InputError(
        "truncated ASCII STL: the last facet has no 'endloop'",
        location=Location(path, _line(data, min(last, len(data)))),
    )


def _line(data: bytes, offset: int) -> int:
    return data.count(b"\n", 0, offset) + 1
