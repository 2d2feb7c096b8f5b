"""Tasks through ``concurrent.futures``: any pool, near or far.

The pool's own process only starts an isolated one, as on this machine: a native
crash then costs one task, not a worker of the cluster. Mesh files travel with their
tasks, so that no file system need be shared.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from assetpipe.errors import CancelledError
from assetpipe.pipeline.executors.local import LocalExecutor
from assetpipe.pipeline.executors.task import Cancelled, Fault, Listener, Reply, Task

POLL = 0.1
"""Seconds between looks at the cancel token."""

Answer = tuple[bytes | None, tuple[str, str, str, str] | None]
"""Payload, and a fault's fields: what travels back, without our classes."""


class Pool(Protocol):
    """The part of ``concurrent.futures.Executor`` that is used."""

    def submit(self, function: Callable[..., Answer], /, *args: Any) -> Future[Answer]:
        """Call ``function(*args)`` somewhere."""
        ...


@dataclass(frozen=True)
class FuturesExecutor:
    """Runs tasks in a pool that someone else owns.

    Attributes:
        pool: for example a ``ThreadPoolExecutor``, or a Dask client's ``get_executor()``.
    """

    pool: Pool

    def run(
        self, tasks: Sequence[Task], *, listener: Listener, cancelled: Cancelled
    ) -> Iterator[tuple[int, Reply]]:
        """See :class:`assetpipe.pipeline.executors.task.Executor`."""
        began = time.monotonic()
        pending: dict[Future[Answer], int] = {}
        try:
            for index, task in enumerate(tasks):
                path = Path(str(task.request["path"]))
                future = self.pool.submit(
                    run_alone,
                    {**task.request, "path": path.name},
                    path.read_bytes(),
                    task.seconds,
                    task.memory,
                )
                pending[future] = index
                listener(index, "queued", 0.0)
            while pending:
                if cancelled():
                    raise CancelledError("cancelled; nothing was written")
                done, _ = wait(list(pending), timeout=POLL, return_when=FIRST_COMPLETED)
                for future in done:
                    yield pending.pop(future), _reply(future, time.monotonic() - began)
        finally:
            for future in pending:
                future.cancel()


def run_alone(request: Mapping[str, Any], content: bytes, seconds: float, memory: int) -> Answer:
    """Run one task in an isolated process of the machine that this is called on."""
    with tempfile.TemporaryDirectory(prefix="assetpipe-task-") as folder:
        path = Path(folder, Path(str(request["path"])).name)
        path.write_bytes(content)
        task = Task("", {**request, "path": str(path)}, seconds, memory)
        for _, reply in LocalExecutor(jobs=1).run(
            [task], listener=lambda *_: None, cancelled=lambda: False
        ):
            fault = reply.fault
            told = (fault.kind, fault.stage, fault.message, fault.detail) if fault else None
            return reply.payload, told
    return None, ("crash", "start", "the task ended without an answer", "")


def _reply(future: Future[Answer], seconds: float) -> Reply:
    error = future.exception()
    if error is not None:
        message = f"the cluster gave it up: {type(error).__name__}: {error}"[:500]
        return Reply(None, Fault("crash", "queued", message), seconds)
    payload, told = future.result()
    if told is None:
        return Reply(payload, None, seconds)
    kind, stage, message, detail = told
    return Reply(payload, Fault(kind, stage, message, detail), seconds)  # type: ignore[arg-type]
