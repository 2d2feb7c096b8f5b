"""What each choice of the engine is worth: one thing changed at a time (Wei et al. 2022, §7.2).

    python benchmarks/ablation.py [folder ...] [--only GROUP,...] [--budget SECONDS]
                                  [--out docs/images] [--json FILE]
    python benchmarks/ablation.py --redraw FILE [--out docs/images]

The meshes are those below (small and middling ones, chosen for their time, not for their
results), from the benchmark data and further folders such as the one that ``aside.py`` writes.
Hulls are the geometric mean of the ratio to the unchanged engine, time the ratio of the sums of
processor time on one thread. Two images are drawn: ``ablation.svg``, hulls against time, and
``ablation_parameters.svg``, the curves of the paper's Figures 13 and 20.
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
    "vhacd": "test2 sledge torus helmet venus chair block cow1 pig helix table tube1",
    "cad": "kinova_l4 px150_wrist vx300s_uf solo_base koch_l2 xarm_knuckle tiago_base pr2_faroll",
    "pybullet_data": "GUIDE_WSG50_110 calf channel_4inch diff_arm diff_motor_cover diff_stand "
    "fr12_h101 handlebar_scaled lower_leg3",
}
THRESHOLD = 0.05


@dataclass(frozen=True)
class Change:
    """One row: what is different from ``balanced``."""

    group: str
    name: str
    search: dict[str, str | float] = field(default_factory=dict)
    threshold: float = THRESHOLD


def mcts(name: str, group: str = "MCTS", **search: str | float) -> Change:
    """Tree search, one way, with the paper's d and c unless said otherwise."""
    return Change(group, name, {"policy": "mcts", "ways": "", **search})


def changes() -> list[Change]:
    """All rows, the most telling first."""
    rows = [
        Change("policy", "two ways", {"ways": "2,2"}),
        Change("policy", "three ways", {"ways": "3,3,3"}),
        Change("policy", "two steps", {"policy": "lookahead"}),
        Change("policy", "two steps, two ways", {"policy": "lookahead", "ways": "2,2"}),
        Change("cost", "worst part (Eq. 7)", {"norm": "worst"}),
        Change("cost", "R_v only (Eq. 5)", {"norm": "worst", "excess": 1, "samples": 1}),
        Change("candidates", "no sectors", {"sectors": "ignored"}),
        Change("candidates", "no flat faces", {"faces": 0, "second_faces": 0}),
        Change("candidates", "no oblique planes", {"oblique": 0}),
        Change("candidates", "prisms by search", {"prisms": "search"}),
        Change("frame", "mesh axes", {"frame": "mesh"}),
        Change("frame", "principal axes", {"frame": "principal"}),
        Change("steps", "no refinement", {"refine": 0}),
        Change("steps", "no merging", {"merging": "off"}),
        Change("steps", "no proxies", {"ladder": ""}),
        Change("steps", "any idle slicing", {"patience": 0}),
    ]
    for m in (5, 10, 40, 80):
        rows.append(Change("planes m", f"{m}", {"planes": m}))
        rows.append(Change("planes m", f"{m}, no refinement", {"planes": m, "refine": 0}))
    for threshold in (0.02, 0.1, 0.2):
        rows.append(Change("tolerance", f"{threshold}", threshold=threshold))
        off = {"merging": "off"}
        rows.append(Change("tolerance", f"{threshold}, no merging", off, threshold=threshold))
    rows += [mcts(f"t=150 d={d}", iterations=150, depth=d) for d in (1, 2, 3, 4)]
    rows += [mcts(f"t={t} d=3", iterations=t) for t in (10, 40)]
    for c in (0, 0.25, 4, 16):
        rows.append(mcts(f"t=150 d=3 c={c}", iterations=150, exploration=c))
    return rows


def measure(paths: list[Path], change: Change) -> list[tuple[int, float] | None]:
    """Hulls and processor seconds of each mesh; ``None`` where the engine failed, which is told."""
    import assetpipe
    from assetpipe.decomposition import Params

    found: list[tuple[int, float] | None] = []
    for path in paths:
        vertices, faces, _ = load(path)
        start = time.process_time()
        try:
            hulls = assetpipe.decompose(
                (vertices, faces),
                assetpipe.Tolerance.coacd(change.threshold),
                threads=1,
                params=Params(change.search),
            ).hulls
        except assetpipe.errors.EngineError as error:
            print(f"{change.group}, {change.name}: {path.stem} left out: {error}", flush=True)
            found.append(None)
            continue
        found.append((len(hulls), time.process_time() - start))
    return found


