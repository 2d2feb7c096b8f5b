"""Measures engines on meshes, each run alone in a process of its own.

    python benchmarks/run.py --engines balanced-thickening,coacd --out results.json [PATH ...]

Rows already in the output file are kept (``--fresh`` measures again), so a long
comparison can be interrupted and resumed. ``benchmarks/compare.py`` prints tables.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from cases import ENGINES, data_folders, load, meshes, versions


def measure(engine: str, path: Path, threshold: float, repeats: int) -> dict:
    """One row, in this process."""
    from score import score

    vertices, faces, closed = load(path)
    runs = [ENGINES[engine](vertices, faces, threshold) for _ in range(repeats)]
    run = sorted(runs, key=lambda r: r.cpu_s)[len(runs) // 2]
    sides = vertices.max(axis=0) - vertices.min(axis=0)
    row = {
        "engine": engine,
        "mesh": path.stem,
        "set": path.parent.name,
        "threshold": threshold,
        "tolerance": threshold * 0.5 * float(sides.max()),
        "faces": len(faces),
        "closed": closed,
        "hulls": len(run.hulls),
        "vertices": sum(len(h) for h in run.hulls),
        "cpu_s": run.cpu_s,
        "wall_s": run.wall_s,
        "certified": run.certified,
    }
    if closed:
        row["score"] = score(vertices, faces, run.hulls).as_dict()
    return row


def isolated(engine: str, path: Path, a: argparse.Namespace) -> dict:
    """One row, measured in a process of its own; a failure is a row too."""
    command = [sys.executable, __file__, "--one", engine, str(path)]
    command += ["--threshold", str(a.threshold), "--repeats", str(a.repeats)]
    row = {
        "engine": engine,
        "set": path.parent.name,
        "mesh": path.stem,
        "threshold": a.threshold,
    }
    try:
        done = subprocess.run(
            command, check=True, capture_output=True, text=True, timeout=a.timeout
        )
    except subprocess.TimeoutExpired:
        return {**row, "error": f"over {a.timeout:g} s"}
    except subprocess.CalledProcessError as error:
        return {**row, "error": (error.stderr.strip().splitlines() or ["crashed"])[-1][:300]}
    return json.loads(done.stdout.strip().splitlines()[-1])


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("paths", nargs="*", type=Path)
    parser.add_argument("--engines", default="balanced-thickening,balanced-concavity")
    parser.add_argument("--threshold", type=float, default=0.05, help="CoACD's unit")
    parser.add_argument("--repeats", type=int, default=1)
    parser.add_argument("--timeout", type=float, default=900.0, help="seconds a run may take")
    parser.add_argument("--out", type=Path, default=Path("results.json"))
    parser.add_argument("--fresh", action="store_true", help="measure rows again that are there")
    parser.add_argument("--one", nargs=2, metavar=("ENGINE", "MESH"), help=argparse.SUPPRESS)
    a = parser.parse_args()
    if a.one:
        print(json.dumps(measure(a.one[0], Path(a.one[1]), a.threshold, a.repeats)))
        return
    engines = a.engines.split(",")
    for name in engines:
        if name not in ENGINES:
            parser.error(f"engine '{name}' not found; engines: {', '.join(ENGINES)}")
    paths = list(meshes(a.paths or data_folders()))
    if not paths:
        parser.error("no meshes: name files or folders, or set ASSETPIPE_BENCH_DATA")
    table = json.loads(a.out.read_text()) if a.out.exists() else {"rows": []}
    table["versions"] = versions()

    def key(row):
        return (row["engine"], row["set"], row["mesh"], row["threshold"])

    rows = {key(r): r for r in table["rows"]}
    for path in paths:
        for engine in engines:
            k = (engine, path.parent.name, path.stem, a.threshold)
            if k in rows and not a.fresh:
                continue
            row = isolated(engine, path, a)
            rows[k] = row
            text = row.get("error") or f"{row['hulls']:4d} hulls {row['cpu_s']:8.2f} s"
            print(
                f"{path.parent.name}/{path.stem:20s} {engine:24s} {text}",
                file=sys.stderr,
                flush=True,
            )
            table["rows"] = [rows[x] for x in sorted(rows)]
            a.out.write_text(json.dumps(table, indent=1))


if __name__ == "__main__":
    main()
