"""PLY, ASCII and binary, read by trimesh behind a check of the header."""

from __future__ import annotations

import io
import re
from pathlib import Path

import numpy as np

from assetpipe.errors import InputError, Location
from assetpipe.geometry.formats.raw import FileLimits, RawMesh

_FORMAT = re.compile(r"^format\s+(ascii|binary_little_endian|binary_big_endian)\s+1\.0\s*$")
_ELEMENT = re.compile(r"^element\s+(\w+)\s+(\d+)\s*$")
_SIZES = {
    **dict.fromkeys(("char", "uchar", "int8", "uint8"), 1),
    **dict.fromkeys(("short", "ushort", "int16", "uint16", "float16"), 2),
    **dict.fromkeys(("int", "uint", "float", "int32", "uint32", "float32"), 4),
    **dict.fromkeys(("double", "int64", "uint64", "float64"), 8),
}


def looks_like(data: bytes) -> bool:
    """Whether the data begin as a PLY does."""
    return data[:4] in (b"ply\n", b"ply\r")


def read(data: bytes, path: Path, limits: FileLimits) -> RawMesh:
    """Read a PLY; polygons become fans, as in trimesh.

    Raises:
        InputError: a header that lies, missing data, an index that names no vertex.
        LimitError: more vertices or triangles than allowed.
    """
    counts = _checked_header(data, path)
    limits.check("vertices", counts.get("vertex", 0), path)
    limits.check("faces", counts.get("face", 0), path)
    from trimesh.exchange.ply import load_ply  # slow to import

    try:
        loaded = load_ply(io.BytesIO(data), skip_materials=True)
        vertices = np.asarray(loaded["vertices"], dtype=np.float64)
        faces = np.asarray(loaded.get("faces", np.zeros((0, 3))), dtype=np.int64)
    except Exception as error:  # whatever a stranger's file provokes in there
        raise InputError(f"not a readable PLY: {error}", location=Location(path)) from error
    if vertices.ndim != 2 or vertices.shape[1] != 3 or faces.ndim != 2 or faces.shape[1] != 3:
        raise InputError("not a PLY of triangles or polygons", location=Location(path))
    limits.check("faces", len(faces), path)
    if len(faces) and (faces.min() < 0 or faces.max() >= len(vertices)):
        raise InputError(
            f"face names vertex {int(faces.max())}, but the file has {len(vertices):,}",
            location=Location(path),
        )
    return RawMesh(vertices, faces)


def _checked_header(data: bytes, path: Path) -> dict[str, int]:
    """The counts of each element, after comparing them with the data that follow."""
    match = re.search(rb"^end_header[ \t]*\r?\n", data[: 1 << 20], re.MULTILINE)
    if not looks_like(data) or match is None:
        raise InputError("not a PLY file: no 'ply … end_header'", location=Location(path, 1))
    counts: dict[str, int] = {}
    least = 0
    row = 0
    binary = False
    for line, text in enumerate(data[: match.start()].decode("latin-1").splitlines(), start=1):
        words = text.split()
        if words[:1] == ["format"]:
            kind = _FORMAT.match(text.strip())
            if kind is None:
                raise InputError(f"unknown '{text.strip()}'", location=Location(path, line))
            binary = kind[1] != "ascii"
        elif words[:1] == ["element"]:
            element = _ELEMENT.match(text.strip())
            if element is None:
                raise InputError(f"unreadable '{text.strip()}'", location=Location(path, line))
            row = int(element[2])
            counts[element[1]] = row
        elif words[:1] == ["property"]:
            scalar = words[1] if len(words) == 3 else words[2] if len(words) == 5 else ""
            if scalar not in _SIZES:
                raise InputError(f"unreadable '{text.strip()}'", location=Location(path, line))
            # a list may be empty, but its count is there
            least += row * (_SIZES[scalar] if binary else 2)
    if least - 1 > len(data) - match.end():
        raise InputError(
            f"truncated: the header promises at least {least:,} bytes of data, "
            f"{len(data) - match.end():,} follow",
            location=Location(path),
        )
    return counts
