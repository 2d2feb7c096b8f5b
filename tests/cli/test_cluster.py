"""``--cluster``: the same bytes from a Dask cluster."""

import os
import re
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

pytest.importorskip("distributed", reason="Dask is not installed: pip install 'assetpipe[cluster]'")

ROOT = Path(__file__).resolve().parents[2]
Cli = Callable[..., subprocess.CompletedProcess[str]]


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@pytest.fixture
def scheduler(tmp_path: Path) -> Iterator[str]:
    """A scheduler and one worker in processes of their own; its address."""
    address = f"tcp://127.0.0.1:{free_port()}"
    environment = {
        **os.environ,
        "PYTHONPATH": f"{ROOT}{os.pathsep}{os.environ.get('PYTHONPATH', '')}",
    }
    log = (tmp_path / "dask.log").open("wb")

    def start(*arguments: str) -> subprocess.Popen[bytes]:
        return subprocess.Popen(
            [sys.executable, "-m", *arguments],
            env=environment,
            cwd=tmp_path,
            stdout=log,
            stderr=subprocess.STDOUT,
        )

    port = address.rsplit(":", 1)[1]
    started = [
        start("distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", port,
              "--no-dashboard"),
        start("distributed.cli.dask_worker", address, "--no-nanny", "--nthreads", "2",
              "--no-dashboard"),
    ]  # fmt: skip
    until = time.monotonic() + 60
    while time.monotonic() < until:
        if re.search("Registered to", (tmp_path / "dask.log").read_text(errors="replace")):
            break
        time.sleep(0.1)
    yield address
    for process in started:
        process.terminate()
        process.wait(30)
    log.close()


def test_cluster_gives_the_same_bytes(cli: Cli, once: Path, tmp_path: Path, scheduler: str) -> None:
    done = cli("build", once / "tiny/urdf/tiny.urdf", "-o", "far", "--cluster", scheduler,
               "--no-cache")  # fmt: skip
    assert done.returncode == 0, done.stderr + done.stdout
    near = {p.relative_to(once / "out"): p.read_bytes() for p in (once / "out").rglob("*.obj")}
    far = {
        p.relative_to(tmp_path / "far"): p.read_bytes() for p in (tmp_path / "far").rglob("*.obj")
    }
    assert near == far


def test_no_scheduler_is_told(cli: Cli, once: Path) -> None:
    done = cli("build", once / "tiny/urdf/tiny.urdf", "-o", "far", "--cluster", "tcp://127.0.0.1:1",
               "--no-cache")  # fmt: skip
    assert done.returncode == 2
    assert "no Dask scheduler answers" in done.stderr