def row(change: Change, found: list, base: list) -> dict:
    """Ratios to the unchanged engine."""
    pairs = [(f, b) for f, b in zip(found, base, strict=True) if f and b]
    logs = [math.log(f[0] / b[0]) for f, b in pairs]
    return {
        "group": change.group,
        "name": change.name,
        "hulls": math.exp(sum(logs) / len(logs)),
        "time": sum(f[1] for f, _ in pairs) / sum(b[1] for _, b in pairs),
    }


def draw(rows: list[dict], out: Path) -> None:
    """Both images."""
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "ablation"
    from matplotlib import pyplot

    out.mkdir(parents=True, exist_ok=True)
    figure, axes = pyplot.subplots(figsize=(8, 5))
    shown = [
        row
        for row in rows
        if row["group"] != "tolerance" and (row["group"] != "planes m" or "," not in row["name"])
    ]
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
    figure.savefig(out / "ablation.svg", bbox_inches="tight", metadata={"Date": None})

    found = {(row["group"], row["name"]): row["hulls"] for row in rows}
    figure, panels = pyplot.subplots(1, 5, figsize=(15, 3.2))
    curves = (
        ("tolerance ε", "tolerance", "{}", (0.02, 0.05, 0.1, 0.2), ", no merging"),
        ("planes an axis m", "planes m", "{}", (5, 10, 20, 40, 80), ", no refinement"),
        ("depth d, t = 150", "MCTS", "t=150 d={}", (1, 2, 3, 4), None),
        ("iterations t, d = 3", "MCTS", "t={} d=3", (10, 40, 150), None),
        ("c in concavity/d", "MCTS", "t=150 d=3 c={}", (0, 0.25, 1, 4, 16), None),
    )
    found["tolerance", "0.05"] = found["planes m", "20"] = 1.0
    for key, same in (
        (("tolerance", "0.05, no merging"), ("steps", "no merging")),
        (("planes m", "20, no refinement"), ("steps", "no refinement")),
        (("MCTS", "t=150 d=3 c=1"), ("MCTS", "t=150 d=3")),
    ):
        if same in found:
            found[key] = found[same]
    for axes, (label, group, name, values, without) in zip(panels, curves, strict=True):
        for suffix in ("",) if without is None else ("", without):
            known = [v for v in values if (group, name.format(v) + suffix) in found]
            ys = [found[group, name.format(v) + suffix] for v in known]
            axes.plot(range(len(known)), ys, marker="o", label=suffix.strip(", ") or "balanced")
            axes.set_xticks(range(len(known)), [str(v) for v in known])
        axes.set_xlabel(label)
        axes.grid(alpha=0.3)
        if without is not None:
            axes.legend(fontsize=7)
    panels[0].set_ylabel("hulls against balanced")
    figure.tight_layout()
    figure.savefig(out / "ablation_parameters.svg", bbox_inches="tight", metadata={"Date": None})


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("folders", type=Path, nargs="*", help="further folders of meshes")
    parser.add_argument("--only", default="", help="groups of rows, comma-separated")
    parser.add_argument("--budget", type=float, default=1500.0, help="seconds of processor time")
    parser.add_argument("--out", type=Path, default=Path("docs/images"))
    parser.add_argument("--json", type=Path, help="write the rows to it")
    parser.add_argument("--redraw", type=Path, help="rows written before: only draw them")
    a = parser.parse_args()
    if a.redraw:
        draw(json.loads(a.redraw.read_text()), a.out)
        return
    paths = [
        path
        for folder in [*data_folders(), *a.folders]
        for name in MESHES.get(folder.name, "").split()
        if (path := folder / f"{name}.off").exists()
    ]
    if not paths:
        sys.exit("none of the meshes is there; set ASSETPIPE_BENCH_DATA")
    groups = {group for group in a.only.split(",") if group}
    measure(paths[:1], Change("", "warm up"))
    base = measure(paths, Change("", "balanced"))
    counts, seconds = zip(*filter(None, base), strict=True)
    print(
        f"balanced: {sum(counts)} hulls on {len(counts)} meshes in {sum(seconds):.2f} s of "
        "processor time\n"
    )
    print("| changed | to | hulls | time |\n|---|---|---|---|")
    rows: list[dict] = []
    for change in changes():
        if groups and change.group not in groups:
            continue
        if time.process_time() > a.budget:
            print(f"out of time before {change.group}: {change.name}")
            break
        found = row(change, measure(paths, change), base)
        rows.append(found)
        print(
            f"| {change.group} | {change.name} | {found['hulls']:.3f} | {found['time']:.2f} |",
            flush=True,
        )
        if a.json:
            a.json.write_text(json.dumps(rows, indent=1) + "\n")
    print(f"\n{time.process_time():.0f} s of processor time in all")
    draw(rows, a.out)


if __name__ == "__main__":
    main()
