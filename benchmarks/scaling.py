"""How time grows with the number of faces and with 1/tolerance.

    python benchmarks/scaling.py [--faces 1000,10000,100000,300000,1000000]
        [--thresholds 0.2,0.1,0.05,0.02,0.01] [--only faces|tolerance] [--json F] [MESH ...]

The same shape in every number of faces: fewer by edge collapse (libigl), more by
splitting every face evenly, which leaves the surface where it is. Medians of process
time on one thread; exponents by least squares on logarithms.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
from cases import ENGINES, data_folders, load, versions

SHAPES = ("vhacd/cow1", "vhacd/casting", "cad/kinova_l4")
LARGE = 100_000


def resized(vertices: np.ndarray, faces: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The shape with about ``count`` faces, closed."""
    if count < len(faces):
        import igl

        collapsed = igl.decimate(np.asfortranarray(vertices), faces.astype(np.int32), count)
        return np.ascontiguousarray(collapsed[0]), np.ascontiguousarray(collapsed[1], dtype=int)
    parts = max(1, round(math.sqrt(count / len(faces))))
    if parts == 1:
        return vertices, faces
    from manifold3d import Manifold, Mesh64

    whole = Manifold(Mesh64(vertices.copy(), faces.astype(np.uint64)))
    mesh = whole.refine(parts).to_mesh64()
    return (
        np.ascontiguousarray(mesh.vert_properties[:, :3], dtype=np.float64),
        np.ascontiguousarray(mesh.tri_verts, dtype=np.int64),
    )


def seconds(
    engine: str, vertices: np.ndarray, faces: np.ndarray, threshold: float, repeats: int
) -> tuple[float, int]:
    """Median process time and number of hulls."""
    runs = [ENGINES[engine](vertices, faces, threshold) for _ in range(repeats)]
    return statistics.median(run.cpu_s for run in runs), len(runs[0].hulls)


def exponent(points: list[tuple[float, float]]) -> float | None:
    """Slope of log(y) over log(x)."""
    if len({x for x, _ in points}) < 2:
        return None
    x, y = np.log(np.asarray(points)).T
    return float(np.polyfit(x, y, 1)[0])


def table(title: str, unit: str, rows: list[dict], slopes: dict[str, float | None]) -> None:
    """One Markdown table."""
    print(f"\n{title}\n\n| mesh | {unit} | s | hulls |\n|---|---|---|---|")
    for row in rows:
        print(f"| {row['mesh']} | {row['x']:,g} | {row['cpu_s']:.3f} | {row['hulls']} |")
    for name, slope in slopes.items():
        print(f"- {name}: " + ("one point only" if slope is None else f"{slope:.2f}"))


def by_faces(paths: list[Path], counts: list[int], a: argparse.Namespace) -> dict:
    """Time over faces; the exponent over all and from 100,000 on."""
    rows, slopes = [], {}
    for path in paths:
        vertices, faces, closed = load(path)
        if not closed:
            print(f"{path.stem}: not closed, left out", file=sys.stderr)
            continue
        own = []
        for count in counts:
            mesh = resized(vertices, faces, count)
            if own and len(mesh[1]) == own[-1]["x"]:
                continue
            cpu, hulls = seconds(a.engine, *mesh, a.threshold, a.repeats)
            own.append({"mesh": path.stem, "x": len(mesh[1]), "cpu_s": cpu, "hulls": hulls})
            print(own[-1], file=sys.stderr, flush=True)
        rows += own
        large = [(r["x"], r["cpu_s"]) for r in own if r["x"] >= 0.8 * LARGE]
        slopes[f"{path.stem}, exponent over all"] = exponent([(r["x"], r["cpu_s"]) for r in own])
        slopes[f"{path.stem}, exponent from {LARGE:,} faces on"] = exponent(large)
    table(f"Faces ({a.engine}, threshold {a.threshold:g})", "faces", rows, slopes)
    return {"rows": rows, "exponents": slopes}


def by_tolerance(paths: list[Path], thresholds: list[float], a: argparse.Namespace) -> dict:
    """Time over 1/threshold."""
    rows, slopes = [], {}
    for path in paths:
        vertices, faces, _ = load(path)
        own = []
        for threshold in thresholds:
            cpu, hulls = seconds(a.engine, vertices, faces, threshold, a.repeats)
            own.append({"mesh": path.stem, "x": 1 / threshold, "cpu_s": cpu, "hulls": hulls})
            print(own[-1], file=sys.stderr, flush=True)
        rows += own
        slopes[f"{path.stem}, exponent of time"] = exponent([(r["x"], r["cpu_s"]) for r in own])
        slopes[f"{path.stem}, exponent of hulls"] = exponent([(r["x"], r["hulls"]) for r in own])
    table(f"Tolerance ({a.engine})", "1/threshold", rows, slopes)
    return {"rows": rows, "exponents": slopes}


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("meshes", nargs="*", type=Path)
    parser.add_argument("--engine", default="balanced-thickening", choices=sorted(ENGINES))
    parser.add_argument("--faces", default="1000,10000,100000,300000,1000000")
    parser.add_argument("--thresholds", default="0.2,0.1,0.05,0.02,0.01")
    parser.add_argument("--threshold", type=float, default=0.05, help="of the runs over faces")
    parser.add_argument("--only", choices=("faces", "tolerance"))
    parser.add_argument("--repeats", type=int, default=1)
    parser.add_argument("--json", type=Path)
    a = parser.parse_args()
    paths = a.meshes or [
        found[0]
        for name in SHAPES
        if (found := [p for d in data_folders() for p in d.parent.glob(f"{name}.*")])
    ]
    if not paths:
        raise SystemExit("no meshes: name some, or set ASSETPIPE_BENCH_DATA")
    result: dict = {"versions": versions()}
    if a.only != "tolerance":
        result["faces"] = by_faces(paths, [int(n) for n in a.faces.split(",")], a)
    if a.only != "faces":
        result["tolerance"] = by_tolerance(paths, [float(t) for t in a.thresholds.split(",")], a)
    if a.json:
        a.json.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
