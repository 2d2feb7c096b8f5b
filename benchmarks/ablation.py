"""What each choice of the engine is worth: one thing changed at a time, on a stated few meshes.

    python benchmarks/ablation.py [--out docs/images/ablation.svg] [--json FILE]

The meshes are those below (small and middling ones of both sets, chosen for their time, not for
their results). Hulls are the geometric mean of the ratio to the unchanged engine, time the ratio
of the sums of processor time on one thread. A ratio within 2% of 1 is noise.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from cases import data_folders, load

MESHES = {
    "vhacd": ("test2", "sledge", "torus", "helmet", "eight", "venus", "chair"),
    "cad": ("kinova_l4", "px150_wrist", "vx300s_uf", "solo_base", "koch_l2", "xarm_knuckle"),
}
THRESHOLD = 0.05


@dataclass(frozen=True)
class Change:
    """One row: what is different from ``balanced``."""

    group: str
    name: str
    search: dict[str, str | float] = field(default_factory=dict)
    threshold: float = THRESHOLD


CHANGES = (
    Change("policy", "greedy", {"policy": "greedy"}),
    Change("policy", "two ways (best)", {"ways": "2,2,2,2"}),
    Change("policy", "MCTS t=40 d=3", {"policy": "mcts", "iterations": 40}),
    Change("policy", "MCTS t=150 d=2", {"policy": "mcts", "depth": 2}),
    Change("policy", "MCTS t=150 d=3", {"policy": "mcts"}),
    Change("planes m", "5", {"planes": 5}),
    Change("planes m", "10", {"planes": 10}),
    Change("planes m", "40", {"planes": 40}),
    Change("expanded", "6", {"expand": 6}),
    Change("expanded", "30", {"expand": 30}),
    Change("cost", "worst part (Eq. 7)", {"norm": "worst"}),
    Change("cost", "R_v only (Eq. 5)", {"norm": "worst", "excess": 1, "samples": 1}),
    Change("candidates", "no sectors", {"sectors": "ignored"}),
    Change("candidates", "no flat faces", {"faces": 0, "second_faces": 0}),
    Change("frame", "mesh axes", {"frame": "mesh"}),
    Change("frame", "principal axes", {"frame": "principal"}),
    Change("steps", "no refinement", {"refine": 0}),
    Change("steps", "no merging", {"merging": "off"}),
    Change("steps", "no proxies", {"ladder": ""}),
    Change("steps", "any idle slicing", {"patience": 0}),
    Change("tolerance", "0.02", threshold=0.02),
    Change("tolerance", "0.1", threshold=0.1),
)


def measure(paths: list[Path], change: Change) -> tuple[list[int], float]:
    """Hulls a mesh and processor seconds in all."""
    import assetpipe
    from assetpipe.decomposition import Params

    hulls, start = [], time.process_time()
    for path in paths:
        vertices, faces, _ = load(path)
        found = assetpipe.decompose(
            (vertices, faces),
            assetpipe.Tolerance.coacd(change.threshold),
            threads=1,
            params=Params(change.search),
        )
        hulls.append(len(found.hulls))
    return hulls, time.process_time() - start


def plot(rows: list[dict], out: Path) -> None:
    """Hulls against time, a point a row."""
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "ablation"
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(8, 5))
    shown = [row for row in rows if row["group"] != "tolerance"]
    for group in dict.fromkeys(row["group"] for row in shown):
        some = [row for row in shown if row["group"] == group]
        axes.scatter([r["time"] for r in some], [r["hulls"] for r in some], s=18, label=group)
    for row in shown:
        if abs(math.log(row["hulls"])) > 0.02 or not 0.8 < row["time"] < 1.25:
            place = (row["time"], row["hulls"])
            axes.annotate(row["name"], place, fontsize=7, xytext=(4, 3), textcoords="offset points")
    axes.scatter([1], [1], marker="*", color="black", s=70, label="balanced")
    axes.set_xscale("log")
    axes.set_xlabel("processor time against balanced")
    axes.set_ylabel("hulls against balanced")
    axes.legend(fontsize=7)
    axes.grid(alpha=0.3)
    out.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(out, bbox_inches="tight", metadata={"Date": None})


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--out", type=Path, default=Path("docs/images/ablation.svg"))
    parser.add_argument("--json", type=Path)
    a = parser.parse_args()
    paths = [
        path
        for folder in data_folders()
        for name in MESHES.get(folder.name, ())
        if (path := folder / f"{name}.off").exists()
    ]
    if not paths:
        sys.exit("none of the meshes is there; set ASSETPIPE_BENCH_DATA")
    measure(paths[:1], Change("", "warm up"))
    base, base_s = measure(paths, Change("", "balanced"))
    print(
        f"balanced: {sum(base)} hulls on {len(paths)} meshes in {base_s:.2f} s of processor time\n"
    )
    print("| changed | to | hulls | time |\n|---|---|---|---|")
    rows = []
    for change in CHANGES:
        hulls, seconds = measure(paths, change)
        logs = [math.log(h / b) for h, b in zip(hulls, base, strict=True)]
        row = {
            "group": change.group,
            "name": change.name,
            "hulls": math.exp(sum(logs) / len(logs)),
            "time": seconds / base_s,
        }
        rows.append(row)
        print(
            f"| {change.group} | {change.name} | {row['hulls']:.3f} | {row['time']:.2f} |",
            flush=True,
        )
    print(f"\n{time.process_time():.0f} s of processor time in all")
    plot(rows, a.out)
    if a.json:
        a.json.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
