"""Whole builds remembered: an unchanged build is copied, not computed.

An entry lists every file that was read with its digest, and every folder whose
listing decided where references lead. Only if all are as they were is the entry's
tree written again. It needs neither numpy nor any robot library, which is what makes
an unchanged second run quick.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from assetpipe.pipeline.cache import Cache
from assetpipe.pipeline.identity import digest_file

ROOM = "builds"
ENVIRONMENT = ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH", "COLCON_PREFIX_PATH", "CMAKE_PREFIX_PATH")
"""Variables that decide where references lead."""

_INLINE = 2**20
"""Input files larger than this are copied again from where they lie, not stored."""


@dataclass(frozen=True)
class Entry:
    """A remembered build.

    Attributes:
        result: :meth:`assetpipe.pipeline.result.BuildResult.store`.
        files: bytes by path in OUT.
        copies: input file by path in OUT.
    """

    result: Mapping[str, Any]
    files: Mapping[str, bytes]
    copies: Mapping[str, str]


def remember(
    cache: Cache,
    key: str,
    *,
    inputs: Mapping[str, str],
    folders: Iterable[str],
    out: Path,
    result: Mapping[str, Any],
    tree: Path,
    names: Iterable[str],
) -> None:
    """Store a build.

    Args:
        cache: where to.
        key: of what was asked.
        inputs: SHA-256 by absolute path of every file that was read.
        folders: absolute paths of folders whose listing mattered.
        out: left out of listings, for it is ours.
        result: JSON-ready.
        tree: the folder with the written files.
        names: their paths in it.
    """
    by_digest = {digest: path for path, digest in inputs.items()}
    parts: list[bytes] = []
    files: list[list[Any]] = []
    copies: dict[str, str] = {}
    for name in names:
        path = tree / name
        size = path.stat().st_size
        if size > _INLINE:
            source = by_digest.get(digest_file(path))
            if source is not None:
                copies[name] = source
                continue
        data = path.read_bytes()
        files.append([name, len(data)])
        parts.append(data)
    head = {
        "inputs": dict(inputs),
        "folders": {folder: _listing(folder, out) for folder in sorted(set(folders))},
        "result": result,
        "files": files,
        "copies": copies,
    }
    cache.put(ROOM, key, b"".join([json.dumps(head).encode(), b"\n", *parts]))


def recall(cache: Cache, key: str, out: Path) -> Entry | None:
    """A stored build, if everything that it was made from is as it was."""
    data = cache.get(ROOM, key)
    if data is None:
        return None
    try:
        line = data.index(b"\n")
        head = json.loads(data[:line])
        if not all(_listing(folder, out) == was for folder, was in head["folders"].items()):
            return None
        if not all(digest_file(path) == digest for path, digest in head["inputs"].items()):
            return None
        files: dict[str, bytes] = {}
        at = line + 1
        for name, size in head["files"]:
            files[name] = data[at : at + size]
            at += size
        return Entry(head["result"], files, head["copies"])
    except (OSError, ValueError, KeyError, TypeError):
        return None


def environment() -> dict[str, str]:
    """The part of the environment that decides where references lead."""
    return {name: os.environ.get(name, "") for name in ENVIRONMENT}


def _listing(folder: str, out: Path) -> str:
    """A digest of the names in a folder, without OUT and its stages."""
    try:
        names = sorted(os.listdir(folder))
    except OSError:
        return ""
    if os.path.realpath(folder) == os.path.realpath(out.parent):
        names = [n for n in names if n != out.name and not n.startswith(f".{out.name}.")]
    return hashlib.sha256("\0".join(names).encode("utf-8", "surrogateescape")).hexdigest()
