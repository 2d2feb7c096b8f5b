"""``build``: robots in, validated packages with certified hulls out."""

from __future__ import annotations

import os
import secrets
import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

from assetpipe.errors import Location, UsageError
from assetpipe.findings import Finding, Severity
from assetpipe.pipeline.batch import Batch, Built, Mode
from assetpipe.pipeline.cache import Cache, default_root
from assetpipe.pipeline.config import Config, Engine
from assetpipe.pipeline.executors.task import Cancelled
from assetpipe.pipeline.inputs import find_sources
from assetpipe.pipeline.output import PROVENANCE
from assetpipe.pipeline.progress import Listener, Token, cancelled_by, silent
from assetpipe.pipeline.quick import Part
from assetpipe.pipeline.references import references
from assetpipe.pipeline.result import BuildResult
from assetpipe.pipeline.shards import Shard
from assetpipe.pipeline.tampering import edited_files
from assetpipe.pipeline.targets import targets

Input = str | os.PathLike[str]


def build(
    input: Input | Sequence[Input],
    out: Input,
    *,
    config: Config | None = None,
    on_progress: Listener | None = None,
    cancel: Token | Cancelled | None = None,
    cache: Cache | None = None,
) -> BuildResult:
    """Decompose the collision meshes of robots and write validated packages.

    Args:
        input: a URDF or xacro file, a mesh, a folder searched for robot packages, or several.
        out: a folder: the built package; of several robots, a folder of packages. A
            package is replaced at once when it is complete, and must be absent, empty or
            built by us.
        config: what is asked; the default configuration unless given.
        on_progress: called with a :class:`assetpipe.pipeline.progress.Progress`.
        cancel: something with ``is_set()``, or a function; asked several times a second.
        cache: where results are kept; ``Cache(None)`` for none, the user's cache unless given.

    Returns:
        What was made. What is wrong with single meshes or links is in ``findings``.

    Raises:
        InputError: a named input cannot be read, or a folder holds no robot.
        UsageError: OUT is not ours, or an impossible combination.
        CancelledError: ``cancel`` said so; OUT is as it was.
    """
    given = [input] if isinstance(input, str | os.PathLike) else list(input)
    return build_all(
        [Path(item) for item in given],
        Path(out),
        config=config or Config(),
        cache=cache or Cache(default_root()),
        on_progress=on_progress or silent,
        cancel=cancel,
    )


def build_all(
    inputs: Sequence[Path],
    out: Path,
    *,
    config: Config,
    cache: Cache,
    cluster: str | None = None,
    shard: str | None = None,
    mode: Mode = "write",
    on_progress: Listener = silent,
    cancel: Token | Cancelled | None = None,
) -> BuildResult:
    """Like :func:`build`, with all that a command line may ask.

    Args:
        inputs: files and folders.
        out: the folder.
        config: what is asked.
        cache: where results are kept.
        cluster: address of a Dask scheduler.
        shard: ``I/N`` builds only part I of N of the robots.
        mode: whether OUT is written.
        on_progress: hears of it.
        cancel: stops it.
    """
    began = time.monotonic()
    out = Path(os.path.abspath(out)).resolve()
    part = Shard.parse(shard)
    require_engine(config.engine)
    chosen = targets(find_sources(inputs), out, part)
    batch = Batch(config, cache, cluster, mode, on_progress, cancelled_by(cancel))
    built, lost = batch.run(chosen)
    stale = _stale(built) if mode == "compare" else ()
    return BuildResult(
        out=out,
        robots=tuple(item.robot.below(item.target.prefix) for item in built),
        findings=(*lost, *(f for item in built for f in item.robot.findings), *stale),
        changed=tuple(item.target.prefix + name for item in built for name in item.changed),
        seconds=time.monotonic() - began,
        parts=None if lost or len(built) < len(chosen) else _parts(built),
    )


def require_engine(engine: Engine) -> None:
    """Raise :class:`UsageError` unless the engine is installed."""
    module = {"coacd": "coacd", "vhacd": "vhacdx"}.get(engine)
    if module is not None and find_spec(module) is None:
        raise UsageError(f"engine '{engine}' is not installed: pip install 'assetpipe[engines]'")


def check(
    inputs: Sequence[Path],
    *,
    config: Config,
    cache: Cache,
    cluster: str | None = None,
    on_progress: Listener = silent,
    cancel: Token | Cancelled | None = None,
) -> BuildResult:
    """Everything that a build finds out, and nothing written.

    Inputs that are packages of ours are compared with their provenance as well.
    """
    nowhere = Path(tempfile.gettempdir(), f"assetpipe-check-{secrets.token_hex(8)}")
    result = build_all(
        inputs,
        nowhere,
        config=config,
        cache=cache,
        cluster=cluster,
        mode="look",
        on_progress=on_progress,
        cancel=cancel,
    )
    edited = tuple(finding for path in inputs for finding in edited_files(Path(path)))
    return replace(result, findings=(*result.findings, *edited))


def _parts(built: Sequence[Built]) -> tuple[Part, ...] | None:
    parts: list[Part] = []
    for item in built:
        found = references(item.target.source)
        if found is None or item.key is None:
            return None
        parts.append(Part(item.target.source, item.target.out, found, item.key))
    return tuple(parts)


def _stale(built: Sequence[Built]) -> tuple[Finding, ...]:
    """A finding for every package that a build would change."""
    return tuple(
        Finding(
            "AP601",
            Severity.WARNING,
            f"{len(item.changed)} files would change: {', '.join(item.changed[:5])}"
            + (", …" if len(item.changed) > 5 else ""),
            Location(item.target.out / PROVENANCE),
            hint="build again",
        )
        for item in built
        if item.changed
    )
