"""Which assetpipe this is: what a stored result depends on besides its inputs."""

from __future__ import annotations

import hashlib
import json
import os
from functools import cache
from pathlib import Path
from typing import Any

import assetpipe

LIBRARIES: dict[str, tuple[str, ...]] = {
    "assetpipe": ("manifold3d", "libigl"),
    "hull": ("manifold3d", "libigl"),
    "coacd": ("manifold3d", "libigl", "coacd"),
    "vhacd": ("manifold3d", "libigl", "vhacdx"),
}
"""Libraries whose version may change an engine's result."""


def versions(engine: str) -> dict[str, str]:
    """Versions of assetpipe and of the libraries that shape an engine's result."""
    from importlib.metadata import PackageNotFoundError, version

    found = {"assetpipe": assetpipe.__version__}
    for name in LIBRARIES.get(engine, ()):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "absent"
    return found


@cache
def code_stamp() -> str:
    """A digest that changes whenever this installation's code does.

    From the names, sizes and times of its files, so that a rebuilt core or an
    edited checkout never meets results of its former self. It stays out of every
    output: two installations of one version write the same bytes.
    """
    root = Path(assetpipe.__file__).resolve().parent
    state = hashlib.sha256()
    for folder, folders, names in os.walk(root):
        folders.sort()
        for name in sorted(names):
            if name.endswith((".py", ".so", ".pyd")):
                path = os.path.join(folder, name)
                stat = os.stat(path)
                state.update(
                    f"{path[len(str(root)) :]}|{stat.st_size}|{stat.st_mtime_ns}\n".encode()
                )
    return state.hexdigest()


def digest_of(value: Any) -> str:
    """SHA-256 in hex of a JSON-ready value's canonical text."""
    text = json.dumps(value, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def digest_file(path: str | os.PathLike[str]) -> str:
    """SHA-256 in hex of a file's bytes."""
    state = hashlib.sha256()
    with open(path, "rb", buffering=0) as file:
        while block := file.read(2**20):
            state.update(block)
    return state.hexdigest()


def digest_mesh(path: Path) -> str:
    """SHA-256 in hex of a mesh file and of the files that a glTF or GLB keeps its buffers in."""
    own = digest_file(path)
    if path.suffix.lower() not in (".gltf", ".glb"):
        return own
    from assetpipe.geometry.formats.gltf_buffers import files_of

    files = files_of(path)
    return digest_of([own, *map(digest_file, files)]) if files else own
