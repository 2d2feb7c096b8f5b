"""OFF (Object File Format), also with colours, normals or texture coordinates in its header."""

from __future__ import annotations

import re
from itertools import chain
from pathlib import Path

import numpy as np

from assetpipe.errors import InputError, Location
from assetpipe.geometry.formats.polygons import triangulated
from assetpipe.geometry.formats.raw import FileLimits, RawMesh, floats, integers
from assetpipe.geometry.mesh import FloatArray, IntArray

_HEAD = re.compile(rb"^\s*(?:#[^\n]*\n\s*)*((?:ST)?C?N?OFF)\b")
_Row = tuple[int, list[bytes]]


def looks_like(data: bytes) -> bool:
    """Whether the text begins as an OFF does."""
    return _HEAD.match(data[:4096]) is not None


def read(data: bytes, path: Path, limits: FileLimits) -> RawMesh:
    """Read an ASCII OFF.

    Raises:
        InputError: with the line: a count that lies, no number, an index that names no vertex.
        LimitError: more vertices or triangles than allowed.
    """
    match = _HEAD.match(data)
    if match is None or data[match.end() :].lstrip()[:6].upper() == b"BINARY":
        raise InputError("not an ASCII OFF file", location=Location(path, 1))
    first = data.count(b"\n", 0, match.end()) + 1
    lines = enumerate(data[match.end() :].split(b"\n"), start=first)
    split = ((line, text.split(b"#", 1)[0].split()) for line, text in lines)
    rows: list[_Row] = [(line, words) for line, words in split if words]
    if not rows:
        raise InputError("no counts", location=Location(path, first))
    at = Location(path, rows[0][0])
    promised = integers(b" ".join(rows[0][1][:2]), "counts", at)
    n, m = (int(x) for x in promised) if len(promised) == 2 else (-1, -1)
    if n < 0 or m < 0 or len(rows) < 1 + n + m:
        raise InputError(
            f"truncated: {n:,} vertices and {m:,} faces promised, {len(rows) - 1:,} lines follow",
            location=at,
        )
    limits.check("vertices", n, path)
    vertices = _vertices(rows[1 : 1 + n], path)
    corners, counts = _faces(rows[1 + n : 1 + n + m], n, path)
    limits.check("faces", int(np.maximum(counts - 2, 0).sum()), path)
    return RawMesh(vertices, triangulated(vertices, corners, counts))


def _vertices(rows: list[_Row], path: Path) -> FloatArray:
    try:
        return np.array([words[:3] for _, words in rows], dtype=np.float64).reshape(len(rows), 3)
    except ValueError:
        for line, words in rows:
            values = floats(b" ".join(words[:3]), "vertex", Location(path, line))
            if len(values) != 3:
                raise InputError(
                    f"vertex with {len(values)} coordinates instead of 3",
                    location=Location(path, line),
                ) from None
        raise


def _faces(rows: list[_Row], n_vertices: int, path: Path) -> tuple[IntArray, IntArray]:
    given: list[list[bytes]] = []
    for line, words in rows:
        size = int(integers(words[0], "face", Location(path, line))[0])
        if not 0 <= size < len(words):
            raise InputError(
                f"face with {len(words) - 1} of {size} corners", location=Location(path, line)
            )
        given.append(words[1 : 1 + size])
    counts = np.array([len(words) for words in given], dtype=np.int64)
    try:
        corners = np.array(list(chain.from_iterable(given)), dtype=np.int64)
    except (ValueError, OverflowError):
        for (line, _), words in zip(rows, given, strict=True):
            integers(b" ".join(words), "face", Location(path, line))
        raise
    wrong = np.flatnonzero((corners < 0) | (corners >= n_vertices))
    if wrong.size:
        face = int(np.searchsorted(np.cumsum(counts), wrong[0], side="right"))
        raise InputError(
            f"face names vertex {int(corners[wrong[0]])}, but the file has {n_vertices:,}",
            location=Location(path, rows[face][0]),
        )
    return corners, counts
