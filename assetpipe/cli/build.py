"""``assetpipe build``."""

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
@click.option(
    "-o", "--out", required=True, type=click.Path(path_type=Path), metavar="OUT", help="A folder."
)
@options.build_settings
@click.option("--format", "format_list", metavar="urdf,…", help="Descriptions to write.")
@options.run_settings
@click.option("--shard", metavar="I/N", help="Build only part I of N of the robots.")
@click.option("--check", is_flag=True, help="Write nothing; say whether OUT is up to date.")
@options.report_files
def command(inputs: tuple[Path, ...], out: Path, **given: Any) -> int:
    """Decompose the collision meshes of robots and write a validated package.

    INPUT is a URDF or xacro file, a mesh, or a folder searched for robot packages.
    OUT becomes a complete package: the URDF under its own name with nothing but its
    collision elements changed, convex hulls as OBJ files, and a report.

    \b
    assetpipe build robot.urdf -o out/
    assetpipe build robot.urdf.xacro -o out/ --config simulation
    assetpipe build my_robots/ -o out/ --tolerance 2mm --jobs 8
    assetpipe build gripper.stl -o hulls/ --max-hulls 8
    """
    from assetpipe.cli.interrupt import requested
    from assetpipe.cli.progress import progress_bar
    from assetpipe.cli.reports import deliver
    from assetpipe.pipeline.build import build_all

    if given["format_list"]:
        given["formats"] = [name.strip() for name in given["format_list"].split(",")]
    config = options.config_from(given)
    with progress_bar() as listener:
        result = build_all(
            inputs,
            out,
            config=config,
            cache=options.cache_from(given),
            cluster=given["cluster"],
            shard=given["shard"],
            mode="compare" if given["check"] else "write",
            on_progress=listener,
            cancel=requested,
        )
    deliver(result, given, inputs, stream=sys.stdout)
    return result.exit_code
