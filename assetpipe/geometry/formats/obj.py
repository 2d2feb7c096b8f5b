"""Wavefront OBJ: positions and faces.

Own reading, because the usual readers are wrong where it hurts: trimesh takes index 0 for
the last vertex, drops indented lines and splits vertices at texture seams, which opens closed
surfaces. Vertices keep the file's own numbering here.
"""

from __future__ import annotations

import re
from itertools import islice
from pathlib import Path

import numpy as np
import numpy.typing as npt

from assetpipe.errors import InputError, LimitError, Location
from assetpipe.geometry.formats.polygons import triangulated
from assetpipe.geometry.formats.raw import FileLimits, RawMesh, floats, integers
from assetpipe.geometry.mesh import FloatArray, IntArray

_CONTINUED = re.compile(rb"\\[ \t]*\r?\n")
_STATEMENT = re.compile(rb"^[ \t]*(v|f|fo)[ \t]+([^\r\n#]*)", re.MULTILINE)
_REST = re.compile(rb"/[^\s]*")
_SURFACES = re.compile(rb"^[ \t]*(surf|curv|curv2|cstype)\b", re.MULTILINE)


def looks_like(data: bytes) -> bool:
    """Whether the text has both vertices and faces of an OBJ."""
    head = data[: 1 << 20]
    return bool(re.search(rb"^[ \t]*v[ \t]+\S+[ \t]+\S+[ \t]+\S+", head, re.MULTILINE)) and bool(
        re.search(rb"^[ \t]*f[ \t]+[-\d]+", data, re.MULTILINE)
    )


def read(data: bytes, path: Path, limits: FileLimits) -> RawMesh:
    """Read an OBJ; groups, objects, materials, normals and texture coordinates don't matter.

    Raises:
        InputError: with the line: no number, an index that names no vertex.
        LimitError: more vertices or triangles than allowed.
    """
    data = _CONTINUED.sub(_as_blank, data)
    kinds: list[bytes] = []
    bodies: list[bytes] = []
    offsets: list[int] = []
    most = limits.max_vertices + limits.max_faces
    for match in islice(_STATEMENT.finditer(data), most + 1):
        kinds.append(match[1])
        bodies.append(match[2])
        offsets.append(match.start(1))
    if len(kinds) > most:
        raise LimitError(f"more than {most:,} vertices and faces", location=Location(path))
    is_vertex = np.array([kind == b"v" for kind in kinds], dtype=bool)
    limits.check("vertices", int(is_vertex.sum()), path)
    text = _Text(data, path, offsets)
    vertices = _vertices(bodies, is_vertex, text)
    corners, counts = _faces(bodies, is_vertex, len(vertices), text)
    limits.check("faces", int(np.maximum(counts - 2, 0).sum()), path)
    faces = triangulated(vertices, corners, counts)
    notes = ("free-form surfaces ignored",) if _SURFACES.search(data) else ()
    return RawMesh(vertices, faces, notes=notes)


def _as_blank(match: re.Match[bytes]) -> bytes:
    """Join a continued line, keeping lengths so that offsets stay true."""
    return b" " * len(match[0])


class _Text:
    """Where a statement stands, looked up only when something is wrong."""

    def __init__(self, data: bytes, path: Path, offsets: list[int]) -> None:
        self._data = data
        self._offsets = offsets
        self.path = path

    def at(self, statement: int) -> Location:
        line = self._data.count(b"\n", 0, self._offsets[statement]) + 1
        return Location(self.path, line)


def _vertices(bodies: list[bytes], is_vertex: npt.NDArray[np.bool_], text: _Text) -> FloatArray:
    where = np.flatnonzero(is_vertex)
    words = [bodies[k].split() for k in where]
    try:
        # x y z, then a weight or a colour that we don't need
        return np.array([w[:3] for w in words], dtype=np.float64).reshape(len(words), 3)
    except ValueError:
        for k, w in zip(where, words, strict=True):
            if len(w) < 3:
                raise InputError(
                    f"vertex with {len(w)} coordinates instead of 3", location=text.at(int(k))
                ) from None
            floats(b" ".join(w[:3]), "vertex", text.at(int(k)))
        raise


def _faces(
    bodies: list[bytes],
    is_vertex: npt.NDArray[np.bool_],
    n_vertices: int,
    text: _Text,
) -> tuple[IntArray, IntArray]:
    where = np.flatnonzero(~is_vertex)
    words = [_REST.sub(b"", bodies[k]).split() for k in where]
    counts = np.array([len(w) for w in words], dtype=np.int64)
    flat = [word for w in words for word in w]
    try:
        given = np.array(flat, dtype=np.int64)
    except (ValueError, OverflowError):
        for k, w in zip(where, words, strict=True):
            integers(b" ".join(w), "face", text.at(int(k)))
        raise
    # negative indices count back from the vertices defined so far
    so_far = np.repeat(np.cumsum(is_vertex)[where], counts)
    corners = np.where(given < 0, so_far + given, given - 1)
    wrong = np.flatnonzero((given == 0) | (corners < 0) | (corners >= n_vertices))
    if wrong.size:
        face = int(np.searchsorted(np.cumsum(counts), wrong[0], side="right"))
        raise InputError(
            f"face names vertex {int(given[wrong[0]])}, but the file has {n_vertices:,}",
            location=text.at(int(where[face])),
        )
    return corners, counts
