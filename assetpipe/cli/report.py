"""``assetpipe report``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click

from assetpipe.cli import options
from assetpipe.cli.options import STDOUT, JsonCommand
from assetpipe.errors import InputError, Location


@click.command(cls=JsonCommand)
@click.argument("out", metavar="OUT", type=click.Path(exists=True, path_type=Path))
@options.report_files
def command(out: Path, **given: Any) -> int:
    """Show the report of a built package again, in any form.

    \b
    assetpipe report out/
    assetpipe report out/ --sarif findings.sarif
    """
    from assetpipe.cli.reports import unowned
    from assetpipe.pipeline.record import read_record
    from assetpipe.report.junit import write_junit
    from assetpipe.report.sarif import write_sarif
    from assetpipe.report.terminal import console_for, show_build

    record = read_record(out)
    try:
        if given["junit"]:
            write_junit(given["junit"], record["robots"], unowned(record))
        if given["sarif"]:
            write_sarif(given["sarif"], record["findings"], root=Path.cwd())
        options.deliver_json(given["json_file"], record)
        if given["json_file"] != STDOUT:
            show_build(console_for(sys.stdout), record)
    except (AttributeError, LookupError, TypeError, ValueError) as error:
        # Whoever wrote it: not all of it is there, or something else is in its place.
        raise InputError("is a damaged report of assetpipe", location=Location(out)) from error
    return 0
