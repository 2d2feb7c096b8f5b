"""``assetpipe tradeoff``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click

from assetpipe.cli import options
from assetpipe.cli.options import STDOUT, JsonCommand

TOLERANCES = "20mm,10mm,5mm,2mm,1mm"
ENGINES = ("assetpipe", "coacd", "vhacd", "hull")
EFFORTS = ("fast", "balanced", "best")


@click.command(
    cls=JsonCommand,
    epilog="Exit codes: 0 fine, 2 usage or unreadable input, 3 a fault of assetpipe.",
)
@click.argument("source", metavar="INPUT", type=click.Path(exists=True, path_type=Path))
@click.option(
    "-o", "--out", required=True, type=click.Path(path_type=Path), metavar="OUT", help="A folder."
)
@click.option("--tolerances", default=TOLERANCES, show_default=True, metavar="LIST")
@click.option("--efforts", default="balanced", show_default=True, metavar="fast,balanced,best")
@click.option("--engines", default="assetpipe", show_default=True, metavar=",".join(ENGINES))
@click.option("--config", "config_name", metavar="FILE|NAME", help="For everything else.")
@options.json_option
def command(source: Path, out: Path, **given: Any) -> int:
    """Show what accuracy costs: build at many tolerances, measure time, hulls and error.

    Writes tradeoff.json, tradeoff.csv, tradeoff.html and tradeoff.png into OUT, and
    suggests the tolerance beyond which more hulls buy less accuracy. Everything is
    computed anew on one core, so that times can be compared.

    \b
    assetpipe tradeoff robot.urdf -o tradeoff/
    assetpipe tradeoff hand.stl -o tradeoff/ --tolerances 4%,2%,1%,0.5% --efforts fast,best
    assetpipe tradeoff robot.urdf -o tradeoff/ --engines assetpipe,coacd
    """
    from assetpipe.cli.interrupt import requested
    from assetpipe.cli.options import deliver_json
    from assetpipe.cli.progress import progress_bar
    from assetpipe.decomposition.tolerance import Tolerance
    from assetpipe.pipeline.config import Config, load_config
    from assetpipe.pipeline.tradeoff import measure, settings
    from assetpipe.report.json import write_json
    from assetpipe.report.terminal import console_for
    from assetpipe.report.tradeoff import (
        can_draw,
        show_tradeoff,
        write_csv,
        write_page,
        write_picture,
    )

    chosen = settings(
        [Tolerance.parse(text) for text in given["tolerances"].split(",")],
        _names("effort", given["efforts"], EFFORTS),
        _names("engine", given["engines"], ENGINES),
    )
    config = load_config(given["config_name"]) if given["config_name"] else Config()
    with progress_bar() as listener:
        record = measure(
            source, chosen, config=config, on_progress=listener, cancel=requested
        ).as_dict()
    out.mkdir(parents=True, exist_ok=True)
    write_json(out / "tradeoff.json", record)
    write_csv(out / "tradeoff.csv", record)
    write_page(out / "tradeoff.html", record)
    if can_draw():
        write_picture(out / "tradeoff.png", record)
    else:
        click.echo("no picture: install assetpipe[plots] for tradeoff.png", err=True)
    deliver_json(given["json_file"], record)
    if given["json_file"] != STDOUT:
        show_tradeoff(console_for(sys.stdout), record)
    return 0


def _names(kind: str, text: str, known: tuple[str, ...]) -> tuple[str, ...]:
    from assetpipe.errors import UsageError, unknown_name

    names = tuple(name.strip() for name in text.split(","))
    for name in names:
        if name not in known:
            raise UsageError(unknown_name(kind, name, known))
    return names
