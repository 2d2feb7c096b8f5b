"""The same command line again: an unchanged build told without loading the libraries.

A command line that built everything without a fault is remembered with the
fingerprints of its sources, its configuration file and what it printed. Given again,
the fingerprints are taken anew; if they agree, the packages come from the ledger.
Nothing here may import numpy, pydantic or rich: to load them costs more than the rest.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from assetpipe.errors import AssetpipeError
from assetpipe.pipeline import ledger
from assetpipe.pipeline.cache import Cache, default_root
from assetpipe.pipeline.identity import code_stamp, digest_file, digest_of
from assetpipe.pipeline.inputs import Source, find_sources
from assetpipe.pipeline.output import staged

ROOM = "commands"

_UNUSUAL = ("--check", "--json", "--junit", "--sarif", "--no-cache", "--cluster")
"""Options whose effects are more than a package and a table."""

_WATCHED = (
    "ASSETPIPE_",
    "COLUMNS",
    "NO_COLOR",
    "FORCE_COLOR",
    "TERM",
    "LANG",
    "LC_",
    "HOME",
    "XDG_",
)
"""Variables (by prefix) that may change what is printed or where the cache lies."""


@dataclass(frozen=True)
class Command:
    """A command line, and where it was given.

    Attributes:
        arguments: without the program's name.
        width: columns of the terminal; 0 where the output is none.
    """

    arguments: tuple[str, ...]
    width: int

    @property
    def key(self) -> str:
        """Digest of all that is known before looking at any input."""
        variables = {name: value for name, value in os.environ.items() if name.startswith(_WATCHED)}
        here = {"arguments": self.arguments, "width": self.width, "cwd": os.getcwd()}
        return digest_of({**here, "environment": variables, "code": code_stamp()})

    @property
    def cache(self) -> Cache | None:
        """The cache it names; ``None`` if it is no build, or one that must not be recalled."""
        words = self.arguments
        if not words or words[0] not in ("build", "decompose"):
            return None
        if any(word.split("=")[0] in _UNUSUAL for word in words):
            return None
        root = default_root()
        for place, word in enumerate(words):
            if word == "--cache-dir" and place + 1 < len(words):
                root = Path(words[place + 1])
            elif word.startswith("--cache-dir="):
                root = Path(word.split("=", 1)[1])
        return Cache(root)


@dataclass(frozen=True)
class Part:
    """One target of a remembered build.

    Attributes:
        source: kind, path and root.
        out: the folder of its package.
        references: digest of what its references led to.
        key: of its entry in the ledger.
    """

    source: Source
    out: Path
    references: str
    key: str


def remember(
    command: Command,
    parts: Sequence[Part],
    *,
    inputs: Sequence[Path],
    files: Sequence[Path],
    code: int,
    text: str,
) -> None:
    """Store a command that built everything without a fault.

    Args:
        command: as given.
        parts: what it built.
        inputs: as given; searched anew next time.
        files: others that were read, for example the configuration.
        code: its exit code.
        text: what it would print if all came from the cache.
    """
    cache = command.cache
    if cache is None:
        return
    entry = {
        "inputs": [str(path) for path in inputs],
        "files": {str(path): digest_file(path) for path in files},
        "parts": [
            {
                "kind": part.source.kind,
                "path": str(part.source.path),
                "root": str(part.source.root),
                "origin": part.source.origin,
                "out": str(part.out),
                "references": part.references,
                "key": part.key,
            }
            for part in parts
        ],
        "code": code,
        "text": text,
    }
    cache.put(ROOM, command.key, json.dumps(entry).encode())


def again(command: Command) -> tuple[int, str] | None:
    """Do a remembered command again: its exit code and text, or ``None`` if it must be
    done in full."""
    cache = command.cache
    data = cache.get(ROOM, command.key) if cache is not None else None
    if cache is None or data is None:
        return None
    from assetpipe.pipeline.references import references

    try:
        entry: dict[str, Any] = json.loads(data)
        if any(digest_file(path) != digest for path, digest in entry["files"].items()):
            return None
        parts = [_part(item) for item in entry["parts"]]
        sources = find_sources([Path(path) for path in entry["inputs"]])
        if set(sources) != {part.source for part in parts}:
            return None
        if any(references(part.source) != part.references for part in parts):
            return None
        for part in parts:
            found = ledger.recall(cache, part.key)
            if found is None:
                return None
            with staged(part.out) as stage:
                found.write(stage)
                stage.commit()
        return int(entry["code"]), str(entry["text"])
    except (OSError, ValueError, KeyError, TypeError, AssetpipeError):
        return None  # the full way will say what is wrong


def _part(item: Mapping[str, str]) -> Part:
    kind, origin = item["kind"], item["origin"]
    if kind not in ("robot", "mesh") or origin not in ("named", "found"):
        raise ValueError(kind)
    source = Source(kind, Path(item["path"]), Path(item["root"]), origin)  # type: ignore[arg-type]
    return Part(source, Path(item["out"]), item["references"], item["key"])
