"""``assetpipe decompose``."""

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
@click.argument("mesh", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option(
    "-o", "--out", required=True, type=click.Path(path_type=Path), metavar="OUT", help="A folder."
)
@options.build_settings
@options.run_settings
@options.report_files
def command(mesh: Path, out: Path, **given: Any) -> int:
    """Decompose one mesh into convex hulls, one OBJ file each.

    Outlines (.geojson, .csv, .svg) become nearly convex polygons in parts.geojson.

    Unlike build, sealed voids are kept unless --cavities fill is given.

    \b
    assetpipe decompose bracket.stl -o hulls/ --tolerance 2mm
    assetpipe decompose bracket.stl -o hulls/ --json
    """
    from assetpipe.cli.interrupt import requested
    from assetpipe.cli.outlines import decompose_outlines
    from assetpipe.cli.progress import progress_bar
    from assetpipe.cli.reports import deliver
    from assetpipe.errors import UsageError
    from assetpipe.pipeline.build import build_all
    from assetpipe.pipeline.inputs import MESH_SUFFIXES
    from assetpipe.polygon.files import SUFFIXES as OUTLINE_SUFFIXES

    if mesh.suffix.lower() in OUTLINE_SUFFIXES:
        return decompose_outlines(mesh, out, given)
    if mesh.suffix.lower() not in MESH_SUFFIXES:
        raise UsageError(
            f"'{mesh}' is no mesh that can be read; known are {', '.join(MESH_SUFFIXES)} "
            "(robots: assetpipe build)"
        )
    if given["cavities"] is None and given["config_name"] is None:
        given["cavities"] = "keep"
    config = options.config_from(given)
    with progress_bar() as listener:
        result = build_all(
            (mesh,),
            out,
            config=config,
            cache=options.cache_from(given),
            cluster=given["cluster"],
            on_progress=listener,
            cancel=requested,
        )
    deliver(result, given, (mesh,), stream=sys.stdout)
    return result.exit_code
