"""When to give up."""

from __future__ import annotations

from dataclasses import dataclass
from time import process_time

from assetpipe.errors import LimitError


@dataclass(frozen=True)
class Deadline:
    """The processor time at which work ends, and how much there was at first.

    Attributes:
        at: as :func:`time.process_time` tells it.
        seconds: what the user allowed.
    """

    at: float
    seconds: float

    @classmethod
    def after(cls, seconds: float) -> Deadline:
        """So many seconds from now."""
        return cls(process_time() + seconds, seconds)

    def check(self) -> None:
        """Raise LimitError once it has passed."""
        if process_time() > self.at:
            raise LimitError(f"repair took more than {self.seconds:g} s")


NEVER = Deadline(float("inf"), float("inf"))
"""No limit."""
