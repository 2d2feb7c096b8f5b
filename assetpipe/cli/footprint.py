"""``assetpipe footprint``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from assetpipe.cli import options
from assetpipe.cli.options import STDOUT, JsonCommand


@click.command(
    cls=JsonCommand,
    epilog="Exit codes: 0 fine, 1 shapes left out, 2 usage or unreadable input, 3 a fault of "
    "assetpipe.",
)
@click.argument("source", metavar="INPUT", type=click.Path(exists=True, path_type=Path))
@click.option(
    "-o", "--out", required=True, type=click.Path(path_type=Path), metavar="OUT", help="A folder."
)
@click.option("--tolerance", default="1cm", show_default=True, metavar="1cm", help="Length.")
@click.option("--below", metavar="30cm", help="Leave out shapes that lie above this height.")
@click.option("--source", "elements", type=click.Choice(["collision", "visual"]))
@click.option(
    "--joint",
    "joints",
    multiple=True,
    metavar="NAME=VALUE|NAME=LOW:HIGH",
    help="Radians or metres; a range is sampled. May be repeated.",
)
@click.option("--steps", default=9, show_default=True, type=click.IntRange(2, 1000), metavar="N")
@options.json_option
def command(source: Path, out: Path, **given: Any) -> int:
    """Project a robot onto the ground: polygons for a costmap.

    Writes footprint.json, footprint.svg, footprint.yaml (for Nav2) and, with the extra
    plots, footprint.png into OUT.

    \b
    assetpipe footprint robot.urdf -o footprint/
    assetpipe footprint robot.urdf -o footprint/ --below 30cm --tolerance 5mm
    assetpipe footprint robot.urdf -o footprint/ --joint lift=0:0.4 --joint arm=1.57
    """
    from assetpipe.cli.options import deliver_json
    from assetpipe.report.footprint import as_record, can_draw, nav2, svg, write_picture
    from assetpipe.report.json import write_json
    from assetpipe.robot.footprint import configurations, footprint
    from assetpipe.robot.reader import read_robot

    robot = read_robot(source).robot
    found = footprint(
        robot,
        configurations(robot, _ranges(given["joints"]), given["steps"]),
        tolerance=_metres("tolerance", given["tolerance"]),
        below=_metres("below", given["below"]) if given["below"] else None,
        source=given["elements"] or "collision",
    )
    record = as_record(robot.name, found)
    out.mkdir(parents=True, exist_ok=True)
    write_json(out / "footprint.json", record)
    (out / "footprint.svg").write_text(svg(found), encoding="utf-8")
    (out / "footprint.yaml").write_text(nav2(found), encoding="utf-8")
    if can_draw():
        write_picture(out / "footprint.png", found)
    else:
        click.echo("no picture: install assetpipe[plots] for footprint.png", err=True)
    for sentence in found.skipped:
        click.echo(f"left out: {sentence}", err=True)
    deliver_json(given["json_file"], record)
    if given["json_file"] != STDOUT:
        click.echo(
            f"{robot.name}: {found.outline.area:.4f} m², {len(found.decomposition.parts)} parts, "
            f"concavity {found.decomposition.concavity:.4g} m, inner {found.inner.area:.4f} m²"
        )
    return 1 if found.skipped else 0


def _metres(name: str, text: str) -> float:
    from assetpipe.decomposition.tolerance import Tolerance
    from assetpipe.errors import UsageError

    length = Tolerance.parse(text)
    if length.unit != "metres":
        raise UsageError(f"--{name} is a length such as 5mm, not '{text}'")
    return length.value


def _ranges(joints: tuple[str, ...]) -> dict[str, tuple[float, float]]:
    from assetpipe.errors import UsageError

    ranges = {}
    for text in joints:
        name, _, value = text.partition("=")
        low, _, high = value.partition(":")
        try:
            ranges[name] = (float(low), float(high or low))
        except ValueError as error:
            raise UsageError(f"--joint is NAME=VALUE or NAME=LOW:HIGH, not '{text}'") from error
    return ranges
