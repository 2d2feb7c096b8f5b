"""Many sources at once: what is known is recalled, the rest computed side by side."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from assetpipe.errors import CancelledError
from assetpipe.findings import Finding
from assetpipe.pipeline.cache import Cache
from assetpipe.pipeline.config import Config
from assetpipe.pipeline.executors.task import Cancelled
from assetpipe.pipeline.fingerprint import fingerprint
from assetpipe.pipeline.memory import recall
from assetpipe.pipeline.output import Stage, scratch, staged
from assetpipe.pipeline.progress import Listener, Progress
from assetpipe.pipeline.result import RobotResult
from assetpipe.pipeline.targets import Target

Mode = Literal["write", "compare", "look"]
"""Write OUT; compare it with what would be written; or look at the findings only."""


@dataclass(frozen=True)
class Built:
    """One finished target.

    Attributes:
        target: what was built, and where.
        robot: the result, its files relative to the target's folder.
        changed: files that differ from what was there before, relative likewise.
        key: of the ledger's entry; ``None`` if there is none.
    """

    target: Target
    robot: RobotResult
    changed: tuple[str, ...]
    key: str | None


@dataclass(frozen=True)
class Batch:
    """What is the same for all sources of a build.

    Attributes:
        config: what is asked.
        cache: where results are kept.
        cluster: address of a Dask scheduler, or ``None`` for this machine.
        mode: whether anything is written.
        on_progress: hears of it.
        cancelled: asked several times a second.
    """

    config: Config
    cache: Cache
    cluster: str | None
    mode: Mode
    on_progress: Listener
    cancelled: Cancelled

    def run(self, targets: Sequence[Target]) -> tuple[tuple[Built, ...], tuple[Finding, ...]]:
        """One result a target that could be read, and findings about those that could not."""
        prints = {target: fingerprint(target.source, self.config) for target in targets}
        results: dict[Target, Built] = {}
        for target in targets:
            self.stop_if_cancelled()
            known = self.recall(target, prints[target])
            if known is not None:
                results[target] = known
        missing = [target for target in targets if target not in results]
        lost: tuple[Finding, ...] = ()
        if missing:
            # Imported now: an unchanged build needs none of it.
            from assetpipe.pipeline.compute import compute

            computed, lost = compute(self, missing, prints)
            results.update(computed)
            self.cache.prune()
        return tuple(results[target] for target in targets if target in results), lost

    def stop_if_cancelled(self) -> None:
        """Raise :class:`CancelledError` if the caller asked to stop."""
        if self.cancelled():
            raise CancelledError("cancelled; nothing was left half-written")

    @contextlib.contextmanager
    def stage(self, target: Target) -> Iterator[Stage]:
        """Where a target's files are written; unless OUT is, a place that is thrown away."""
        with staged(target.out) if self.mode == "write" else scratch(target.out) as stage:
            yield stage

    def settle(self, stage: Stage) -> tuple[str, ...]:
        """Let what is staged take its place, if it shall; files that differ from OUT's."""
        self.stop_if_cancelled()
        if self.mode == "write":
            return stage.commit()
        return stage.differences() if self.mode == "compare" else ()

    def recall(self, target: Target, key: str | None) -> Built | None:
        """What the ledger has under a key, written if that is asked."""
        if key is None:
            return None
        self.on_progress(Progress("read", target.source.path.name, 0, 0))
        with self.stage(target) as stage:
            robot = recall(self.cache, key, stage)
            return Built(target, robot, self.settle(stage), key) if robot is not None else None
