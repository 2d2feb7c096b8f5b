"""Tables for people."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO, Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from assetpipe.report.escaping import escape

_DEFECTS = {
    "open": "boundary_edges",
    "non-manifold": "nonmanifold_edges",
    "flipped": "inconsistent_edges",
    "crossing": "self_intersections",
}
"""Columns of the health table and where their counts are."""

_STYLES = {"error": "bold red", "warning": "yellow", "note": "dim"}


def console_for(stream: IO[str]) -> Console:
    """A console that wraps nothing when its output goes into a file or pipe."""
    if stream.isatty():
        return Console(file=stream, highlight=False)
    return Console(file=stream, highlight=False, width=int(os.environ.get("COLUMNS", "200")))


def show_build(
    console: Console,
    record: Mapping[str, Any],
    *,
    seconds: Mapping[str, float | None] | None = None,
) -> None:
    """One table a robot, then its findings.

    Args:
        console: where to.
        record: as in ``report.json``.
        seconds: by ``robot/mesh`` name and digest, what it took; ``None``: from the cache.
    """
    for robot in record["robots"]:
        if robot["meshes"]:
            console.print(_meshes(robot, seconds))
            _show_inner(console, robot["meshes"])
        else:
            console.print(f"[bold]{escape(robot['name'])}[/bold]: no collision meshes")
        show_checks(console, robot["validation"])
    show_findings(console, record["findings"])


def show_findings(console: Console, findings: Sequence[Mapping[str, Any]]) -> None:
    """Errors first, then warnings; notes are counted only."""
    for severity in ("error", "warning"):
        for finding in findings:
            if finding["severity"] == severity:
                console.print(_finding(finding), soft_wrap=True)
    notes = sum(finding["severity"] == "note" for finding in findings)
    counts = [
        _count(sum(f["severity"] == s for f in findings), s) for s in ("error", "warning", "note")
    ]
    hidden = " (notes: --json or report.json)" if notes else ""
    console.print(", ".join(counts) + hidden)


def show_health(console: Console, meshes: Sequence[Mapping[str, Any]]) -> None:
    """One row a mesh: what is wrong with it and what repair would do."""
    table = Table(box=SIMPLE_HEAD, title="mesh health", title_justify="left")
    table.add_column("mesh", overflow="fold")
    table.add_column("state")
    for name in ("faces", "parts", *_DEFECTS, "repair", "moved mm"):
        table.add_column(name, justify="right")
    for mesh in meshes:
        health, repair = mesh.get("health") or {}, mesh.get("repair")
        table.add_row(
            escape(_short(mesh["name"])),
            escape(str(health.get("soundness", "unreadable"))),
            _number(mesh.get("faces")),
            _number(health.get("components")),
            *(_number((health.get(key) or {}).get("count")) for key in _DEFECTS.values()),
            "[red]impossible[/red]" if repair and not repair["solid"] else _rung(repair),
            millimetres(repair["moved"]) if repair and repair["solid"] else "–",
        )
    console.print(table)


def _meshes(robot: Mapping[str, Any], seconds: Mapping[str, float | None] | None) -> Table:
    table = Table(box=SIMPLE_HEAD, title=escape(str(robot["name"])), title_justify="left")
    table.add_column("link", overflow="fold")
    table.add_column("mesh", overflow="fold")
    for name in ("faces", "repair", "moved mm", "hulls", "vertices", "certified mm", "allowed mm"):
        table.add_column(name, justify="right")
    table.add_column("contact worst mm", justify="right")
    if seconds is not None:
        table.add_column("time s", justify="right")
    for mesh in robot["meshes"]:
        repair = mesh.get("repair")
        certificate = mesh.get("certificate")
        contact = mesh.get("contact")
        row = [
            escape(_links(mesh["links"])),
            escape(_short(mesh["name"])),
            _number(mesh.get("faces")),
            _rung(repair),
            millimetres(repair["moved"]) if repair and repair["solid"] else "–",
            _number(mesh.get("hulls")) if mesh["treatment"] == "decomposed" else "[red]kept[/red]",
            _number(mesh.get("hull_vertices")),
            millimetres(certificate["thickening"]["upper"]) if certificate else "–",
            millimetres(mesh["tolerance"]) if "tolerance" in mesh else "–",
            millimetres(contact["clearance_error"]["worst"]) if contact else "–",
        ]
        if seconds is not None:
            took = seconds.get(f"{mesh['name']}|{mesh['digest']}")
            row.append("cached" if took is None else f"{took:.2f}")
        table.add_row(*row)
    return table


def _show_inner(console: Console, meshes: Sequence[Mapping[str, Any]]) -> None:
    told = [mesh["inner"] for mesh in meshes if "inner" in mesh]
    if told:
        count, least = sum(item["hulls"] for item in told), min(item["share"] for item in told)
        console.print(f"  {count} inner hulls fill at least {least:.1%} of every solid")


def show_checks(console: Console, validation: Mapping[str, Any]) -> None:
    """A line a check of the whole robot."""
    pairs = validation.get("self_collision")
    if pairs:
        console.print(
            f"  self-collision over {pairs['configurations']} configurations: "
            f"{len(pairs['new'])} new, {len(pairs['vanished'])} vanished pairs"
        )
    engine = validation.get("engine")
    if engine:
        shapes = sum(engine["shapes"].values())
        told = f", {shapes} collision shapes" if engine["outcome"] == "loaded" else ""
        name = engine["engine"] or "physics engine"
        console.print(escape(f"  {name}: {engine['outcome']}{told}"))


def _finding(finding: Mapping[str, Any]) -> str:
    style = _STYLES[finding["severity"]]
    where = ""
    if finding["file"]:
        where = _shown_path(finding["file"])
        where += f":{finding['line']}: " if finding["line"] else ": "
    who = f" link '{finding['link']}'" if finding["link"] else ""
    hint = f" ({finding['hint']})" if finding["hint"] else ""
    return (
        f"{escape(where)}[{style}]{finding['severity']} {finding['code']}[/{style}]"
        f"{escape(who)}: {escape(finding['message'])}{escape(hint)}"
    )


def _shown_path(file: str) -> str:
    """Relative to where the user is, if that is shorter."""
    path = Path(file)
    if not path.is_absolute():
        return file
    try:
        return str(path.relative_to(Path.cwd()))
    except (ValueError, OSError):
        return file


def _count(number: int, what: str) -> str:
    return f"{number} {what}" + ("" if number == 1 else "s")


def _links(names: Sequence[str]) -> str:
    return ", ".join(names[:2]) + (f" +{len(names) - 2}" if len(names) > 2 else "")


def _short(uri: str) -> str:
    return uri.rsplit("/", 1)[-1]


def _rung(repair: Mapping[str, Any] | None) -> str:
    if not repair:
        return "–"
    return str(repair["rung"] or "none")


def _number(value: Any) -> str:
    return "–" if value is None else f"{value}"


def millimetres(metres: float | None) -> str:
    """Three digits; a dash for nothing."""
    if metres is None:
        return "–"
    return "0" if metres == 0 else f"{metres * 1000:.3g}"
