"""Whole builds remembered: an unchanged build is copied, not computed.

The key is a fingerprint of what was asked, the description and the files that its
references lead to. Every other file that was read or copied is listed with its digest
and looked at again, so a changed texture is noticed too.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from assetpipe.pipeline.cache import Cache
from assetpipe.pipeline.identity import digest_file
from assetpipe.pipeline.output import Stage

ROOM = "builds"

LARGE = 2**20
"""Input files larger than this many bytes are copied again from where they lie."""


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

    def write(self, stage: Stage) -> None:
        """Stage the package."""
        for name, data in self.files.items():
            stage.path(name).write_bytes(data)
        for name, source in self.copies.items():
            shutil.copyfile(source, stage.path(name))


def remember(
    cache: Cache,
    key: str,
    *,
    result: Mapping[str, Any],
    tree: Path,
    outputs: Mapping[str, str],
    inputs: Mapping[str, str],
) -> None:
    """Store a build.

    Args:
        cache: where to.
        key: of all that decided it.
        result: JSON-ready.
        tree: the folder with the written files.
        outputs: their SHA-256 by path in it.
        inputs: SHA-256 by absolute path of every input file.
    """
    if cache.root is None:
        return
    known = {digest: path for path, digest in inputs.items()}
    parts: list[bytes] = []
    files: list[tuple[str, int]] = []
    copies: dict[str, str] = {}
    for name, digest in sorted(outputs.items()):
        path = tree / name
        if digest in known and path.stat().st_size > LARGE:
            copies[name] = known[digest]
            continue
        data = path.read_bytes()
        files.append((name, len(data)))
        parts.append(data)
    head = {"result": result, "inputs": dict(inputs), "files": files, "copies": copies}
    cache.put(ROOM, key, b"".join([json.dumps(head).encode(), b"\n", *parts]))


def recall(cache: Cache, key: str) -> Entry | None:
    """A stored build whose input files are as they were, or ``None``."""
    data = cache.get(ROOM, key)
    if data is None:
        return None
    try:
        line = data.index(b"\n")
        head = json.loads(data[:line])
        if any(digest_file(path) != digest for path, digest in head["inputs"].items()):
            return None
        files: dict[str, bytes] = {}
        at = line + 1
        for name, size in head["files"]:
            files[name] = data[at : at + size]
            at += size
        return Entry(head["result"], files, head["copies"])
    except (OSError, ValueError, KeyError, TypeError):
        return None
