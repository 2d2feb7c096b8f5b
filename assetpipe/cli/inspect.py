"""``assetpipe inspect``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click

from assetpipe.cli import options
from assetpipe.cli.options import STDOUT, JsonCommand


@click.command(cls=JsonCommand)
@options.inputs
@click.option(
    "--source", type=click.Choice(["collision", "visual"]), default="collision", show_default=True
)
@click.option("--repair", type=click.Choice(["strict", "auto", "off"]), help="How repair is tried.")
@options.openings_option
@options.run_settings
@options.json_option
def command(inputs: tuple[Path, ...], **given: Any) -> int:
    """Show the health of every mesh: what is wrong and what repair would do, one row a mesh.

    \b
    assetpipe inspect robot.urdf
    assetpipe inspect link.stl --json
    """
    from assetpipe.cli.interrupt import requested
    from assetpipe.cli.progress import progress_bar
    from assetpipe.pipeline.executors.choose import executor_for
    from assetpipe.pipeline.inspection import inspect
    from assetpipe.report.terminal import console_for, show_findings, show_health

    config = options.config_from(given)
    with progress_bar() as listener, executor_for(config.jobs, given["cluster"]) as executor:
        result = inspect(
            inputs,
            config=config,
            cache=options.cache_from(given),
            executor=executor,
            on_progress=listener,
            cancel=requested,
        )
    record = result.as_dict()
    options.deliver_json(given["json_file"], record)
    if given["json_file"] != STDOUT:
        console = console_for(sys.stdout)
        show_health(console, record["meshes"])
        show_findings(console, record["findings"])
    return result.exit_code
