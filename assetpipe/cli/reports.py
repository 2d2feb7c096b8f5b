"""A build's result to wherever the options say."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

import click

from assetpipe.cli.options import STDOUT, deliver_json

if TYPE_CHECKING:
    from rich.console import Console

    from assetpipe.pipeline.result import BuildResult


def deliver(
    result: BuildResult, given: dict[str, Any], inputs: Sequence[Path], *, stream: IO[str]
) -> None:
    """Write the report files that were asked for, and a table unless JSON goes to stdout."""
    from assetpipe.cli.shell import command_of
    from assetpipe.pipeline.quick import remember
    from assetpipe.report.junit import write_junit
    from assetpipe.report.sarif import write_sarif
    from assetpipe.report.terminal import console_for, show_build

    record = result.as_dict()
    if given["junit"]:
        write_junit(given["junit"], record["robots"], unowned(record))
    if given["sarif"]:
        write_sarif(given["sarif"], record["findings"], root=Path.cwd())
    deliver_json(given["json_file"], {**record, "seconds": seconds(result)})
    if given["json_file"] == STDOUT:
        return
    times = {
        f"{mesh.name}|{mesh.digest}": mesh.seconds
        for robot in result.robots
        for mesh in robot.meshes
    }
    console = console_for(stream)
    show_build(console, record, seconds=times)
    if result.parts is not None:
        remember(
            command_of(click.get_current_context().find_root().obj),
            result.parts,
            inputs=inputs,
            files=_files(given),
            code=result.exit_code,
            text=_all_cached(console, record),
        )


def _all_cached(console: Console, record: dict[str, Any]) -> str:
    """What will be printed when everything comes from the cache."""
    from rich.console import Console

    from assetpipe.report.terminal import show_build

    paper = Console(
        file=io.StringIO(),
        width=console.width,
        force_terminal=console.is_terminal,
        highlight=False,
    )
    show_build(paper, record, seconds={})
    return str(paper.file.getvalue())  # type: ignore[attr-defined]


def _files(given: dict[str, Any]) -> tuple[Path, ...]:
    """Files beside the inputs that have decided the result."""
    from assetpipe.shipped import find_config

    name = given.get("config_name")
    return (find_config(name),) if name else ()


def unowned(record: dict[str, Any]) -> list[dict[str, Any]]:
    """Findings that concern no robot that was read."""
    owned = [finding for robot in record["robots"] for finding in robot["findings"]]
    return [finding for finding in record["findings"] if finding not in owned]


def seconds(result: BuildResult) -> dict[str, Any]:
    """Times, which stay out of every stored report."""
    return {
        "total": result.seconds,
        "meshes": [
            {"robot": robot.name, "mesh": mesh.name, "seconds": mesh.seconds}
            for robot in result.robots
            for mesh in robot.meshes
        ],
    }
