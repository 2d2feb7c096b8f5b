"""SARIF 2.1.0: findings where code review shows them (OASIS, sarif-v2.1.0)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

import assetpipe
from assetpipe.findings import CODES
from assetpipe.report.json import write_json

SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"
ROOT = "SRCROOT"
"""Base of relative paths: the folder in which the run was started (a checkout, in CI)."""


def sarif(findings: Sequence[Mapping[str, Any]], *, root: Path) -> dict[str, Any]:
    """A SARIF log with one run.

    Args:
        findings: as :meth:`assetpipe.findings.Finding.as_dict` gives them.
        root: files below it are named relative to it, as review tools need.
    """
    used = sorted({str(finding["code"]) for finding in findings})
    return {
        "$schema": SCHEMA,
        "version": "2.1.0",
        "runs": [
            {
                "tool": {
                    "driver": {
                        "name": "assetpipe",
                        "version": assetpipe.__version__,
                        "rules": [
                            {
                                "id": code,
                                "name": _pascal(CODES[code]),
                                "shortDescription": {"text": CODES[code]},
                            }
                            for code in used
                        ],
                    }
                },
                "columnKind": "unicodeCodePoints",
                "results": [_result(finding, used, root) for finding in findings],
            }
        ],
    }


def write_sarif(path: Path, findings: Sequence[Mapping[str, Any]], *, root: Path) -> None:
    """Write :func:`sarif` to a file."""
    write_json(path, sarif(findings, root=root))


def _result(finding: Mapping[str, Any], used: list[str], root: Path) -> dict[str, Any]:
    who = f"link '{finding['link']}': " if finding["link"] else ""
    hint = f" ({finding['hint']})" if finding["hint"] else ""
    result: dict[str, Any] = {
        "ruleId": finding["code"],
        "ruleIndex": used.index(finding["code"]),
        "level": finding["severity"],
        "message": {"text": f"{who}{finding['message']}{hint}"},
    }
    if finding["file"]:
        physical: dict[str, Any] = {"artifactLocation": _artifact(Path(finding["file"]), root)}
        if finding["line"]:
            physical["region"] = {"startLine": finding["line"]}
        location: dict[str, Any] = {"physicalLocation": physical}
        if finding["link"]:
            location["logicalLocations"] = [{"name": finding["link"], "kind": "element"}]
        result["locations"] = [location]
    return result


def _artifact(file: Path, root: Path) -> dict[str, str]:
    try:
        relative = file.resolve().relative_to(root.resolve()) if file.is_absolute() else file
    except ValueError:
        return {"uri": file.resolve().as_uri()}
    return {"uri": quote(relative.as_posix()), "uriBaseId": ROOT}


def _pascal(title: str) -> str:
    return "".join(word.capitalize() for word in title.replace("-", " ").split())
