"""A call that was asked to stop returns at once, however large the mesh."""

import _thread
import random
import signal
import threading
import time
from collections.abc import Iterator

import pytest
import trimesh

import assetpipe
from assetpipe.errors import CancelledError

# The promise is a tenth of a second. In processor time, because a loaded machine schedules threads
# late. Building what a search needs of these meshes takes longer than this by itself.
SOON = 0.5


@pytest.fixture(scope="module")
def large() -> trimesh.Trimesh:
    """A ring of 200,000 faces."""
    return trimesh.creation.torus(1.0, 0.4, major_sections=500, minor_sections=200)


@pytest.mark.parametrize("after", [0, 2, 6])
def test_false_stops_a_large_mesh_soon(large: trimesh.Trimesh, after: int) -> None:
    asked: list[float] = []

    def stop(share: float) -> bool:
        asked.append(time.process_time())
        return len(asked) <= after

    with pytest.raises(CancelledError):
        assetpipe.decompose(large, 0.002, threads=1, on_progress=stop)
    assert time.process_time() - asked[-1] < SOON


@pytest.fixture
def interruptible() -> Iterator[None]:
    """Also where the suite runs in the background of a shell, which lets it ignore interrupts."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("interruptible")
def test_an_interrupt_stops_a_large_mesh_soon(large: trimesh.Trimesh) -> None:
    sent: list[float] = []
    begun = threading.Event()

    def interrupt() -> None:
        begun.wait(60)
        time.sleep(random.Random(7).uniform(0.0, 0.2))
        sent.append(time.process_time())
        _thread.interrupt_main()

    timer = threading.Thread(target=interrupt)
    timer.start()
    with pytest.raises(KeyboardInterrupt):
        assetpipe.decompose(large, 0.002, threads=1, on_progress=lambda share: begun.set())
    timer.join()
    assert time.process_time() - sent[0] < SOON
