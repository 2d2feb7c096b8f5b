"""A validation for people: a row a link, then the checks, then scenes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from assetpipe.report.escaping import escape
from assetpipe.report.terminal import millimetres, show_checks, show_findings

if TYPE_CHECKING:
    from assetpipe.pipeline.compare import Validation
    from assetpipe.validation.effects import Plan
    from assetpipe.validation.runners import SceneResult

_ANSWERS = {True: "yes", False: "no", None: "–"}
_VERDICTS = {True: "[green]as expected[/green]", False: "[red]not as expected[/red]", None: "–"}


def show_validation(console: Console, result: Validation) -> None:
    """Everything that was proved."""
    if result.links:
        console.print(_links(result.links))
    show_checks(console, result.checks)
    if result.scenes:
        console.print(_scenes(result.scenes))
        for scene in result.scenes:
            if scene.toggled:
                console.print(_sensitivity(scene))
    show_findings(console, [finding.as_dict() for finding in result.findings])


def show_plans(console: Console, plans: Mapping[str, Plan]) -> None:
    """What each scene would simulate, and why."""
    for name, plan in plans.items():
        console.print(f"[bold]{escape(name)}[/bold]: {plan.method} ({plan.backend})")
        console.print(f"  {escape(plan.why)}", soft_wrap=True)
        table = Table(box=SIMPLE_HEAD)
        for column in ("effect", "state", "why"):
            table.add_column(column, overflow="fold")
        for effect in plan.effects:
            state = "[green]on[/green]" if effect.is_on else "off"
            why = effect.reason + (" (overruled)" if effect.overruled else "")
            table.add_row(effect.name, state, escape(why))
        console.print(table)


def _links(links: Mapping[str, Mapping[str, Any]]) -> Table:
    table = Table(box=SIMPLE_HEAD, title="links", title_justify="left")
    table.add_column("link", overflow="fold")
    for name in ("hulls", "vertices", "certified mm", "contact worst mm", "false contacts"):
        table.add_column(name, justify="right")
    table.add_column("holds")
    for name, facts in links.items():
        certificate, contact = facts.get("certificate"), facts.get("contact")
        table.add_row(
            escape(name),
            str(facts.get("hulls", "–")),
            str(facts.get("hull_vertices", "–")),
            millimetres(certificate["thickening"]["upper"]) if certificate else "–",
            millimetres(contact["clearance_error"]["worst"]) if contact else "–",
            f"{contact['false_contacts']['rate']:.1%}" if contact else "–",
            "–" if not contact else "yes" if contact["holds"] else "[red]no[/red]",
        )
    return table


def _scenes(scenes: tuple[SceneResult, ...]) -> Table:
    table = Table(box=SIMPLE_HEAD, title="scenes", title_justify="left")
    for name in ("scene", "question", "method"):
        table.add_column(name, overflow="fold")
    for name in ("answer", "measure"):
        table.add_column(name, justify="right")
    table.add_column("verdict")
    table.add_column("time s", justify="right")
    for scene in scenes:
        measured = scene.measured
        table.add_row(
            escape(scene.name),
            scene.question,
            f"{scene.plan.method} ({scene.plan.backend})",
            _ANSWERS[scene.answer],
            f"{measured.measure:.4g} {measured.unit}" if measured else "–",
            _VERDICTS[scene.expected],
            f"{scene.seconds:.3f}",
        )
    return table


def _sensitivity(scene: SceneResult) -> Table:
    table = Table(box=SIMPLE_HEAD, title=f"{escape(scene.name)}: what if", title_justify="left")
    for name in ("effect", "switched", "answer"):
        table.add_column(name)
    table.add_column("measure", justify="right")
    table.add_column("time s", justify="right")
    table.add_column("differs")
    for item in scene.toggled:
        table.add_row(
            item.effect,
            item.state,
            _ANSWERS[item.answer],
            "–" if item.measure is None else f"{item.measure:.4g}",
            f"{item.seconds:.3f}",
            escape(item.message) if item.message else "no" if item.same else "[yellow]yes[/yellow]",
        )
    return table
