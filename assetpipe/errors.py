"""Typed errors: what went wrong, where, and what would have been right.

Errors stop the whole call. What concerns one mesh or link only is a
:class:`assetpipe.findings.Finding` instead, and the rest goes on.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

_OBEYED = re.compile(
    "[\\0-\\x08\\x0b-\\x1f\\x7f-\\x9f\\u202a-\\u202e\\u2066-\\u2069\\ud800-\\udfff]"
)
"""Control characters but tabs and line ends, changes of direction, halves of surrogate pairs."""


def printable(text: str) -> str:
    """Text of a stranger for people to read: what terminals obey and what no encoding has is
    spelled out."""
    return _OBEYED.sub(lambda found: ascii(found[0])[1:-1], text)


@dataclass(frozen=True)
class Location:
    """A place in an input: a file and, where known, a line (1-based)."""

    file: Path
    line: int | None = None

    def __str__(self) -> str:
        return str(self.file) if self.line is None else f"{self.file}:{self.line}"


class AssetpipeError(Exception):
    """Base of every error that assetpipe raises on purpose."""

    def __init__(self, message: str, *, location: Location | None = None) -> None:
        message = printable(message)
        super().__init__(message)
        self.message = message
        self.location = location

    def __str__(self) -> str:
        where = "" if self.location is None else f"{printable(str(self.location))}: "
        return where + self.message


class UsageError(AssetpipeError):
    """The call itself is wrong: an unknown name, an impossible combination."""


class ConfigError(UsageError):
    """A configuration or scene file does not fit its schema."""


class InputError(AssetpipeError):
    """An input file cannot be found, read or understood."""


class ResourceError(InputError):
    """A mesh reference cannot be resolved to a file inside the allowed roots."""


class MeshError(AssetpipeError):
    """A mesh is not what the operation needs (not finite, empty, not a solid)."""


class LimitError(AssetpipeError):
    """A stated limit on size, time or memory was exceeded."""


class CancelledError(AssetpipeError):
    """The caller asked to stop; nothing was left half-written."""


class EngineError(AssetpipeError):
    """A fault of ours: please report it with the mesh it names."""


def unknown_name(kind: str, name: str, known: Iterable[str]) -> str:
    """Say that ``name`` is no ``kind``, naming its neighbours.

    The closest match comes first, then all that exist (at most twelve).
    """
    names = sorted(known)
    close = get_close_matches(name, names, n=1)
    hint = f"; did you mean '{close[0]}'?" if close else ""
    shown = ", ".join(names[:12]) + (f", … ({len(names)} in all)" if len(names) > 12 else "")
    return f"{kind} '{name}' not found{hint}; {kind}s: {shown or 'none'}"
