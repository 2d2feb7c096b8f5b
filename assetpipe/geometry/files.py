"""Mesh files in and out: STL, OBJ, DAE, GLB, glTF, PLY and OFF to one mesh in metres, Z-up."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from assetpipe.errors import InputError, LimitError, Location, MeshError, unknown_name
from assetpipe.geometry.formats import dae, gltf, obj, off, ply, stl
from assetpipe.geometry.formats.raw import FileLimits, RawMesh
from assetpipe.geometry.mesh import Mesh
from assetpipe.geometry.units import AxisPolicy, to_metres_z_up


@dataclass(frozen=True)
class LoadedMesh:
    """A mesh as read from a file.

    Attributes:
        mesh: in metres, Z-up; vertices and faces as in the file, nothing welded or repaired.
        format: what the content is, ``"stl"`` …, whatever the file is called.
        notes: unit or axis converted, things ignored, a name that lies.
    """

    mesh: Mesh
    format: str
    notes: tuple[str, ...]


@dataclass(frozen=True)
class _Format:
    read: Callable[[bytes, Path, FileLimits], RawMesh]
    recognise: Callable[[bytes], bool]


_FORMATS = {
    # in the order in which unknown content is tried: the surest signs first
    "gltf": _Format(gltf.read, gltf.looks_like),
    "ply": _Format(ply.read, ply.looks_like),
    "off": _Format(off.read, off.looks_like),
    "dae": _Format(dae.read, dae.looks_like),
    "stl": _Format(stl.read, lambda data: stl.is_binary(data) or stl.is_ascii(data)),
    "obj": _Format(obj.read, obj.looks_like),
}
_SUFFIXES = {".glb": "gltf", ".stlb": "stl"} | {f".{name}": name for name in _FORMATS}

SUFFIXES = tuple(sorted(_SUFFIXES))
"""Lower-case endings of the files that :func:`read_mesh` knows by name."""


def read_mesh(
    path: Path | str, *, limits: FileLimits | None = None, axes: AxisPolicy = "trusted"
) -> LoadedMesh:
    """Read a mesh file as one mesh in metres with Z up.

    All nodes of a scene are joined with their transforms applied; mirrored nodes keep their
    faces outward. COLLADA's ``<unit>`` is applied, and declared up-axes of COLLADA and glTF
    as :mod:`assetpipe.geometry.units` explains; both are told in ``notes``. What the content
    shows wins over the file's ending.

    Args:
        path: STL (ASCII or binary), OBJ, DAE, GLB, glTF, PLY or OFF.
        limits: how much is read before a file is refused.
        axes: whether a declared up-axis is believed.

    Raises:
        InputError: missing, unknown or broken file, with the line where there is one.
        LimitError: larger than the limits allow.
        MeshError: no triangles, or values that are not finite.
    """
    path = Path(path)
    limits = limits or FileLimits()
    data = _bytes(path, limits)
    name, note = _format(data, path)
    try:
        # what is not finite is an error at the end, not a warning on the way
        with np.errstate(all="ignore"):
            converted = to_metres_z_up(_FORMATS[name].read(data, path, limits), axes=axes)
    except MeshError as error:
        if error.location is None:
            raise MeshError(error.message, location=Location(path)) from error
        raise
    except MemoryError as error:
        raise LimitError("not enough memory to read it", location=Location(path)) from error
    if not len(converted.mesh.faces):
        raise MeshError("no triangles", location=Location(path))
    return LoadedMesh(converted.mesh, name, (*note, *converted.notes))


def obj_text(mesh: Mesh, *, comment: str = "") -> bytes:
    """The mesh as OBJ text: the same mesh always gives the same bytes.

    Coordinates are the shortest decimals that read back to the very same float64; minus zero
    is written as zero. Lines end in ``\\n``.
    """
    head = "".join(f"# {line}\n" for line in comment.splitlines())
    rows = (mesh.vertices + 0.0).tolist()
    vertices = "".join(f"v {x!r} {y!r} {z!r}\n" for x, y, z in rows)
    faces = "".join(f"f {a} {b} {c}\n" for a, b, c in (mesh.faces + 1).tolist())
    return (head + vertices + faces).encode("utf-8")


def write_obj(mesh: Mesh, path: Path | str, *, comment: str = "") -> None:
    """Write :func:`obj_text` to a file.

    Args:
        mesh: in the frame and unit that the reader of the file shall see.
        path: the file; its folder must exist.
        comment: goes to the top, a ``#`` before each line.
    """
    Path(path).write_bytes(obj_text(mesh, comment=comment))


def _bytes(path: Path, limits: FileLimits) -> bytes:
    try:
        with path.open("rb") as file:
            limits.check("bytes", os.fstat(file.fileno()).st_size, path)
            # a device or pipe has no size to check first
            data = file.read(limits.max_bytes + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"cannot be read: {reason}", location=Location(path)) from error
    limits.check("bytes", len(data), path)
    return data


def _format(data: bytes, path: Path) -> tuple[str, tuple[str, ...]]:
    """The format by content, by ending where the content is not recognised."""
    suffix = path.suffix.lower()
    named = _SUFFIXES.get(suffix)
    if not data:
        raise InputError("file is empty", location=Location(path))
    if named is not None and _FORMATS[named].recognise(data):
        return named, ()
    for name, known in _FORMATS.items():
        if known.recognise(data):
            return name, (f"named '{path.suffix}', but its content is {name.upper()}",)
    if named is not None:
        return named, ()
    raise InputError(
        unknown_name("mesh format", suffix or path.name, SUFFIXES), location=Location(path)
    )


__all__ = [
    "SUFFIXES",
    "FileLimits",
    "LoadedMesh",
    "obj_text",
    "read_mesh",
    "write_obj",
]
