"""Tasks in processes of this machine.

A pool of our own: ``concurrent.futures`` loses every task when one process dies,
and ``multiprocessing``'s spawn imports the caller's ``__main__`` again. Here a
dead, late or greedy process costs its own task only and is replaced.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from typing import IO, Any

from assetpipe.errors import CancelledError
from assetpipe.pipeline.executors.task import Cancelled, Fault, FaultKind, Listener, Reply, Task

POLL = 0.05
"""Seconds between looks at clocks and the cancel token."""

LOG_TAIL = 4000
"""Bytes of a dead process' last words that are kept."""


@dataclass(frozen=True)
class LocalExecutor:
    """Up to ``jobs`` processes at once; few tasks get several threads each.

    Attributes:
        jobs: processes, and threads in all.
    """

    jobs: int

    def run(
        self, tasks: Sequence[Task], *, listener: Listener, cancelled: Cancelled
    ) -> Iterator[tuple[int, Reply]]:
        """See :class:`assetpipe.pipeline.executors.task.Executor`."""
        waiting = list(reversed(range(len(tasks))))
        threads = max(1, self.jobs // max(1, len(tasks)))
        crew: list[_Process] = []
        try:
            while waiting or any(p.index is not None for p in crew):
                if cancelled():
                    raise CancelledError("cancelled; nothing was written")
                crew = [p for p in crew if p.alive]
                idle = [p for p in crew if p.index is None]
                while waiting and (idle or len(crew) < self.jobs):
                    if idle:
                        process = idle.pop()
                    else:
                        process = _Process.start(threads)
                        crew.append(process)
                    index = waiting.pop()
                    process.give(index, tasks[index])
                channels = {p.channel: p for p in crew if p.index is not None}
                for channel in wait(list(channels), timeout=POLL):
                    yield from channels[channel].hear(listener)  # type: ignore[index]
                for process in crew:
                    yield from process.check_clock()
        finally:
            for process in crew:
                process.kill()


@dataclass
class _Process:
    """One worker process and the task it has in hand."""

    popen: subprocess.Popen[bytes]
    channel: Connection
    log: IO[bytes]
    alive: bool = True
    index: int | None = None
    task: Task | None = None
    stage: str = "start"
    partial: bytes | None = None
    began: float = 0.0
    deadline: float = field(default=float("inf"))

    @classmethod
    def start(cls, threads: int) -> _Process:
        ours, theirs = socket.socketpair()
        log = tempfile.TemporaryFile(prefix="assetpipe-worker-")  # noqa: SIM115
        # The caller's own search path, and neither its script nor its folder's.
        program = (
            f"import sys; sys.path[:] = {sys.path!r}; "
            f"from assetpipe.pipeline.worker import main; main({theirs.fileno()})"
        )
        count = str(threads)
        environment = {
            **os.environ,
            "OMP_NUM_THREADS": count,
            "OPENBLAS_NUM_THREADS": count,
            "RAYON_NUM_THREADS": count,
            "ASSETPIPE_THREADS": count,
            "PYTHONHASHSEED": "0",
        }
        popen = subprocess.Popen(
            [sys.executable, "-X", "faulthandler", "-c", program],
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=log,
            pass_fds=[theirs.fileno()],
            env=environment,
            start_new_session=True,  # Ctrl-C reaches us alone; we end them
        )
        theirs.close()
        return cls(popen, Connection(ours.detach()), log)

    def give(self, index: int, task: Task) -> None:
        self.index, self.task = index, task
        self.stage, self.partial = "start", None
        self.began = time.monotonic()
        self.deadline = self.began + task.seconds
        request = {**task.request, "memory": task.memory}
        # A process that died while idle is noticed when it is listened to.
        with contextlib.suppress(BrokenPipeError, ConnectionResetError):
            self.channel.send_bytes(json.dumps(request).encode())

    def hear(self, listener: Listener) -> Iterator[tuple[int, Reply]]:
        """Take one message."""
        try:
            message = self.channel.recv_bytes()
        except (EOFError, OSError):
            yield self._end(self._death())
            return
        kind, body = message[:1], message[1:]
        if kind == b"E":
            event = json.loads(body)
            self.stage = str(event["stage"])
            if self.index is not None:
                listener(self.index, self.stage, float(event["fraction"]))
        elif kind == b"P":
            self.partial = body
            if self.task is not None:
                self.deadline = time.monotonic() + self.task.seconds
        elif kind == b"R":
            yield self._done(Reply(body, None, time.monotonic() - self.began))
        else:
            said: dict[str, Any] = json.loads(body)
            fault = Fault(said["kind"], self.stage, said["message"], said.get("detail", ""))
            if fault.kind == "memory" and self.task is not None:
                fault = self._fault("memory", _memory_message(self.task))
                yield self._end(fault)  # its heap may be in any state
            else:
                yield self._done(Reply(self.partial, fault, time.monotonic() - self.began))

    def check_clock(self) -> Iterator[tuple[int, Reply]]:
        """End the process if its task is overdue."""
        if self.index is not None and time.monotonic() > self.deadline and self.task is not None:
            yield self._end(self._fault("time", f"took longer than {self.task.seconds:g} s"))

    def kill(self) -> None:
        """End the process and all it started."""
        self.alive = False
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(self.popen.pid, signal.SIGKILL)
        self.popen.wait()
        self.channel.close()
        self.log.close()

    def _done(self, reply: Reply) -> tuple[int, Reply]:
        index = self.index
        assert index is not None  # noqa: S101 - only busy processes are listened to
        self.index = None
        return index, reply

    def _end(self, fault: Fault) -> tuple[int, Reply]:
        reply = Reply(self.partial, fault, time.monotonic() - self.began)
        self.kill()
        return self._done(reply)

    def _fault(self, kind: FaultKind, message: str) -> Fault:
        return Fault(kind, self.stage, message, self._last_words())

    def _death(self) -> Fault:
        """What a closed channel means."""
        code = self.popen.wait()
        words = self._last_words()
        if self.task is not None and (
            "memory allocation of" in words or "bad_alloc" in words or "MemoryError" in words
        ):
            return self._fault("memory", _memory_message(self.task))
        if code < 0:
            try:
                name = signal.Signals(-code).name
            except ValueError:
                name = f"signal {-code}"
            return self._fault("crash", f"the process died ({name})")
        return self._fault("crash", f"the process ended with code {code}")

    def _last_words(self) -> str:
        try:
            size = os.fstat(self.log.fileno()).st_size
            start = max(0, size - LOG_TAIL)
            return os.pread(self.log.fileno(), LOG_TAIL, start).decode("utf-8", "replace")
        except (OSError, ValueError):
            return ""


def _memory_message(task: Task) -> str:
    return f"needed more than {task.memory / 2**30:.3g} GiB of memory"
