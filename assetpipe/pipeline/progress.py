"""How a build tells how far it is, and how it is told to stop."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from assetpipe.pipeline.executors.task import Cancelled


@dataclass(frozen=True)
class Progress:
    """One event.

    Attributes:
        stage: ``read``, ``repair``, ``decompose``, ``validate``, ``write`` or ``done``.
        name: what it concerns: link names, or a robot.
        done: meshes finished.
        total: meshes in all.
        fraction: of this stage of this mesh, 0…1.
    """

    stage: str
    name: str
    done: int
    total: int
    fraction: float = 0.0


Listener = Callable[[Progress], None]


class Token(Protocol):
    """For example a :class:`threading.Event`."""

    def is_set(self) -> bool:
        """Whether to stop."""
        ...


def cancelled_by(cancel: Token | Cancelled | None) -> Cancelled:
    """One way to ask for all ways to cancel: an event, a function, or nothing."""
    if cancel is None:
        return lambda: False
    if callable(cancel):
        return cancel
    return cancel.is_set


def silent(event: Progress) -> None:
    """A listener that hears nothing."""
