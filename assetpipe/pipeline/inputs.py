"""What INPUT means: robots and meshes, in files or in folders of packages."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from assetpipe.errors import InputError, Location
from assetpipe.pipeline.output import provenance_of

MESH_SUFFIXES = (".stl", ".obj", ".dae", ".glb", ".ply", ".off")
ROBOT_SUFFIXES = (".urdf", ".xacro")

_HEAD = 2**16
_ROBOT = re.compile(rb"<robot[\s>]")


@dataclass(frozen=True)
class Source:
    """One thing to build.

    Attributes:
        kind: what it is.
        path: absolute.
        root: folder that was searched, or the file's folder; names are relative to it.
        origin: ``named`` by the user, or ``found`` in a folder.
    """

    kind: Literal["robot", "mesh"]
    path: Path
    root: Path
    origin: Literal["named", "found"]


def find_sources(inputs: Sequence[Path]) -> tuple[Source, ...]:
    """Everything that the inputs name, once each, in order; folders in order of names.

    Raises:
        InputError: an input does not exist, is of no kind that we know, or is a folder
            without robots; a name is not UTF-8.
    """
    sources: dict[Path, Source] = {}
    for given in inputs:
        path = Path(os.path.abspath(given))
        if path.is_dir():
            found = [Source("robot", robot, path, "found") for robot in _robots(path)]
            if not found:
                raise InputError(
                    "no robot found: the folder holds no URDF and no xacro file with a named robot",
                    location=Location(given),
                )
        elif path.is_file():
            found = [_named(path, given)]
        else:
            raise InputError("does not exist", location=Location(given))
        for source in found:
            _check_name(source)
            sources.setdefault(source.path.resolve(), source)
    return tuple(sources.values())


def _check_name(source: Source) -> None:
    """Refuse what reports and URDFs could not name."""
    try:
        str(source.path).encode()
    except UnicodeEncodeError:
        raise InputError(
            "the name of the file, or of a folder above it, is not UTF-8",
            location=Location(source.path),
        ) from None


def _named(path: Path, given: Path) -> Source:
    suffix = path.suffix.lower()
    if suffix in ROBOT_SUFFIXES:
        return Source("robot", path, path.parent, "named")
    if suffix in MESH_SUFFIXES:
        return Source("mesh", path, path.parent, "named")
    if suffix == ".xml" and _ROBOT.search(_head(path)):
        return Source("robot", path, path.parent, "named")
    raise InputError(
        f"'{suffix or path.name}' is no file that can be built; known are "
        f"{', '.join(ROBOT_SUFFIXES + MESH_SUFFIXES)} and folders of robot packages",
        location=Location(given),
    )


def _robots(root: Path) -> tuple[Path, ...]:
    """Robot descriptions in a folder, those left out that we have built ourselves."""
    from assetpipe.robot import find_robots

    ours: dict[Path, bool] = {root: False}

    def built(folder: Path) -> bool:
        if folder not in ours:
            ours[folder] = provenance_of(folder) is not None or built(folder.parent)
        return ours[folder]

    return tuple(path for path in find_robots(root) if not built(path.parent))


def _head(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            return file.read(_HEAD)
    except OSError:
        return b""
