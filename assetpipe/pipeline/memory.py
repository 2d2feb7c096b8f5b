"""Built packages to the ledger and back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from assetpipe.errors import InputError
from assetpipe.pipeline import ledger
from assetpipe.pipeline.cache import Cache
from assetpipe.pipeline.output import Stage
from assetpipe.pipeline.result import RobotResult
from assetpipe.pipeline.run import load_outcome

_OUT = "\0OUT"
"""Stands for the folder of the package in what is stored: it may be another one next time."""


def remember(
    cache: Cache,
    key: str,
    robot: RobotResult,
    stage: Stage,
    *,
    outputs: Mapping[str, str],
    inputs: Mapping[str, str],
) -> None:
    """Store what was staged for one robot.

    Args:
        cache: where to.
        key: the source's fingerprint.
        robot: the result; paths in it relative to the stage.
        stage: the written files.
        outputs: SHA-256 by path of every staged file.
        inputs: SHA-256 by absolute path of every file that was read or copied.
    """
    record = {"robot": robot.as_dict(), "keys": [mesh.key for mesh in robot.meshes]}
    ledger.remember(
        cache,
        key,
        result=_replaced(record, str(stage.out), _OUT),
        tree=stage.folder,
        outputs=outputs,
        inputs=inputs,
    )


def recall(cache: Cache, key: str, stage: Stage) -> RobotResult | None:
    """Stage what was stored, and tell its result; ``None`` if there is nothing (valid)."""
    entry = ledger.recall(cache, key)
    if entry is None:
        return None
    record = _replaced(entry.result, _OUT, str(stage.out))
    entry.write(stage)
    keys = record["keys"]

    def load(index: int) -> Any:
        outcome = load_outcome(cache, keys[index])
        if outcome is None:
            raise InputError("the hulls are no longer in the cache; read the OBJ files, or rebuild")
        return outcome

    return RobotResult.of(record["robot"], keys, load)


def _replaced(value: Any, old: str, new: str) -> Any:
    """The value with a prefix of paths exchanged in all its strings."""
    if isinstance(value, str):
        return value.replace(old, new)
    if isinstance(value, Mapping):
        return {key: _replaced(item, old, new) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_replaced(item, old, new) for item in value]
    return value
