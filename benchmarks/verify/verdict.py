"""What was found wrong, and what was measured."""

from __future__ import annotations


class Verdict:
    """What was found wrong, and what was measured."""

    def __init__(self) -> None:
        self.violations: list[str] = []
        self.notes: list[str] = []
        self.facts: dict[str, object] = {}

    def expect(self, holds: bool, what: str) -> bool:
        if not holds:
            self.violations.append(what)
        return holds
