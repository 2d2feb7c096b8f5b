"""Repair the collision meshes of real robots, each under limits, and tell how far it moved them.

    python benchmarks/repair.py FOLDER... [--json F] [--seconds 60] [--memory 4]

Every URDF below the folders is read; each distinct (mesh file, scale) of its collisions is
repaired once, in a process of its own. Times are processor time. The deviation is the larger of
both directions' 99th percentiles over the area, as a share of the bounding box's diagonal.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import resource
import signal
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from assetpipe.errors import AssetpipeError
from assetpipe.geometry import read_mesh, repair
from assetpipe.pipeline.identity import digest_file
from assetpipe.robot import MeshShape, read_robot

_PATIENCE = 20

OPEN = "AP208"
"""The finding about openings whose meaning is ambiguous."""


def meshes_of(folders: list[Path]) -> dict[tuple[str, tuple[float, ...]], tuple[Path, str]]:
    """(digest, scale) → (file, robot), in the order of the files' paths."""
    found: dict[tuple[str, tuple[float, ...]], tuple[Path, str]] = {}
    for folder in folders:
        for urdf in sorted(folder.rglob("*.urdf")):
            try:
                robot = read_robot(urdf).robot
            except AssetpipeError as error:
                print(f"{urdf}: {error.message}", file=sys.stderr)
                continue
            for link in robot.links:
                for collision in link.collisions:
                    shape = collision.shape
                    if isinstance(shape, MeshShape) and shape.path is not None:
                        key = digest_file(shape.path), tuple(float(x) for x in shape.scale)
                        found.setdefault(key, (shape.path, urdf.parent.name))
    return found


def one(path: Path, scale: tuple[float, ...]) -> dict[str, Any]:
    """What repair makes of a mesh."""
    try:
        mesh = read_mesh(path).mesh.scaled(scale)
        clock = time.process_time()
        result = repair(mesh)
        seconds = time.process_time() - clock
    except AssetpipeError as error:
        return {"state": "unreadable", "why": str(error.message)}
    return {
        "state": "solid" if result.solid is not None else "refused",
        "why": "; ".join(f.message for f in result.findings if f.severity.value == "error"),
        "faces": len(mesh.faces),
        "rung": result.rung.value if result.rung else "none",
        "seconds": seconds,
        "p99": result.deviation.p99 / mesh.diagonal,
        "largest": result.deviation.largest / mesh.diagonal,
        "ambiguous": any(f.code == OPEN for f in result.findings),
        "notes": [f.message for f in result.findings],
    }


def _worker(pipe: Any, path: Path, scale: tuple[float, ...], seconds: int, memory: int) -> None:
    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 5))
    try:
        pipe.send(one(path, scale))
    except MemoryError:
        pipe.send({"state": "memory", "why": "out of memory"})


def limited(path: Path, scale: tuple[float, ...], seconds: float, memory: int) -> dict[str, Any]:
    """The same in a process that may crash, hang or eat memory."""
    fork = multiprocessing.get_context("fork")
    mine, theirs = fork.Pipe(duplex=False)
    process = fork.Process(target=_worker, args=(theirs, path, scale, int(seconds), memory))
    process.start()
    theirs.close()
    try:
        # Busy neighbours stretch the clock; only a hang takes this long.
        late = {"state": "hang", "why": f"more than {_PATIENCE * seconds:g} s by the clock"}
        return dict(mine.recv()) if mine.poll(_PATIENCE * seconds) else late
    except EOFError:
        process.join()
        if process.exitcode == -signal.SIGXCPU:
            return {"state": "time", "why": f"more than {seconds:g} s"}
        return {"state": "crash", "why": f"the process died ({process.exitcode})"}
    finally:
        process.kill()
        process.join()


def table(rows: list[dict[str, Any]]) -> str:
    """Markdown."""
    ended = [row for row in rows if row["state"] == "solid"]
    lines = ["| rung | meshes | median s | p95 s | within 0.3% | within 1% |", "|" + "---|" * 6]
    for rung in ["none", *dict.fromkeys(sorted(r["rung"] for r in ended if r["rung"] != "none"))]:
        some = [row for row in ended if row["rung"] == rung]
        if some:
            lines.append(_line(rung, some, len(some)))
    lines.append(_line("all", ended, len(rows)))
    states = Counter(row["state"] for row in rows)
    lines.append("")
    lines.append(", ".join(f"{n} {state}" for state, n in sorted(states.items())))
    lines.append(f"{sum(row.get('ambiguous', False) for row in rows)} with an ambiguous opening")
    return "\n".join(lines)


def _line(name: str, rows: list[dict[str, Any]], of: int) -> str:
    seconds = [row["seconds"] for row in rows]
    near = [sum(row["p99"] <= share for row in rows) / of for share in (0.003, 0.01)]
    return (
        f"| {name} | {of} | {np.median(seconds):.3f} | {np.quantile(seconds, 0.95):.2f} "
        f"| {near[0]:.1%} | {near[1]:.1%} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--seconds", type=float, default=60.0, help="processor time, a mesh")
    parser.add_argument("--memory", type=float, default=4.0, help="GiB, a mesh")
    options = parser.parse_args()
    rows = []
    for (_, scale), (path, robot) in meshes_of(options.folders).items():
        row = limited(path, scale, options.seconds, int(options.memory * 2**30))
        rows.append({"robot": robot, "mesh": path.name, **row})
        print(json.dumps(rows[-1]), file=sys.stderr, flush=True)
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1) + "\n")
    print(table(rows))


if __name__ == "__main__":
    main()
