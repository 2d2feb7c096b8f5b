"""JSON as we write it: sorted keys, two spaces, one line feed at the end."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from assetpipe.errors import UsageError


def to_json(value: Any) -> str:
    """Deterministic text; NaN and infinities are refused, for JSON has none."""
    return json.dumps(value, indent=2, sort_keys=True, ensure_ascii=False, allow_nan=False) + "\n"


def write_json(path: Path, value: Any) -> None:
    """Write a JSON file.

    Raises:
        UsageError: the file cannot be written.
    """
    write_text(path, to_json(value))


def write_text(path: Path, text: str) -> None:
    """Write a report file.

    Raises:
        UsageError: it cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8", newline="\n")
    except OSError as error:
        raise UsageError(f"cannot write '{path}': {error.strerror}") from error
