"""``assetpipe validate``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click

from assetpipe.cli import options
from assetpipe.cli.options import STDOUT, JsonCommand


@click.command(
    cls=JsonCommand,
    epilog="Exit codes: 0 fine, 1 findings, 2 usage or unreadable input, 3 a fault of assetpipe.",
)
@click.argument("robots", nargs=-1, metavar="[ORIGINAL BUILT]", type=click.Path(path_type=Path))
@click.option(
    "--scene", "scenes", multiple=True, metavar="FILE|NAME", help="A question; may be repeated."
)
@click.option("--explain", is_flag=True, help="Say what scenes would simulate and why, no more.")
@click.option("--sensitivity", is_flag=True, help="Answer scenes with every effect toggled, too.")
@click.option(
    "--srdf-out",
    type=click.Path(path_type=Path),
    metavar="F",
    help="Write pairs that a planner need not ask.",
)
@click.option(
    "--srdf",
    type=click.Path(path_type=Path),
    metavar="F",
    help="Add them to this SRDF; every byte of it stays.",
)
@click.option("--config", "config_name", metavar="FILE|NAME", help="As for build.")
@click.option("--jobs", type=click.IntRange(1, 1024), metavar="N", help="Processes; one a core.")
@options.json_option
def command(robots: tuple[Path, ...], **given: Any) -> int:
    """Compare a built robot with its original, whoever built it, and answer scenes.

    Every link's hulls are certified against the original's solid and probed near
    contact, self-collisions are compared over sampled configurations, and a physics
    engine loads the result. BUILT may be a folder with one URDF. A scene names its own
    assets and can stand alone.

    \b
    assetpipe validate robot.urdf out/
    assetpipe validate robot.urdf out/ --srdf robot.srdf --srdf-out out/robot.srdf
    assetpipe validate --scene drawer_opens_by_handle --sensitivity
    assetpipe validate --scene my_scene.yaml --explain
    """
    from assetpipe.cli.interrupt import requested
    from assetpipe.cli.progress import progress_bar
    from assetpipe.cli.srdf import deliver_srdf, given_srdf
    from assetpipe.errors import UsageError
    from assetpipe.pipeline.compare import explain, validate
    from assetpipe.report.terminal import console_for
    from assetpipe.report.validation import show_plans, show_validation

    if len(robots) not in (0, 2):
        raise UsageError("name both ORIGINAL and BUILT, or scenes alone")
    original, built = robots if robots else (None, None)
    for path in robots:
        if not path.exists():
            raise UsageError(f"'{path}' does not exist")
    console = console_for(sys.stdout)
    if given["explain"]:
        if robots or not given["scenes"]:
            raise UsageError("--explain tells the plans of scenes: name scenes, and no robots")
        plans = explain(given["scenes"])
        options.deliver_json(given["json_file"], {n: plan.as_dict() for n, plan in plans.items()})
        if given["json_file"] != STDOUT:
            show_plans(console, plans)
        return 0
    srdf = given_srdf(given, robots)
    config = options.config_from(given)
    if given["srdf_out"] is not None and "self_collision" not in config.validation.checks:
        raise UsageError("--srdf-out needs the check self_collision, which the config leaves out")
    with progress_bar() as listener:
        result = validate(
            original,
            built,
            scenes=given["scenes"],
            depth="sensitivity" if given["sensitivity"] else "answer",
            config=config,
            on_progress=listener,
            cancel=requested,
        )
    if given["srdf_out"] is not None:
        deliver_srdf(srdf, given["srdf"], result, given["srdf_out"])
    options.deliver_json(given["json_file"], {**result.as_dict(), "seconds": result.seconds})
    if given["json_file"] != STDOUT:
        show_validation(console, result)
    return result.exit_code
