"""JUnit XML: a test suite a robot, a test case a link (the dialect that colcon reads)."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape, quoteattr

from assetpipe.report.json import write_text

_FORBIDDEN = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def junit(robots: Sequence[Mapping[str, Any]], others: Sequence[Mapping[str, Any]] = ()) -> str:
    """JUnit XML.

    A link with an error or a warning is a failed case; notes are its output. What
    concerns no link is in the case ``robot``.

    Args:
        robots: as :meth:`assetpipe.pipeline.result.RobotResult.as_dict` gives them.
        others: findings that concern no robot.
    """
    suites = [
        _suite(str(r["name"]), ["robot", *map(str, r["links"])], r["findings"]) for r in robots
    ]
    if others:
        suites.append(_suite("inputs", ["inputs"], others))
    lines = ['<?xml version="1.0" encoding="UTF-8"?>', "<testsuites>", *suites, "</testsuites>"]
    return _FORBIDDEN.sub("\N{REPLACEMENT CHARACTER}", "\n".join(lines)) + "\n"


def write_junit(
    path: Path, robots: Sequence[Mapping[str, Any]], others: Sequence[Mapping[str, Any]] = ()
) -> None:
    """Write :func:`junit` to a file."""
    write_text(path, junit(robots, others))


def _suite(name: str, names: list[str], findings: Sequence[Mapping[str, Any]]) -> str:
    # A link may be called "robot"; cases are told apart by their class name.
    by_case: dict[str, list[Mapping[str, Any]]] = {case: [] for case in names}
    for finding in findings:
        by_case.setdefault(finding["link"] or names[0], []).append(finding)
    cases = [_case(name, case, found) for case, found in by_case.items()]
    failed = sum(any(_fails(f) for f in found) for found in by_case.values())
    head = (
        f'  <testsuite name={quoteattr(name)} tests="{len(cases)}" failures="{failed}" '
        'errors="0" skipped="0">'
    )
    return "\n".join([head, *cases, "  </testsuite>"])


def _case(suite: str, name: str, findings: Sequence[Mapping[str, Any]]) -> str:
    head = f"    <testcase classname={quoteattr('assetpipe.' + suite)} name={quoteattr(name)}"
    if not findings:
        return head + "/>"
    lines = [head + ">"]
    failing = [f for f in findings if _fails(f)]
    if failing:
        kinds = ", ".join(dict.fromkeys(str(f["code"]) for f in failing))
        lines.append(
            f"      <failure type={quoteattr(kinds)} message={quoteattr(failing[0]['message'])}>"
            + escape("\n".join(map(_line, failing)))
            + "</failure>"
        )
    notes = [f for f in findings if not _fails(f)]
    if notes:
        lines.append(f"      <system-out>{escape(chr(10).join(map(_line, notes)))}</system-out>")
    return "\n".join([*lines, "    </testcase>"])


def _fails(finding: Mapping[str, Any]) -> bool:
    return bool(finding["severity"] != "note")


def _line(finding: Mapping[str, Any]) -> str:
    where = str(finding["file"] or "")
    if where and finding["line"]:
        where += f":{finding['line']}"
    hint = f" ({finding['hint']})" if finding["hint"] else ""
    return f"{where + ': ' if where else ''}{finding['code']}: {finding['message']}{hint}"
