"""``assetpipe check``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click

from assetpipe.cli import options
from assetpipe.cli.options import JsonCommand


@click.command(
    cls=JsonCommand,
    epilog="Exit codes: 0 fine, 1 findings, 2 usage or unreadable input, 3 a fault of assetpipe.",
)
@options.inputs
@options.build_settings
@options.run_settings
@options.report_files
def command(inputs: tuple[Path, ...], **given: Any) -> int:
    """Report what is wrong with assets, without writing anything into them.

    Does all that a build does, in a temporary folder, and reports the findings. Where
    INPUT is a package that assetpipe built, its generated files are compared with
    what was written.

    \b
    assetpipe check my_robots/ --sarif findings.sarif
    assetpipe check robot.urdf --config planning --junit findings.xml
    """
    from assetpipe.cli.interrupt import requested
    from assetpipe.cli.progress import progress_bar
    from assetpipe.cli.reports import deliver
    from assetpipe.pipeline.build import check

    config = options.config_from(given)
    with progress_bar() as listener:
        result = check(
            inputs,
            config=config,
            cache=options.cache_from(given),
            cluster=given["cluster"],
            on_progress=listener,
            cancel=requested,
        )
    deliver(result, given, inputs, stream=sys.stdout)
    return result.exit_code
