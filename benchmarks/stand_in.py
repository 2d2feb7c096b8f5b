"""How well R_v stands in for H_i on parts of real decompositions (Wei et al. 2022, appendix E).

    python benchmarks/stand_in.py [--out docs/images/stand_in.png] [--json FILE]

Every part is measured three times, with certified intervals: H_b (Eq. 2), H_i (Eq. 3) and R_v
(Eq. 5). Parts are those of decompositions, unmerged, at several thresholds: coarse ones give parts
that are far from convex, fine ones parts that are nearly done. Checked is Theorem 1,

    sqrt(2) max(H_b, R_v) >= max(H_b, H_i),

and what the authors do with it: k = 0.3, their mean of H_i / R_v, with which max(H_b, k R_v)
(Eq. 6) stands in for max(H_b, H_i) (Eq. 4). Lengths are in units of half the longest side of the
mesh. Parts with an Eq. 4 below LEAST in it are left out: a tenth of a usual threshold.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
from cases import data_folders, load

MESHES = (
    "test2 sledge torus helmet eight venus chair block pig screwdriver",
    "kinova_l4 px150_wrist vx300s_uf solo_base koch_l2 xarm_knuckle pr2_faroll",
)
THRESHOLDS = (0.4, 0.2, 0.1, 0.05)
K = 0.3
LEAST = 0.005


def parts(path: Path, threshold: float):
    """Closed parts of a decomposition, as (vertices, faces)."""
    from assetpipe import _core

    vertices, faces, closed = load(path)
    if not closed:
        return []
    epsilon = threshold * 0.5 * float(np.ptp(vertices, axis=0).max())
    found = _core.parts(vertices, faces, epsilon, {"merging": "off", "prisms": "search"}, 1)
    return [part for group in found for part in group]


def measure(paths: list[Path], budget_s: float) -> list[dict]:
    """One row a part, lengths in units of half the longest side of its mesh."""
    from assetpipe import _core

    rows, start = [], time.process_time()
    for threshold in THRESHOLDS:
        for path in paths:
            if time.process_time() - start > budget_s:
                print(f"stopped before {path.stem} at {threshold}: out of time", flush=True)
                return rows
            unit = 0.5 * float(np.ptp(load(path)[0], axis=0).max())
            for vertices, faces in parts(path, threshold):
                boundary, interior, ball = _core.concavity_terms(vertices, faces)
                if max(boundary[0], interior[0]) < LEAST * unit:
                    continue
                rows.append(
                    {
                        "mesh": path.stem,
                        "threshold": threshold,
                        "H_b": [x / unit for x in boundary],
                        "H_i": [x / unit for x in interior],
                        "R_v": [x / unit for x in ball],
                    }
                )
    return rows


def column(rows: list[dict], name: str, end: int) -> np.ndarray:
    return np.array([row[name][end] for row in rows])


def summary(rows: list[dict]) -> dict[str, float]:
    """What the figure shows, as numbers. Theorem 1 is held against the ends of the intervals that
    speak against it."""
    least = {name: column(rows, name, 0) for name in ("H_b", "H_i", "R_v")}
    most = {name: column(rows, name, 1) for name in ("H_b", "H_i", "R_v")}
    theorem = np.maximum(least["H_b"], least["H_i"]) / (
        math.sqrt(2) * np.maximum(most["H_b"], most["R_v"])
    )
    middle = {name: 0.5 * (least[name] + most[name]) for name in least}
    ratio = middle["H_i"] / middle["R_v"]
    exact = np.maximum(middle["H_b"], middle["H_i"])
    stand_in = np.maximum(middle["H_b"], K * middle["R_v"])
    error = np.abs(stand_in - exact)
    inner = middle["H_i"] > middle["H_b"]
    return {
        "parts": len(rows),
        "theorem 1, worst": float(theorem.max()),
        "theorem 1, broken": int((theorem > 1).sum()),
        "H_i / R_v, mean": float(ratio.mean()),
        "H_i / R_v, median": float(np.median(ratio)),
        "H_i / R_v, 5%": float(np.quantile(ratio, 0.05)),
        "H_i / R_v, 95%": float(np.quantile(ratio, 0.95)),
        "H_b decides Eq. 4, share": float((middle["H_b"] >= middle["H_i"]).mean()),
        "Eq. 6 too small by 10%, share of these others": float(
            (stand_in < 0.9 * exact)[inner].mean() if inner.any() else 0.0
        ),
        "Eq. 6, mean absolute error": float(error.mean()),
        "Eq. 6, mean relative error": float((error / exact).mean()),
        "Eq. 6, within 10%, share": float((error <= 0.1 * exact).mean()),
        "Eq. 6 too small by 10%, share": float((stand_in < 0.9 * exact).mean()),
        "Eq. 6 too large by 10%, share": float((stand_in > 1.1 * exact).mean()),
    }


def plot(rows: list[dict], out: Path) -> None:
    """H_i against R_v, Eq. 6 against Eq. 4, and the slack of Theorem 1."""
    import matplotlib

    matplotlib.use("agg")
    from matplotlib import pyplot

    middle = {n: 0.5 * (column(rows, n, 0) + column(rows, n, 1)) for n in ("H_b", "H_i", "R_v")}
    exact = np.maximum(middle["H_b"], middle["H_i"])
    stand_in = np.maximum(middle["H_b"], K * middle["R_v"])
    bound = math.sqrt(2) * np.maximum(middle["H_b"], middle["R_v"])
    ratio = middle["H_i"] / middle["R_v"]
    figure, (left, centre, right) = pyplot.subplots(1, 3, figsize=(13, 4))
    left.hist(ratio.clip(max=2.0), bins=40, color="tab:blue")
    left.axvline(K, color="black", label=f"k = {K}")
    left.axvline(ratio.mean(), color="tab:red", linestyle="--", label=f"mean {ratio.mean():.2f}")
    left.set_xlabel("$H_i / R_v$ (2 and more in the last bar)")
    left.set_ylabel("parts")
    left.legend(fontsize=8)
    for axes, y, name in (
        (centre, stand_in, "$\\max(H_b,\\ 0.3\\ R_v)$, Eq. 6"),
        (right, bound, "$\\sqrt{2}\\ \\max(H_b,\\ R_v)$, Theorem 1"),
    ):
        for threshold in THRESHOLDS:
            some = np.array([row["threshold"] == threshold for row in rows])
            if some.any():
                axes.scatter(exact[some], y[some], s=6, alpha=0.6, label=f"parts at {threshold}")
        ends = [exact.min(), max(exact.max(), y.max())]
        axes.plot(ends, ends, color="black", linewidth=0.8)
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xlabel("$\\max(H_b,\\ H_i)$, Eq. 4")
        axes.set_ylabel(name)
        axes.grid(alpha=0.3)
        axes.legend(fontsize=7)
    figure.tight_layout()
    out.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(out, dpi=90, bbox_inches="tight")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--out", type=Path, default=Path("docs/images/stand_in.png"))
    parser.add_argument("--json", type=Path)
    parser.add_argument("--budget", type=float, default=240.0, help="seconds of processor time")
    a = parser.parse_args()
    folders = data_folders()
    paths = [p for n in " ".join(MESHES).split() for f in folders if (p := f / f"{n}.off").exists()]
    if not paths:
        sys.exit("none of the meshes is there; set ASSETPIPE_BENCH_DATA")
    rows = measure(paths, a.budget)
    print("| | |\n|---|---|")
    for name, value in summary(rows).items():
        print(f"| {name} | {value:.3g} |")
    print(f"\n{time.process_time():.0f} s of processor time in all")
    plot(rows, a.out)
    if a.json:
        a.json.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
