"""Progress on stderr, with link names; silent where nobody looks."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from assetpipe.pipeline.progress import Progress


@contextlib.contextmanager
def progress_bar() -> Iterator[Callable[[Progress], None]]:
    """A listener for :func:`assetpipe.build`, drawn while the block runs."""
    if not sys.stderr.isatty():
        yield lambda event: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bar

    from assetpipe.report.escaping import escape

    bar = Bar(
        BarColumn(bar_width=30),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("{task.description}"),
        console=Console(stderr=True),
        transient=True,
    )
    with bar:
        task = bar.add_task("", total=None)
        active: dict[str, str] = {}

        def show(event: Progress) -> None:
            active.pop(event.name, None)
            if event.stage != "done":
                share = f" {event.fraction:.0%}" if event.fraction else ""
                active[event.name] = f"{event.stage} [bold]{escape(event.name)}[/bold]{share}"
            while len(active) > 4:
                del active[next(iter(active))]
            bar.update(
                task,
                total=event.total or None,
                completed=event.done,
                description=" · ".join(active.values()),
            )

        yield show
