"""Where each source is built: OUT itself, or folders in OUT for several."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from assetpipe.errors import UsageError
from assetpipe.pipeline.inputs import Source
from assetpipe.pipeline.output import provenance_of, refuse_foreign
from assetpipe.pipeline.shards import Shard

_SHELVES = frozenset({"urdf", "urdfs", "robot", "robots", "xacro", "description", "model"})


@dataclass(frozen=True)
class Target:
    """A source and the folder that becomes its package.

    Attributes:
        source: what is built.
        out: the folder, absolute.
        prefix: path of ``out`` in the OUT that was named; empty, or ending in ``/``.
    """

    source: Source
    out: Path
    prefix: str


def targets(sources: Sequence[Source], out: Path, shard: Shard) -> tuple[Target, ...]:
    """This shard's sources with their folders; the same whatever the shard.

    Raises:
        UsageError: a folder is not ours, or would replace what is read.
    """
    if len(sources) == 1:
        placed = [Target(sources[0], out, "")]
    else:
        if provenance_of(out) is not None:
            raise UsageError(
                f"output '{out}' holds a single built package, and there are {len(sources)} "
                "robots to build; choose another folder"
            )
        names = labels(sources)
        placed = [
            Target(source, out / name, f"{name}/")
            for source, name in zip(sources, names, strict=True)
        ]
    chosen = shard.of(placed)
    for target in chosen:
        refuse_foreign(target.out)
        if target.source.path.resolve().is_relative_to(target.out):
            raise UsageError(f"output '{target.out}' holds the input '{target.source.path}'")
    return chosen


def labels(sources: Sequence[Source]) -> tuple[str, ...]:
    """A folder name for each source, from its path below the folder that was named.

    Folders that only hold descriptions (``urdf`` …) say nothing and are left out, and a
    file named like its package is not named twice: ``arm/urdf/arm.urdf`` is ``arm``.
    """
    found: list[str] = []
    for source in sources:
        folders = list(source.path.relative_to(source.root).parts[:-1])
        if source.origin == "named":
            folders.insert(0, source.root.name)
        parts = [part for part in folders if part.lower() not in _SHELVES]
        stem = source.path.name.split(".")[0]
        if not parts or parts[-1] != stem:
            parts.append(stem)
        name = "-".join(re.sub(r"[^\w.+-]", "_", part) for part in parts).strip(".-") or "robot"
        label, number = name, 2
        while label in found:
            label, number = f"{name}-{number}", number + 1
        found.append(label)
    return tuple(found)
