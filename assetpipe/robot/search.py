"""Find the robot descriptions in a folder."""

from __future__ import annotations

import os
from pathlib import Path

from assetpipe.errors import AssetpipeError, InputError, Location
from assetpipe.robot.markup import Element, read_markup

_SKIPPED = {"build", "install", "log", "node_modules", "__pycache__"}
_BUILT_IN = {
    "include", "macro", "property", "arg", "if", "unless", "element", "attribute", "insert_block",
    "call",
}  # fmt: skip
_MAX_BYTES = 64 * 1024 * 1024


def find_robots(path: Path | str) -> tuple[Path, ...]:
    """The robot descriptions in a folder, or the file itself.

    URDFs are files ``*.urdf`` with a ``<robot>``. A xacro file counts if its ``<robot>`` has a
    name and it makes links or calls a macro, and if no URDF of its name lies beside it: files
    of macros, materials or properties are there to be included. A broken ``.urdf`` counts, so
    that it is told. Hidden folders and what build tools make are not searched.

    Returns:
        In the order of their paths.

    Raises:
        InputError: no such file or folder.
    """
    path = Path(path)
    if path.is_file():
        return (path,)
    if not path.is_dir():
        raise InputError("no such file or folder", location=Location(path))
    found: list[Path] = []
    for folder, folders, files in os.walk(path):
        folders[:] = sorted(f for f in folders if not f.startswith(".") and f not in _SKIPPED)
        here = Path(folder)
        names = {_stem(name) for name in files if name.lower().endswith(".urdf")}
        for name in sorted(files):
            lower = name.lower()
            if lower.endswith(".urdf"):
                if _is_urdf(here / name):
                    found.append(here / name)
            elif lower.endswith(".xacro") and _stem(name) not in names and _makes(here / name):
                found.append(here / name)
    return tuple(sorted(found, key=lambda p: p.parts))


def _stem(name: str) -> str:
    lower = name.lower()
    for suffix in (".urdf.xacro", ".xacro", ".urdf"):
        if lower.endswith(suffix):
            return lower[: -len(suffix)]
    return lower


def _root(path: Path) -> Element | None:
    try:
        if path.stat().st_size > _MAX_BYTES:
            return None
        return read_markup(path.read_bytes(), path).root
    except (OSError, AssetpipeError):
        return None


def _is_urdf(path: Path) -> bool:
    root = _root(path)
    return root is None or root.tag == "robot"


def _makes(path: Path) -> bool:
    """Whether a xacro file describes a robot and not only its ingredients."""
    root = _root(path)
    if root is None or root.tag != "robot" or not root.attributes.get("name"):
        return False
    stack = list(root.children)
    while stack:
        element = stack.pop()
        prefix, _, name = element.tag.rpartition(":")
        if element.tag == "link" or (prefix == "xacro" and name not in _BUILT_IN):
            return True
        if prefix == "xacro" and name in ("if", "unless"):
            stack.extend(element.children)
    return False
