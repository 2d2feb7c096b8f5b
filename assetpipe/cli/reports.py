"""A build's result to wherever the options say."""

from __future__ import annotations

from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from assetpipe.cli.options import STDOUT, deliver_json

if TYPE_CHECKING:
    from assetpipe.pipeline.result import BuildResult


def deliver(result: BuildResult, given: dict[str, Any], *, stream: IO[str]) -> None:
    """Write the report files that were asked for, and a table unless JSON goes to stdout."""
    from assetpipe.report.junit import write_junit
    from assetpipe.report.sarif import write_sarif
    from assetpipe.report.terminal import console_for, show_build

    record = result.as_dict()
    if given["junit"]:
        write_junit(given["junit"], record["robots"], unowned(record))
    if given["sarif"]:
        write_sarif(given["sarif"], record["findings"], root=Path.cwd())
    deliver_json(given["json_file"], {**record, "seconds": seconds(result)})
    if given["json_file"] != STDOUT:
        times = {
            f"{mesh.name}|{mesh.digest}": mesh.seconds
            for robot in result.robots
            for mesh in robot.meshes
        }
        show_build(console_for(stream), record, seconds=times)


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
