"""The process that works on strangers' meshes, so that its death is only a finding.

It reads requests from a socket, answers with framed messages and never prints:
native libraries write to file descriptors 1 and 2, which lead to a log.

Messages: ``E`` and JSON, an event ``{"stage", "fraction"}``; ``P`` and bytes, an
answer complete so far; ``R`` and bytes, the answer; ``X`` and JSON, an exception.
"""

from __future__ import annotations

import importlib
import json
import os
import sys
import threading
import time
from multiprocessing.connection import Connection
from typing import Any

from assetpipe.pipeline.stages import Reporter

HANDLERS = {
    "mesh": "assetpipe.pipeline.mesh_task",
    "robot": "assetpipe.pipeline.robot_task",
    "compare": "assetpipe.pipeline.compare_task",
}
"""The module whose ``answer(request, reporter) -> bytes`` serves a kind of request."""

PARENT_POLL = 0.5
"""Seconds between looks at whether the parent still lives."""


def main(descriptor: int) -> None:
    """Serve requests until the parent hangs up."""
    parent = os.getppid()
    threading.Thread(target=_leave_with, args=(parent,), daemon=True).start()
    channel = Connection(descriptor)
    _no_core_dump()
    try:
        while True:
            _serve(channel, json.loads(channel.recv_bytes()))
    except (EOFError, BrokenPipeError, ConnectionResetError):
        return


def _serve(channel: Connection, request: dict[str, Any]) -> None:
    lock = threading.Lock()

    def send(kind: bytes, payload: bytes) -> None:
        with lock:
            channel.send_bytes(kind + payload)

    try:
        _limit_memory(int(request["memory"]))
        answer = _handler(str(request["kind"]))(request, SocketReporter(send))
    except (EOFError, BrokenPipeError, ConnectionResetError):
        raise
    except Exception as error:  # noqa: BLE001 - whatever it is, it concerns this task only
        import traceback

        said = {
            "kind": "memory" if _out_of_memory(error) else "exception",
            "message": f"{type(error).__name__}: {error}"[:2000],
            "detail": traceback.format_exc()[-8000:],
        }
        send(b"X", json.dumps(said).encode())
    else:
        send(b"R", answer)


def _out_of_memory(error: BaseException | None) -> bool:
    """Whether want of memory is behind an error, be it that a library could not be loaded."""
    seen = 0
    while error is not None and seen < 20:
        said = str(error)
        if isinstance(error, MemoryError) or any(
            words in said for words in ("allocate memory", "failed to map segment", "Out of memory")
        ):
            return True
        error = error.__cause__ or error.__context__
        seen += 1
    return False


def _handler(kind: str) -> Any:
    """The function that answers a kind of request; imports only what it needs."""
    return importlib.import_module(HANDLERS[kind]).answer


class SocketReporter(Reporter):
    """Sends stages and partial answers to the parent, at most ten a second."""

    def __init__(self, send: Any) -> None:
        self._send = send
        self._last = 0.0
        self._stage = ""

    def stage(self, name: str, fraction: float = 0.0) -> None:
        """Say what is being done now."""
        now = time.monotonic()
        if name == self._stage and now - self._last < 0.1:
            return
        self._stage, self._last = name, now
        self._send(b"E", json.dumps({"stage": name, "fraction": fraction}).encode())

    def partial(self, payload: bytes) -> None:
        """Hand over an answer that stays valid should the rest fail."""
        self._send(b"P", payload)


def _leave_with(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(PARENT_POLL)
    os._exit(1)


def _limit_memory(size: int) -> None:
    try:
        import resource
    except ImportError:
        return
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    soft = size if hard == resource.RLIM_INFINITY else min(size, hard)
    try:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
    except (ValueError, OSError):  # macOS refuses to limit the address space
        return


def _no_core_dump() -> None:
    try:
        import resource
    except ImportError:
        return
    resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))


if __name__ == "__main__":
    main(int(sys.argv[1]))
