"""Run an engine's worker in a process of its own, with limits.

PyBullet caches a URDF by its path for as long as the process lives, writes to stdout,
and takes the process down with some files; MuJoCo shares none of this but is treated
alike. Requests and answers are JSON files in a private folder, never pickles.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Literal

from assetpipe.errors import InputError, Location, UsageError, unknown_name

EngineName = Literal["bullet", "mujoco"]
Outcome = Literal["answered", "crashed", "timed out"]

_MODULES: dict[EngineName, str] = {"bullet": "pybullet", "mujoco": "mujoco"}
MEMORY_LIMIT = 8 << 30
"""Bytes of address space a worker may take."""
MAX_URDF_BYTES = 64 << 20


def available_engines() -> tuple[EngineName, ...]:
    """Engines that are installed, the preferred one first."""
    return tuple(name for name, module in _MODULES.items() if find_spec(module) is not None)


def default_engine() -> EngineName | None:
    """PyBullet where it has a wheel (CPython below 3.12), otherwise MuJoCo, otherwise none."""
    found = available_engines()
    return found[0] if found else None


def engine_for(urdf: Path, engine: EngineName | None) -> EngineName | None:
    """The engine that is to read a URDF: the one asked for, or the first that is installed.

    Raises:
        InputError: the file does not exist, or is larger than engines should be given.
        UsageError: an engine that is not installed.
    """
    if not urdf.is_file():
        raise InputError("URDF does not exist", location=Location(urdf))
    if urdf.stat().st_size > MAX_URDF_BYTES:
        limit = MAX_URDF_BYTES >> 20
        raise InputError(f"URDF is larger than {limit} MiB", location=Location(urdf))
    known = available_engines()
    if engine is not None and engine not in known:
        raise UsageError(unknown_name("installed engine", engine, known))
    return engine or default_engine()


@dataclass(frozen=True)
class WorkerAnswer:
    """How a worker ended.

    Attributes:
        outcome: whether there is an answer.
        answer: the worker's JSON object; empty without one.
        log: the end of what the engine wrote, for messages.
        signal: name of the signal that ended it, if one did.
    """

    outcome: Outcome
    answer: dict[str, Any]
    log: str
    signal: str | None = None


def run_worker(engine: EngineName, request: dict[str, Any], *, timeout: float) -> WorkerAnswer:
    """Run one request in a fresh process.

    Args:
        engine: which worker.
        request: JSON-ready object; see the workers for their keys.
        timeout: seconds of wall time.
    """
    module = f"assetpipe.validation.dynamics.{engine}_worker"
    root = Path(__file__).resolve().parents[3]
    with tempfile.TemporaryDirectory(prefix="assetpipe-engine-") as folder:
        asked, answered = Path(folder, "request.json"), Path(folder, "answer.json")
        asked.write_text(json.dumps(request), encoding="utf-8")
        environment = dict(os.environ, PYTHONPATH=_path(root))
        with subprocess.Popen(
            [sys.executable, "-m", module, str(asked), str(answered)],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            cwd=folder,
            env=environment,
            start_new_session=True,
        ) as process:
            try:
                output, _ = process.communicate(timeout=timeout)
            except BaseException as error:
                process.kill()
                output, _ = process.communicate()
                if not isinstance(error, subprocess.TimeoutExpired):
                    raise
                return WorkerAnswer("timed out", {}, _tail(output))
        if process.returncode == 0 and answered.is_file():
            return WorkerAnswer(
                "answered", json.loads(answered.read_text(encoding="utf-8")), _tail(output)
            )
        name = None
        if process.returncode < 0:
            name = signal.Signals(-process.returncode).name
        return WorkerAnswer("crashed", {}, _tail(output), name)


def _path(root: Path) -> str:
    inherited = os.environ.get("PYTHONPATH")
    return f"{root}{os.pathsep}{inherited}" if inherited else str(root)


def _tail(output: bytes) -> str:
    lines = output.decode("utf-8", errors="replace").splitlines()
    told = [line for line in lines if line.strip() and "build time" not in line]
    return "\n".join(told[-12:])[-2000:]


def serve(arguments: list[str], answer: Any) -> None:
    """A worker's main: read the request, limit memory, answer, write."""
    asked, answered = Path(arguments[0]), Path(arguments[1])
    try:
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MEMORY_LIMIT, MEMORY_LIMIT))
    except (ImportError, ValueError, OSError):
        pass  # a limit below ours is in force already, or the platform has none
    result = answer(json.loads(asked.read_text(encoding="utf-8")))
    answered.write_text(json.dumps(result), encoding="utf-8")
