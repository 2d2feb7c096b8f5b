"""Logs of our own faults."""

from __future__ import annotations

import platform
import tempfile
import traceback
from pathlib import Path

import assetpipe
from assetpipe.pipeline.cache import default_root


def write_log(error: BaseException) -> Path | None:
    """Write a traceback where the user can find it; ``None`` if nowhere can be written."""
    text = "".join(
        [
            f"assetpipe {assetpipe.__version__}, Python {platform.python_version()}, ",
            f"{platform.platform()}\n\n",
            *traceback.format_exception(error),
        ]
    )
    for folder in (default_root() / "logs", Path(tempfile.gettempdir())):
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with tempfile.NamedTemporaryFile(
                "w", prefix="assetpipe-fault-", suffix=".log", dir=folder, delete=False
            ) as file:
                file.write(text)
                return Path(file.name)
        except OSError:
            continue
    return None
