"""How a task tells what it is doing."""

from __future__ import annotations

from typing import Protocol


class Reporter(Protocol):
    """Hears of a task's stages."""

    def stage(self, name: str, fraction: float = 0.0) -> None:
        """A stage has begun or got on: ``fraction`` of it is done."""
        ...

    def partial(self, payload: bytes) -> None:
        """An answer that stays valid should the rest of the task fail."""
        ...


class Silent:
    """A reporter for nobody."""

    def stage(self, name: str, fraction: float = 0.0) -> None:
        """Say nothing."""

    def partial(self, payload: bytes) -> None:
        """Keep nothing."""
