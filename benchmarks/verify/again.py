"""The same bytes with other jobs, hash seed and working directory, and from a warm cache."""

from __future__ import annotations

import filecmp
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from verify.verdict import Verdict


def same_tree(a: Path, b: Path) -> list[str]:
    """Files that differ or are on one side only."""
    names = {p.relative_to(r).as_posix() for r in (a, b) for p in r.rglob("*") if p.is_file()}
    return sorted(
        n
        for n in names
        if not ((a / n).is_file() and (b / n).is_file() and filecmp.cmp(a / n, b / n, False))
    )


def check_rebuild(verdict: Verdict, original: Path) -> None:
    """Byte-identical whatever the jobs, hash seed and folder; warm cache 20 times faster."""
    environment = dict(os.environ)
    environment["PYTHONPATH"] = str(Path(__file__).resolve().parents[2])
    with tempfile.TemporaryDirectory() as folder:
        base = Path(folder)
        walls: dict[str, float] = {}
        cpus: dict[str, float] = {}

        def run(name: str, out: str, jobs: int, cache: str) -> None:
            where = base / f"cwd-{jobs}"
            where.mkdir(exist_ok=True)
            environment["PYTHONHASHSEED"] = str(jobs)
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            start = time.monotonic()
            done = subprocess.run(
                [
                    *(sys.executable, "-m", "assetpipe", "build", str(original.resolve())),
                    *("-o", str(base / out), "--jobs", str(jobs)),
                    *("--cache-dir", str(base / cache)),
                ],
                cwd=where,
                env=environment,
                capture_output=True,
                check=False,
                text=True,
            )
            walls[name] = time.monotonic() - start
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            cpus[name] = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
            verdict.expect(
                done.returncode in (0, 1) and (base / out / "report.json").is_file(),
                f"rebuild {name}: exit {done.returncode}: {done.stderr[-300:]}",
            )

        run("a", "one", 1, "cache-1")
        run("again", "one", 1, "cache-1")
        run("bcd", "elsewhere/two", 2, "cache-2")
        run("fresh", "three", 1, "cache-3")
        for other in ("elsewhere/two", "three"):
            differing = same_tree(base / "one", base / other)
            verdict.expect(not differing, f"builds differ in {differing[:5]}")
        verdict.facts["wall"] = {k: round(v, 2) for k, v in walls.items()}
        verdict.facts["cpu"] = {k: round(v, 2) for k, v in cpus.items()}
        verdict.expect(
            walls["again"] * 20 <= walls["a"],
            f"second run {walls['again']:.2f} s, first {walls['a']:.2f} s: "
            f"{walls['a'] / walls['again']:.1f} times faster",
        )
