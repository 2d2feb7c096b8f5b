"""The group of commands, and what every error becomes for a shell."""

from __future__ import annotations

import importlib
import os
import shutil
import sys
from collections.abc import Sequence

import click

import assetpipe
from assetpipe.cli.interrupt import Terminated, heard, terminated
from assetpipe.errors import AssetpipeError, CancelledError, EngineError, unknown_name
from assetpipe.pipeline.quick import Command, again

COMMANDS = {
    "build": "Decompose the collision meshes of robots, write a validated package.",
    "check": "Report what is wrong with assets; write nothing.",
    "validate": "Compare a built robot with its original.",
    "inspect": "Show the health of every mesh.",
    "decompose": "Decompose one mesh.",
    "tradeoff": "Show what accuracy costs in time.",
    "footprint": "Project a robot onto the ground: polygons for a costmap.",
    "report": "Show the report of a built package again.",
}
"""Commands and their one-line help; a command's module is imported when it is called."""

FINE, FINDINGS, USAGE, FAULT = 0, 1, 2, 3
INTERRUPTED, BROKEN_PIPE, TERMINATED = 130, 141, 143


class Commands(click.Group):
    """Commands that are imported when they are needed."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names in the order in which one needs them."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import one command."""
        if cmd_name not in COMMANDS:
            raise click.UsageError(unknown_name("command", cmd_name, COMMANDS), ctx)
        module = importlib.import_module(f"assetpipe.cli.{cmd_name}")
        command: click.Command = module.command
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """The table of commands, without importing them."""
        with formatter.section("Commands"):
            formatter.write_dl(list(COMMANDS.items()))


@click.command(
    cls=Commands,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog="Exit codes: 0 fine, 1 findings, 2 usage or unreadable input, 3 a fault of assetpipe.",
)
@click.version_option(assetpipe.__version__, prog_name="assetpipe")
def group() -> None:
    """Collision assets for robots: certified convex decomposition, written and proved.

    \b
    assetpipe build robot.urdf -o out/           hulls within 1% of each mesh's size
    assetpipe build robot.urdf -o out/ --tolerance 2mm
    assetpipe check my_robots/ --sarif findings.sarif
    """


def main() -> None:
    """Run and leave with an exit code."""
    sys.exit(run(sys.argv[1:]))


def run(arguments: list[str]) -> int:
    """Run a command line; its exit code."""
    try:
        with heard():
            code = _run(arguments)
            sys.stdout.flush()
    except BrokenPipeError:
        # The reader has gone; Python's own flush at exit must not complain again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BROKEN_PIPE
    else:
        return code


def command_of(arguments: Sequence[str]) -> Command:
    """The command line as :mod:`assetpipe.pipeline.quick` remembers it."""
    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else 0
    return Command(tuple(arguments), width)


def _run(arguments: list[str]) -> int:
    try:
        done = again(command_of(arguments))
        if done is not None:
            click.echo(done[1], nl=False)
            return done[0]
        code = group.main(arguments, prog_name="assetpipe", standalone_mode=False, obj=arguments)
    except click.exceptions.Exit as leave:
        return leave.exit_code
    except click.ClickException as error:
        error.show()
        return USAGE
    except (KeyboardInterrupt, click.Abort, CancelledError, Terminated):
        click.echo("interrupted; nothing was left half-written", err=True)
        return TERMINATED if terminated() else INTERRUPTED
    except SystemExit as error:
        # What click makes of a broken pipe; its code 1 would say "findings".
        raise BrokenPipeError from error
    except BrokenPipeError:
        raise
    except EngineError as error:
        return _fault(error)
    except AssetpipeError as error:
        click.echo(f"error: {error}", err=True)
        return USAGE
    except Exception as error:  # noqa: BLE001 - the last resort
        return _fault(error)
    return code if isinstance(code, int) else FINE


def _fault(error: Exception) -> int:
    """A fault of ours: a short message, and the rest in a log."""
    if os.environ.get("ASSETPIPE_DEBUG"):
        raise error
    from assetpipe.cli.faults import write_log

    log = write_log(error)
    where = f"; details: {log}" if log else ""
    click.echo(
        f"assetpipe failed ({type(error).__name__}: {error}){where}\n"
        "This is a fault of assetpipe; please report it with that file.",
        err=True,
    )
    return FAULT
