"""Options that several commands share, and how they become a Config."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from assetpipe.pipeline.cache import Cache
    from assetpipe.pipeline.config import Config

F = TypeVar("F", bound=Callable[..., Any])

STDOUT = "-"


class JsonCommand(click.Command):
    """A command whose ``--json`` may stand alone (stdout) or be given a file.

    Alone before an input, click would take the input for its value and overwrite it:
    only ``-`` and names that end in ``.json`` count as its value.
    """

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Make a ``--json`` that stands alone explicit."""
        explicit: list[str] = []
        rest = list(args)
        while rest:
            word = rest.pop(0)
            if word == "--":
                explicit += [word, *rest]
                break
            if word == "--json":
                value = rest[0] if rest else ""
                follows = value == STDOUT or value.lower().endswith(".json")
                explicit.append(f"--json={rest.pop(0) if follows else STDOUT}")
            else:
                explicit.append(word)
        return super().parse_args(ctx, explicit)


def _stack(options: Sequence[Callable[[F], F]]) -> Callable[[F], F]:
    def decorate(function: F) -> F:
        for option in reversed(options):
            function = option(function)
        return function

    return decorate


def inputs(function: F) -> F:
    """``INPUT...``."""
    return click.argument(
        "inputs",
        nargs=-1,
        required=True,
        metavar="INPUT...",
        type=click.Path(exists=True, path_type=Path),
    )(function)


def json_option(function: F) -> F:
    """``--json [FILE.json]``."""
    return click.option(
        "--json",
        "json_file",
        metavar="[FILE.json]",
        help="Write the result as JSON to a file, or to standard output if none is named.",
    )(function)


openings_option = click.option(
    "--openings",
    type=click.Choice(["auto", "fill", "sheet", "refuse"]),
    help="Too wide for repair to close.",
)
"""What becomes of openings: ``fill`` says that parts are solid."""

build_settings = _stack(
    [
        click.option(
            "--config",
            "config_name",
            metavar="FILE|NAME",
            help="YAML file, or default, planning, simulation.",
        ),
        click.option("--tolerance", metavar="2mm|1%", help="Length, or share of a mesh's size."),
        click.option("--max-hulls", type=click.IntRange(min=1), metavar="N", help="A mesh."),
        click.option(
            "--max-hull-vertices", type=click.IntRange(min=4), metavar="N", help="A hull."
        ),
        click.option("--source", type=click.Choice(["collision", "visual"])),
        click.option("--effort", type=click.Choice(["fast", "balanced", "best"])),
        click.option("--metric", type=click.Choice(["thickening", "concavity"])),
        click.option("--engine", type=click.Choice(["assetpipe", "coacd", "vhacd", "hull"])),
        click.option("--cavities", type=click.Choice(["fill", "keep"]), help="Sealed voids."),
        click.option("--reach", metavar="2mm", help="Gaps that no such ball enters are solid."),
        click.option(
            "--shapes",
            type=click.Choice(["hulls", "primitives", "primitives_and_capsules"]),
            help="Boxes, cylinders, spheres (capsules) for hulls.",
        ),
        click.option("--overlap", metavar="1mm", help="Of neighbouring hulls across seams."),
        click.option(
            "--inner",
            type=click.Choice(["none", "write"]),
            help="Convex polytopes inside the solid, in inner_hulls.",
        ),
        click.option("--repair", type=click.Choice(["strict", "auto", "off"])),
        openings_option,
        click.option("--seed", type=click.IntRange(min=0), metavar="N"),
        click.option("--no-validate", is_flag=True, help="Skip FCL and the physics engine."),
    ]
)
"""Options that change a Config."""

run_settings = _stack(
    [
        click.option(
            "--jobs", type=click.IntRange(1, 1024), metavar="N", help="Processes; one a core."
        ),
        click.option("--cluster", metavar="ADDR", help="Address of a Dask scheduler."),
        click.option(
            "--cache-dir", type=click.Path(file_okay=False, path_type=Path), metavar="DIR"
        ),
        click.option("--no-cache", is_flag=True, help="Compute everything anew."),
    ]
)
"""Options that say how to run, and change no byte of the output."""

report_files = _stack(
    [
        json_option,
        click.option("--junit", type=click.Path(dir_okay=False, path_type=Path), metavar="F"),
        click.option("--sarif", type=click.Path(dir_okay=False, path_type=Path), metavar="F"),
    ]
)
"""Options that write reports."""


def config_from(options: dict[str, Any]) -> Config:
    """The configuration that a command line asks for."""
    from assetpipe.pipeline.config import Config, load_config

    name = options.get("config_name")
    config = load_config(name) if name else Config()
    direct = (
        "tolerance",
        "max_hulls",
        "max_hull_vertices",
        "source",
        "effort",
        "metric",
        "engine",
        "cavities",
        "reach",
        "shapes",
        "overlap",
        "inner",
        "seed",
        "jobs",
        "formats",
    )
    changes = {key: options[key] for key in direct if options.get(key) is not None}
    repair = {"mode": options.get("repair"), "openings": options.get("openings")}
    if any(repair.values()):
        asked = {key: value for key, value in repair.items() if value}
        changes["repair"] = {**config.repair.model_dump(), **asked}
    if options.get("no_validate"):
        changes["validation"] = {**config.validation.model_dump(), "checks": []}
    return config.with_changes(**changes) if changes else config


def cache_from(options: dict[str, Any]) -> Cache:
    """The cache that a command line asks for."""
    from assetpipe.pipeline.cache import Cache, default_root

    if options.get("no_cache"):
        return Cache(None)
    return Cache(options.get("cache_dir") or default_root())


def print_json(value: Any) -> None:
    """JSON to standard output."""
    from assetpipe.report.json import to_json

    click.echo(to_json(value), nl=False)


def deliver_json(json_file: str | None, value: Any) -> None:
    """JSON to where ``--json`` says."""
    from assetpipe.report.json import write_json

    if json_file == STDOUT:
        print_json(value)
    elif json_file is not None:
        write_json(Path(json_file), value)
