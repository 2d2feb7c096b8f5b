"""Repair the collision meshes of real robots, each under limits, and tell how far it moved them.

    python benchmarks/repair.py NAME=FOLDER... [--journal F] [--seconds 90] [--memory 4]
        [--sample SHARE] [--without PART]

Every URDF below the folders is read; each distinct (mesh file, scale) of its collisions is
repaired once, in a process of its own. Times are processor time, libraries loaded before. The
deviation is the larger of both directions' 99th percentiles over the area, as a share of the
bounding box's diagonal. A journal has a line of JSON for each mesh; a run that finds one goes on
where it ended. A sample takes the meshes whose digests are lowest: the same ones every time.
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import sys
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from in_process import Died, limited

from assetpipe.errors import AssetpipeError
from assetpipe.geometry import Repaired, read_mesh, repair
from assetpipe.pipeline.identity import digest_file
from assetpipe.robot import MeshShape, read_robot

_LIBRARIES = ("igl", "manifold3d", "scipy.spatial")
_NO_END = "did not end"

OPEN = "AP208"
"""The finding about openings whose meaning is ambiguous."""


@dataclass(frozen=True)
class Source:
    """One mesh of a collision as a robot uses it."""

    package: str
    path: Path
    name: str
    scale: tuple[float, ...]
    digest: str

    @property
    def key(self) -> str:
        """The same for the same bytes at the same scale."""
        return f"{self.digest} {self.scale}"


def sources_of(package: str, folder: Path, without: str | None) -> list[Source]:
    """Each distinct mesh and scale once, in the order of the URDFs' paths."""
    found: dict[str, Source] = {}
    for urdf in sorted(folder.rglob("*.urdf")):
        if without is not None and without in urdf.parts:
            continue
        try:
            robot = read_robot(urdf).robot
        except AssetpipeError as error:
            print(f"{urdf}: {error.message}", file=sys.stderr)
            continue
        for link in robot.links:
            for collision in link.collisions:
                shape = collision.shape
                if isinstance(shape, MeshShape) and shape.path is not None:
                    name = os.path.relpath(shape.path, folder)
                    scale = tuple(float(x) for x in shape.scale)
                    source = Source(package, shape.path, name, scale, digest_file(shape.path))
                    found.setdefault(source.key, source)
    return list(found.values())


def one(source: Source) -> dict[str, Any]:
    """What repair makes of a mesh."""
    try:
        mesh = read_mesh(source.path).mesh.scaled(source.scale)
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
        "folds": any("folds" in text for text in _said(result)),
        "notes": [f.message for f in result.findings],
    }


def _said(result: Repaired) -> tuple[str, ...]:
    return (*(step.what for step in result.steps), *result.notes)


def _told(answer: dict[str, Any] | Died, seconds: int) -> dict[str, Any]:
    """The row of a mesh that did not end says why; one out of time took all of it."""
    if not isinstance(answer, Died):
        return answer
    spent = {"seconds": seconds} if answer.state == "time" else {}
    return {"state": answer.state, "why": answer.why, **spent}


def table(rows: list[dict[str, Any]], by: str) -> str:
    """Markdown: a line for each value of ``by``, and one for all."""
    titles = "meshes | median s | p95 s | within 0.3% | within 1% | did not end | ambiguous"
    lines = [f"| {by} | {titles} |", "|" + "---|" * 8]
    for value in dict.fromkeys(row.get(by, _NO_END) for row in rows):
        lines.append(_line(value, [row for row in rows if row.get(by, _NO_END) == value]))
    lines.append(_line("all", rows))
    return "\n".join(lines)


def _line(name: str, rows: list[dict[str, Any]]) -> str:
    ended = [row for row in rows if row["state"] == "solid"]
    seconds = [row["seconds"] for row in rows if "seconds" in row] or [np.nan]
    near = [sum(row["p99"] <= share for row in ended) / len(rows) for share in (0.003, 0.01)]
    ambiguous = sum(row.get("ambiguous", False) for row in rows)
    return (
        f"| {name} | {len(rows)} | {np.median(seconds):.3f} | {np.quantile(seconds, 0.95):.2f} "
        f"| {near[0]:.1%} | {near[1]:.1%} | {len(rows) - len(ended)} | {ambiguous} |"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="+", metavar="NAME=FOLDER")
    parser.add_argument("--journal", type=Path)
    parser.add_argument("--seconds", type=int, default=90, help="processor time, a mesh")
    parser.add_argument("--memory", type=float, default=4.0, help="GiB, a mesh")
    parser.add_argument("--sample", type=float, default=1.0, help="share of the meshes")
    parser.add_argument("--without", help="folder of that name is left out")
    options = parser.parse_args()
    for library in _LIBRARIES:
        importlib.import_module(library)
    journal = _journal(options.journal)
    rows = []
    for argument in options.folders:
        package, _, folder = argument.rpartition("=")
        sources = sources_of(package, Path(folder), options.without)
        number = round(options.sample * len(sources))
        chosen = {source.key for source in sorted(sources, key=lambda s: s.key)[:number]}
        for source in sources:
            if source.key not in chosen:
                continue
            row = journal.get(f"{package} {source.key}")
            if row is None:
                made = _told(limited(one, source, options.seconds, options.memory), options.seconds)
                row = {"package": package, "key": source.key, "mesh": source.name, **made}
                if options.journal:
                    with options.journal.open("a") as stream:
                        stream.write(json.dumps(row) + "\n")
            rows.append(row)
    print(table(rows, "package"), table(rows, "rung"), sep="\n\n")
    states = Counter(row["state"] for row in rows)
    folds = sum(row.get("folds", False) for row in rows)
    print("\n" + ", ".join(f"{n} {state}" for state, n in sorted(states.items())), end="; ")
    print(f"{folds} with folds without thickness")


def _journal(path: Path | None) -> dict[str, dict[str, Any]]:
    """What an earlier run found."""
    if path is None or not path.exists():
        return {}
    rows = [json.loads(line) for line in path.read_text().splitlines()]
    return {f"{row['package']} {row['key']}": row for row in rows}


if __name__ == "__main__":
    main()
