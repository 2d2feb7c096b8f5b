"""Meshes of a plan to outcomes: from the cache, or by an executor; in plan order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from assetpipe.errors import CancelledError, InputError
from assetpipe.findings import Finding, Severity
from assetpipe.pipeline.cache import Cache
from assetpipe.pipeline.config import Limits
from assetpipe.pipeline.executors import Executor, Fault, Reply, Task
from assetpipe.pipeline.executors.task import Cancelled
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
        stored = _stored(cache, job.key)
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


def outcome_of(reply: Reply) -> MeshOutcome:
    """A reply as an outcome: a fault becomes a finding on its mesh."""
    if reply.fault is None and reply.payload is not None:
        return MeshOutcome.decode(reply.payload)
    fault = reply.fault or Fault("exception", "start", "no answer")
    finding = finding_of_fault(fault)
    if reply.payload is None:
        return MeshOutcome("kept", (), (finding,), {})
    partial = MeshOutcome.decode(reply.payload)
    return MeshOutcome(
        partial.state, partial.hulls, (*partial.findings, finding), partial.facts, partial.solid
    )


def finding_of_fault(fault: Fault) -> Finding:
    """What a user should know about a fault."""
    doing = f"while at '{fault.stage}'"
    if fault.stage == "validate":
        return Finding(
            "AP411", Severity.WARNING, f"contact truth could not be told: {fault.message}"
        )
    if fault.kind in ("time", "memory"):
        code = "AP301" if fault.stage == "decompose" else "AP206"
        limit = "seconds" if fault.kind == "time" else "memory"
        return Finding(
            code, Severity.ERROR, f"{fault.message} {doing}", hint=f"raise limits.{limit}"
        )
    if fault.kind == "crash":
        code = {"read": "AP102", "start": "AP102", "repair": "AP202"}.get(fault.stage, "AP303")
        return Finding(code, Severity.ERROR, f"{fault.message} {doing}")
    return Finding("AP901", Severity.ERROR, f"{fault.message} {doing}")


def _stored(cache: Cache, key: str) -> MeshOutcome | None:
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
