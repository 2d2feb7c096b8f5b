"""A case in a process of its own, which may crash, hang or eat memory."""

from __future__ import annotations

import multiprocessing
import resource
import signal
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Literal, TypeVar

Case = TypeVar("Case")
Answer = TypeVar("Answer")

_PATIENCE = 20
"""Seconds by the clock for each of processor time: busy neighbours stretch it, only a hang takes
this long."""


@dataclass(frozen=True)
class Died:
    """Why a case has no answer."""

    state: Literal["time", "memory", "hang", "crash"]
    why: str


def limited(
    function: Callable[[Case], Answer], case: Case, seconds: int, memory: float
) -> Answer | Died:
    """``function(case)`` within ``seconds`` of processor time and ``memory`` GiB."""
    fork = multiprocessing.get_context("fork")
    mine, theirs = fork.Pipe(duplex=False)
    child = fork.Process(target=_run, args=(function, case, seconds, memory, theirs))
    child.start()
    theirs.close()
    try:
        if not mine.poll(_PATIENCE * seconds):
            return Died("hang", f"more than {_PATIENCE * seconds} s by the clock")
        try:
            answer: Answer | Died = mine.recv()
        except EOFError:
            child.join()
            if child.exitcode == -signal.SIGXCPU:
                return Died("time", f"more than {seconds} s")
            return Died("crash", f"the process died ({child.exitcode})")
        return answer
    finally:
        child.kill()
        child.join()


def _run(
    function: Callable[[Case], Answer], case: Case, seconds: int, memory: float, pipe: Connection
) -> None:
    size = int(memory * 2**30)
    resource.setrlimit(resource.RLIMIT_AS, (size, size))
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 10))
    try:
        pipe.send(function(case))
    except MemoryError:
        pipe.send(Died("memory", f"more than {memory:g} GiB"))
