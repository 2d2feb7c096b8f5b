"""Ctrl-C and SIGTERM: an exception where it can be heard, and a mark where it cannot.

Libraries that are being imported, and some that clean up, swallow every exception, and
with it the one that a signal raises. The mark survives; commands pass
:func:`requested` as their ``cancel``.
"""

from __future__ import annotations

import contextlib
import signal
import types
from collections.abc import Iterator

_received: list[int] = []
"""Signals of this process, in order. Signals are the process's, and so is this."""


class Terminated(BaseException):
    """SIGTERM: unwinds like Ctrl-C, so that nothing half-written stays."""


def requested() -> bool:
    """Whether a signal has asked to stop."""
    return bool(_received)


def terminated() -> bool:
    """Whether it was SIGTERM that asked."""
    return signal.SIGTERM in _received


def _leave(number: int, frame: types.FrameType | None) -> None:
    _received.append(number)
    raise Terminated if number == signal.SIGTERM else KeyboardInterrupt


@contextlib.contextmanager
def heard() -> Iterator[None]:
    """Hear both signals within the block; afterwards all is as before."""
    before: dict[signal.Signals, signal.Handlers] = {}
    _received.clear()
    with contextlib.suppress(ValueError):  # not in the main thread: signals go elsewhere
        for number in (signal.SIGINT, signal.SIGTERM):
            before[number] = signal.signal(number, _leave)  # type: ignore[assignment]
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
