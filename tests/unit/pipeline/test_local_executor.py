import os
import signal
import subprocess
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from assetpipe.errors import CancelledError
from assetpipe.geometry.mesh import Mesh
from assetpipe.pipeline.executors import Reply, Task, local
from assetpipe.pipeline.executors.futures import FuturesExecutor
from assetpipe.pipeline.executors.local import LocalExecutor
from assetpipe.pipeline.faults import outcome_of
from assetpipe.pipeline.outcome import MeshOutcome

PARAMS = {
    "tolerance": [0.01, "relative"],
    "repair": "auto",
    "repair_budget": [0.01, "share"],
    "openings": "auto",
    "cavities": "fill",
    "faces": 1000,
    "file_size": 10**6,
}
GB = 2**30


def stl(path: Path, size: float) -> Path:
    mesh = Mesh(
        np.array([[0, 0, 0], [size, 0, 0], [0, size, 0], [0, 0, size]]),
        np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]),
    )
    rows = []
    for face in mesh.faces:
        corners = "".join("vertex {} {} {}\n".format(*mesh.vertices[v]) for v in face)
        rows.append(f"facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n")
    path.write_text("solid t\n" + "".join(rows) + "endsolid t\n")
    return path


def task(path: Path, *, seconds: float = 60.0, memory: int = 8 * GB, **changes) -> Task:
    request = {
        "kind": "mesh",
        "path": str(path),
        "scale": [1.0, 1.0, 1.0],
        "params": PARAMS,
        "contact": None,
        "until": "repair",
        **changes,
    }
    return Task(path.stem, request, seconds, memory)


def run(executor, tasks, listener=lambda *_: None, cancelled=lambda: False) -> list[Reply]:
    replies = dict(executor.run(tasks, listener=listener, cancelled=cancelled))
    return [replies[index] for index in range(len(tasks))]


def faces(reply: Reply) -> int:
    assert reply.fault is None
    assert reply.payload is not None
    return MeshOutcome.decode(reply.payload).facts["faces"]


def never_ends(path: Path) -> None:
    """Put a pipe in a mesh file's place: whoever reads it waits for ever."""
    path.unlink()
    os.mkfifo(path)


@pytest.fixture
def meshes(tmp_path: Path) -> list[Path]:
    return [stl(tmp_path / f"m{n}.stl", 1.0 + n) for n in range(4)]


@pytest.fixture(autouse=True)
def processes(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[subprocess.Popen[bytes]]]:
    """Every process that was started; none may be left at the end."""
    started: list[subprocess.Popen[bytes]] = []

    class Watched(subprocess.Popen):  # type: ignore[type-arg]
        def __init__(self, *args, **changes) -> None:
            super().__init__(*args, **changes)
            started.append(self)

    monkeypatch.setattr(local.subprocess, "Popen", Watched)
    yield started
    assert all(process.returncode is not None for process in started)


@pytest.mark.parametrize("jobs", [1, 3])
def test_all_tasks_are_answered(meshes: list[Path], jobs: int) -> None:
    replies = run(LocalExecutor(jobs), [task(path) for path in meshes])
    assert [faces(reply) for reply in replies] == [4, 4, 4, 4]
    sizes = [MeshOutcome.decode(r.payload or b"").facts["diagonal"] for r in replies]
    assert sizes == sorted(sizes)


@pytest.mark.parametrize("number", [signal.SIGSEGV, signal.SIGABRT, signal.SIGKILL])
def test_death_of_a_process_costs_its_task_only(
    meshes: list[Path], number: int, processes: list[subprocess.Popen[bytes]]
) -> None:
    def listener(index: int, stage: str, fraction: float) -> None:
        if index == 1 and len(processes) == 1:
            os.kill(processes[0].pid, number)

    never_ends(meshes[1])

    replies = run(LocalExecutor(1), [task(path) for path in meshes], listener)
    assert len(processes) == 2
    fault = replies[1].fault
    assert fault is not None
    assert fault.kind == "crash"
    assert signal.Signals(number).name in fault.message
    assert [faces(replies[n]) for n in (0, 2, 3)] == [4, 4, 4]
    finding = outcome_of(replies[1]).findings[0]
    assert finding.code in ("AP102", "AP202")


def test_overdue_task_is_ended(meshes: list[Path]) -> None:
    never_ends(meshes[0])
    tasks = [task(meshes[0], seconds=1.0), task(meshes[1])]
    replies = run(LocalExecutor(1), tasks)
    assert replies[0].fault is not None
    assert replies[0].fault.kind == "time"
    assert faces(replies[1]) == 4
    assert "limits.seconds" in (outcome_of(replies[0]).findings[0].hint or "")


@pytest.mark.skipif(os.name != "posix", reason="address space is limited on POSIX only")
def test_greedy_task_is_ended(meshes: list[Path]) -> None:
    tasks = [task(meshes[0], memory=GB // 8), task(meshes[1])]
    replies = run(LocalExecutor(1), tasks)
    assert replies[0].fault is not None
    assert replies[0].fault.kind == "memory"
    assert faces(replies[1]) == 4


def test_unexpected_exception_is_told_and_the_process_goes_on(meshes: list[Path]) -> None:
    replies = run(LocalExecutor(1), [task(meshes[0], params={}), task(meshes[1])])
    fault = replies[0].fault
    assert fault is not None
    assert fault.kind == "exception"
    assert "KeyError" in fault.message
    assert "Traceback" in fault.detail
    assert faces(replies[1]) == 4
    assert outcome_of(replies[0]).findings[0].code == "AP901"


def test_cancel_stops_within_a_moment(meshes: list[Path]) -> None:
    began = time.monotonic()
    asked: list[int] = []

    def cancelled() -> bool:
        asked.append(1)
        return len(asked) > 2

    with pytest.raises(CancelledError):
        run(LocalExecutor(2), [task(path) for path in meshes], cancelled=cancelled)
    assert time.monotonic() - began < 30  # far from the tasks' own limits


def test_any_pool_gives_the_same_answers(meshes: list[Path]) -> None:
    tasks = [task(path) for path in meshes]
    with ThreadPoolExecutor(2) as pool:
        far = run(FuturesExecutor(pool), tasks)
    near = run(LocalExecutor(1), tasks)
    assert [r.payload for r in far] == [r.payload for r in near]


def test_pool_that_breaks_is_a_fault_of_its_task(meshes: list[Path]) -> None:
    class Broken(ThreadPoolExecutor):
        def submit(self, function, /, *args):  # type: ignore[override]
            def fail() -> None:
                raise RuntimeError("worker lost")

            return super().submit(fail)

    with Broken(1) as pool:
        reply = run(FuturesExecutor(pool), [task(meshes[0])])[0]
    assert reply.fault is not None
    assert "worker lost" in reply.fault.message
