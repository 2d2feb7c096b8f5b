"""The executor that was asked for."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator

from assetpipe.pipeline.executors.local import LocalExecutor
from assetpipe.pipeline.executors.task import Executor


@contextlib.contextmanager
def executor_for(jobs: int | None, cluster: str | None) -> Iterator[Executor]:
    """Processes of this machine, or a Dask cluster.

    Args:
        jobs: processes at once; ``None`` for one a core.
        cluster: address of a Dask scheduler.
    """
    if cluster is None:
        yield LocalExecutor(jobs or cores())
        return
    from assetpipe.pipeline.executors.dask import dask_executor

    with dask_executor(cluster) as executor:
        yield executor


def cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
