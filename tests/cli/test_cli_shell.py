"""What the command line promises whatever the command does."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

import assetpipe
from assetpipe.cli import shell
from assetpipe.cli.shell import COMMANDS

ROOT = Path(__file__).resolve().parents[2]
Cli = Callable[..., subprocess.CompletedProcess[str]]


def test_version(cli: Cli) -> None:
    done = cli("--version")
    assert (done.returncode, done.stdout) == (0, f"assetpipe, version {assetpipe.__version__}\n")


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help_with_an_example(cli: Cli, command: str) -> None:
    done = cli(command, "--help")
    assert done.returncode == 0
    assert f"assetpipe {command}" in done.stdout.split("Options:")[0].split("\n", 1)[1]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["bild"], "build"),
        (["build"], "INPUT"),
        (["build", "missing.urdf", "-o", "out"], "missing.urdf"),
        (["build", ".", "-o", "out", "--effort", "max"], "balanced"),
        (["build", ".", "-o", "out", "--tolerance", "2 furlongs"], "2mm"),
        (["build", ".", "-o", "out", "--format", "urdf,step"], "allowed: 'urdf'"),
        (["build", ".", "-o", "out", "--config", "planing"], "did you mean 'planning'"),
        (["build", ".", "-o", "out", "--shard", "3/2"], "between 1 and N"),
        (["build", ".", "-o", "out", "--max-hulls", "0"], "x>=1"),
        (["decompose", "notes.txt", "-o", "out"], ".stl"),
        (["report", "."], "assetpipe built"),
    ],
)
def test_wrong_usage_is_explained_and_exits_2(
    cli: Cli, tmp_path: Path, arguments: list[str], words: str
) -> None:
    (tmp_path / "notes.txt").write_text("not a mesh")
    done = cli(*arguments)
    assert done.returncode == 2
    assert words in done.stderr
    assert "Traceback" not in done.stderr
    assert done.stdout == ""
    assert not (tmp_path / "out").exists()


def test_reader_that_leaves_early_is_no_error(cli: Cli) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    done = subprocess.run(
        [sys.executable, "-m", "assetpipe", "--help"],
        stdout=writing,
        stderr=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        check=False,
    )
    os.close(writing)
    assert done.stderr == b""
    assert done.returncode == 141


def test_fault_of_ours_is_short_and_logged(cli: Cli, tmp_path: Path) -> None:
    program = (
        "import assetpipe.cli.shell as m\n"
        "def broken(*a, **k): raise ZeroDivisionError('inner words')\n"
        "m.Commands.get_command = broken\n"
        "raise SystemExit(m.run(['build']))"
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "XDG_CACHE_HOME": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        env=environment,
        check=False,
    )
    assert done.returncode == 3
    assert "Traceback" not in done.stderr
    log = next((tmp_path / "assetpipe/logs").iterdir())
    assert str(log) in done.stderr
    assert "ZeroDivisionError: inner words" in log.read_text()
    loud = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        env={**environment, "ASSETPIPE_DEBUG": "1"},
        check=False,
    )
    assert "Traceback" in loud.stderr


def test_start_imports_nothing_slow() -> None:
    program = (
        "import sys, json; from assetpipe.cli.shell import run; run(['--version']);"
        "print(json.dumps(sorted(sys.modules)))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        check=True,
    )
    modules = set(json.loads(done.stdout.splitlines()[-1]))
    slow = {"numpy", "scipy", "trimesh", "pydantic", "rich", "lxml", "yourdfpy", "fcl", "pybullet"}
    assert not modules & slow


def test_a_signal_that_a_library_swallows_still_stops_the_build(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Imports catch every exception, and with it the one that Ctrl-C raises."""
    from assetpipe.pipeline import build as pipeline_build

    out = tmp_path / "out"
    real = pipeline_build.find_sources

    def swallow(inputs):
        with contextlib.suppress(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(5)
        return real(inputs)

    monkeypatch.setattr(pipeline_build, "find_sources", swallow)
    mesh = Path(__file__).parents[2] / "sample_assets/toaster/meshes/lever.obj"
    assert shell.run(["build", str(mesh), "-o", str(out), "--no-cache"]) == 130
    assert not out.exists()
    assert "interrupted" in capsys.readouterr().err


@pytest.mark.parametrize(
    "text",
    [
        '{"schema": 1, "robots": 5}',
        '{"schema": 1, "robots": [{}], "findings": []}',
        '{"schema": 1, "robots": [], "findings": [{"severity": "error"}]}',
    ],
)
def test_a_damaged_report_is_told_and_exits_2(cli: Cli, tmp_path: Path, text: str) -> None:
    (tmp_path / "report.json").write_text(text)
    done = cli("report", "report.json")
    assert done.returncode == 2
    assert "report.json: is a damaged report" in done.stderr
