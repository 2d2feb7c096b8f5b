"""Meshes of a plan to outcomes: from the cache, or by an executor; in plan order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from assetpipe.errors import CancelledError, InputError
from assetpipe.pipeline.cache import Cache
from assetpipe.pipeline.config import Limits
from assetpipe.pipeline.executors import Executor, Fault, Task
from assetpipe.pipeline.executors.task import Cancelled
from assetpipe.pipeline.faults import outcome_of
from assetpipe.pipeline.outcome import MeshOutcome
from assetpipe.pipeline.plan import MeshJob
from assetpipe.pipeline.progress import Listener, Progress

ROOM = "outcomes"
"""Where the cache keeps mesh outcomes."""


@dataclass(frozen=True)
class Done:
    """A job's outcome and what it took; ``seconds`` is ``None`` if it came from the cache."""

    outcome: MeshOutcome
    seconds: float | None
    fault: Fault | None = None


def run_jobs(
    jobs: Sequence[MeshJob],
    *,
    executor: Executor,
    cache: Cache,
    limits: Limits,
    on_progress: Listener,
    cancelled: Cancelled,
) -> tuple[Done, ...]:
    """Outcomes of all jobs, in the jobs' order whatever order they end in.

    Large files start first, so that the last process does not work alone for long.

    Raises:
        CancelledError: ``cancelled`` said so.
    """
    done: dict[int, Done] = {}
    for index, job in enumerate(jobs):
        if cancelled():
            raise CancelledError("cancelled; nothing was written")
        stored = load_outcome(cache, job.key)
        if stored is not None:
            done[index] = Done(stored, None)
            on_progress(Progress("done", job.name, len(done), len(jobs), 1.0))
    todo = sorted(
        (index for index in range(len(jobs)) if index not in done),
        key=lambda index: (-_size(jobs[index]), index),
    )
    tasks = [Task(jobs[i].name, jobs[i].request(), limits.seconds, limits.memory) for i in todo]

    def listen(place: int, stage: str, fraction: float) -> None:
        name = jobs[todo[place]].name
        on_progress(Progress(stage, name, len(done), len(jobs), fraction))

    if tasks:
        for place, reply in executor.run(tasks, listener=listen, cancelled=cancelled):
            index = todo[place]
            outcome = outcome_of(reply)
            done[index] = Done(outcome, reply.seconds, reply.fault)
            if reply.fault is None and reply.payload is not None:
                cache.put(ROOM, jobs[index].key, reply.payload)
            on_progress(Progress("done", jobs[index].name, len(done), len(jobs), 1.0))
    return tuple(done[index] for index in range(len(jobs)))


def load_outcome(cache: Cache, key: str) -> MeshOutcome | None:
    """An outcome from the cache, or ``None``."""
    data = cache.get(ROOM, key)
    if data is None:
        return None
    try:
        return MeshOutcome.decode(data)
    except (InputError, KeyError, ValueError):
        return None  # of another version, or not what its name says


def _size(job: MeshJob) -> int:
    try:
        return job.path.stat().st_size
    except OSError:
        return 0
