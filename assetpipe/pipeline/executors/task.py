"""What every executor is given and gives back."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol

FaultKind = Literal["crash", "time", "memory", "exception"]


@dataclass(frozen=True)
class Task:
    """One piece of work for another process.

    Attributes:
        name: shown in progress, for example the links that use a mesh.
        request: JSON-ready; ``request["kind"]`` names the function that answers it.
        seconds: wall-clock limit, a stage with a result of its own.
        memory: bytes of address space.
    """

    name: str
    request: Mapping[str, Any]
    seconds: float
    memory: int


@dataclass(frozen=True)
class Fault:
    """Why a task has no (complete) answer.

    Attributes:
        kind: ``crash`` is the death of the process, ``exception`` a Python error
            that the task did not expect.
        stage: what it was doing, for example ``repair``.
        message: one sentence.
        detail: what the process said last, for the log; may be empty.
    """

    kind: FaultKind
    stage: str
    message: str
    detail: str = ""


@dataclass(frozen=True)
class Reply:
    """What became of one task.

    Attributes:
        payload: the answer's bytes; with a fault, what was complete before it, or ``None``.
        fault: what went wrong, or ``None``.
        seconds: wall-clock time.
    """

    payload: bytes | None
    fault: Fault | None
    seconds: float


Listener = Callable[[int, str, float], None]
"""Called with (task index, stage, fraction in 0…1)."""

Cancelled = Callable[[], bool]
"""Asked several times a second; true stops everything."""


class Executor(Protocol):
    """Runs tasks, each isolated from the others and from the caller."""

    def run(
        self, tasks: Sequence[Task], *, listener: Listener, cancelled: Cancelled
    ) -> Iterator[tuple[int, Reply]]:
        """Yield ``(index, reply)`` as tasks end, in any order.

        Raises:
            CancelledError: ``cancelled`` said so; nothing of it still runs.
        """
        ...
