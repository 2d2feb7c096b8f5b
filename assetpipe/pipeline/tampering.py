"""Files of a built package that are no longer as they were written."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from assetpipe.errors import Location
from assetpipe.findings import Finding, Severity
from assetpipe.pipeline.identity import digest_file
from assetpipe.pipeline.output import PROVENANCE, provenance_of


def edited_files(root: Path) -> Iterator[Finding]:
    """A finding for every generated file at or below a folder that was changed or is gone."""
    folder = root if root.is_dir() else root.parent
    for parent, folders, names in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        if PROVENANCE in names:
            yield from _edited(Path(parent))
        if not root.is_dir():
            return


def _edited(package: Path) -> Iterator[Finding]:
    data = provenance_of(package)
    outputs = data.get("outputs") if data else None
    if not isinstance(outputs, dict):
        return
    for name in sorted(outputs):
        path = package / str(name)
        if ".." in path.parts:
            continue
        if not path.is_file():
            said = "is missing"
        elif digest_file(path) != outputs[name]:
            said = "was changed since it was written"
        else:
            continue
        yield Finding(
            "AP602", Severity.WARNING, f"'{name}' {said}", Location(path), hint="build again"
        )
