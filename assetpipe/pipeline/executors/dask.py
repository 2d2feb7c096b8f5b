"""Tasks on a Dask cluster."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

from assetpipe.errors import InputError, UsageError
from assetpipe.pipeline.executors.futures import FuturesExecutor


@contextlib.contextmanager
def dask_executor(address: str) -> Iterator[FuturesExecutor]:
    """An executor on the cluster whose scheduler has this address.

    Raises:
        UsageError: Dask is not installed.
        InputError: no scheduler answers.
    """
    try:
        from distributed import Client
    except ImportError as error:
        raise UsageError(
            "--cluster needs Dask: pip install 'assetpipe[cluster]' here and on the workers"
        ) from error
    try:
        client = Client(address, timeout=10)
    except (OSError, ValueError) as error:
        raise InputError(f"no Dask scheduler answers at '{address}': {error}") from error
    try:
        # A crash is contained below, so a task that Dask sees fail is not worth many tries.
        yield FuturesExecutor(client.get_executor(pure=False, retries=1))
    finally:
        client.close()
