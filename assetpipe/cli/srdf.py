"""``validate --srdf-out``: the pairs that a planner need not ask, as an SRDF."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from assetpipe.pipeline.compare import Validation


def given_srdf(given: dict[str, Any], robots: tuple[Path, ...]) -> bytes | None:
    """The SRDF to patch, looked at before anything takes long; ``None`` if there is none.

    Raises:
        UsageError: options that do not fit each other.
        InputError: no SRDF.
    """
    from assetpipe.errors import InputError, Location, UsageError
    from assetpipe.validation.srdf import patch_srdf

    source, out = given["srdf"], given["srdf_out"]
    if source is not None and out is None:
        raise UsageError("--srdf is patched into what --srdf-out names: name both")
    if out is not None and not robots:
        raise UsageError("--srdf-out tells the pairs of a robot: name ORIGINAL and BUILT")
    if out is not None and out.is_dir():
        raise UsageError(f"'{out}' is a folder; name a file")
    if source is None:
        return None
    try:
        text: bytes = source.read_bytes()
    except OSError as error:
        raise InputError(f"cannot be read ({error.strerror})", location=Location(source)) from error
    patch_srdf(text, (), path=source)
    return text


def deliver_srdf(source: bytes | None, path: Path | None, result: Validation, out: Path) -> None:
    """Write the SRDF.

    Args:
        source: to patch; ``None`` writes a new one.
        path: of the source, for messages.
        result: whose pairs.
        out: where to.
    """
    import click

    from assetpipe.robot import read_robot
    from assetpipe.validation.srdf import new_srdf, patch_srdf

    if "self_collision" not in result.checks or result.original is None:
        click.echo(f"{out} is not written: self-collision was not checked", err=True)
        return
    if source is None:
        text = new_srdf(read_robot(result.original).robot.name, result.disabled)
    else:
        text = patch_srdf(source, result.disabled, path=path)
    out.parent.mkdir(parents=True, exist_ok=True)
    out.write_bytes(text)
