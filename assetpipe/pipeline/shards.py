"""Parts of a batch for several machines."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

from assetpipe.errors import UsageError

Item = TypeVar("Item")


@dataclass(frozen=True)
class Shard:
    """Part ``index`` of ``count``, counted from 1."""

    index: int = 1
    count: int = 1

    def __post_init__(self) -> None:
        if not 1 <= self.index <= self.count:
            raise UsageError(f"shard {self.index}/{self.count}: I must be between 1 and N")

    @classmethod
    def parse(cls, text: str | None) -> Shard:
        """Read ``I/N``.

        Raises:
            UsageError: not of this form, or I is not between 1 and N.
        """
        if text is None:
            return cls()
        match = re.fullmatch(r"\s*(\d{1,6})\s*/\s*(\d{1,6})\s*", text)
        if match is None:
            raise UsageError(f"shard '{text}' must have the form I/N, for example 2/8")
        return cls(int(match[1]), int(match[2]))

    def of(self, items: Sequence[Item]) -> tuple[Item, ...]:
        """Every ``count``-th item, so that neighbours of like size go to different shards."""
        return tuple(items[self.index - 1 :: self.count])
