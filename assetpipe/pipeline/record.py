"""What is stored with a built package: its report and where it comes from.

Neither holds times or folders of the machine that built it: equal inputs give
equal bytes wherever they lie.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import assetpipe
from assetpipe.errors import InputError, Location
from assetpipe.pipeline.config import Config
from assetpipe.pipeline.identity import versions
from assetpipe.pipeline.output import PROVENANCE

REPORT = "report.json"
SCHEMA = 1


def report_bytes(record: Mapping[str, Any], config: Config, roots: Sequence[Path]) -> bytes:
    """``report.json``.

    Args:
        record: :meth:`assetpipe.pipeline.result.BuildResult.as_dict`.
        config: what was asked.
        roots: folders that paths are told relative to, the most specific first.
    """
    full = {
        "schema": SCHEMA,
        "assetpipe": {"version": assetpipe.__version__},
        "config": config.as_dict(),
        **portable(record, roots),
    }
    return _bytes(full)


def provenance_bytes(
    config: Config, inputs: Mapping[str, str], outputs: Mapping[str, str]
) -> bytes:
    """``assetpipe.json``.

    Args:
        config: what was asked.
        inputs: SHA-256 by name of every file that was read.
        outputs: SHA-256 by path in OUT of every file that was written, but this one.
    """
    return _bytes(
        {
            "schema": SCHEMA,
            "assetpipe": versions(config.engine),
            "config": config.as_dict(),
            "inputs": dict(inputs),
            "outputs": dict(outputs),
        }
    )


def portable(value: Any, roots: Sequence[Path]) -> Any:
    """The value with every path below one of the roots made relative to it."""
    prefixes = [str(root).rstrip("/") + "/" for root in roots if root != Path(root.anchor)]

    def walk(item: Any) -> Any:
        if isinstance(item, str):
            for prefix in prefixes:
                item = item.replace(prefix, "")
            return item
        if isinstance(item, Mapping):
            return {key: walk(child) for key, child in item.items()}
        if isinstance(item, list | tuple):
            return [walk(child) for child in item]
        return item

    return walk(value)


def read_record(out: Path) -> dict[str, Any]:
    """The report of a built package, from its folder or from the file itself.

    Raises:
        InputError: there is none, or it is not one of ours.
    """
    path = out / REPORT if out.is_dir() else out
    try:
        data = json.loads(path.read_bytes())
    except OSError as error:
        raise InputError(
            f"cannot be read ({error.strerror}); name a folder that assetpipe built",
            location=Location(path),
        ) from error
    except (ValueError, RecursionError) as error:
        raise InputError(f"is not JSON: {error}", location=Location(path)) from error
    if not isinstance(data, dict) or data.get("schema") != SCHEMA or "robots" not in data:
        raise InputError("is no report of assetpipe", location=Location(path))
    return data


def _bytes(value: Any) -> bytes:
    text = json.dumps(value, indent=2, sort_keys=True, ensure_ascii=False, allow_nan=False)
    return text.encode() + b"\n"


__all__ = [
    "PROVENANCE",
    "REPORT",
    "portable",
    "provenance_bytes",
    "read_record",
    "report_bytes",
]
