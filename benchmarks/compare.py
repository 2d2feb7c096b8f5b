"""Prints tables from the rows of ``run.py``: one engine against another, mesh by mesh.

python benchmarks/compare.py results.json balanced-thickening --against coacd
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np


def geometric(values) -> float:
    return float(np.exp(np.mean(np.log(values)))) if len(values) else float("nan")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("results", type=Path)
    parser.add_argument("engine")
    parser.add_argument("--against", default="coacd")
    parser.add_argument("--threshold", type=float, default=0.05)
    a = parser.parse_args()
    rows = [
        r
        for r in json.loads(a.results.read_text())["rows"]
        if r["threshold"] == a.threshold and "error" not in r
    ]
    pick = {
        e: {(r["set"], r["mesh"]): r for r in rows if r["engine"] == e}
        for e in (a.engine, a.against)
    }
    both = sorted(set(pick[a.engine]) & set(pick[a.against]))
    for name in sorted({s for s, _ in both}):
        print(f"\n### {name}: {a.engine} / {a.against}, threshold {a.threshold}\n")
        print("| mesh | faces | hulls | vertices | CPU s | speed | outside / tolerance |")
        print("|---|---|---|---|---|---|---|")
        ratios = []
        for k in (k for k in both if k[0] == name):
            x, y = pick[a.engine][k], pick[a.against][k]
            speed = y["cpu_s"] / max(x["cpu_s"], 1e-9)
            over = [
                r["score"]["volume_outside"] / r["tolerance"] if r.get("score") else float("nan")
                for r in (x, y)
            ]
            if x["closed"]:
                ratios.append(
                    (x["hulls"] / y["hulls"], x["vertices"] / y["vertices"], speed, *over)
                )
            print(
                f"| {k[1]}{'' if x['closed'] else ' (open)'} | {x['faces']} | "
                f"{x['hulls']} / {y['hulls']} | "
                f"{x['vertices']} / {y['vertices']} | {x['cpu_s']:.2f} / {y['cpu_s']:.2f} | "
                f"{speed:.0f}× | {over[0]:.3f} / {over[1]:.3f} |"
            )
        if ratios:
            r = np.array(ratios)
            print(
                f"\nClosed meshes ({len(r)}): hulls {geometric(r[:, 0]):.3f}, hull vertices "
                f"{geometric(r[:, 1]):.3f}, speed {geometric(r[:, 2]):.1f}× "
                f"(worst {r[:, 2].min():.1f}×), beyond the tolerance "
                f"{int((r[:, 3] > 1 + 1e-9).sum())} / {int((r[:, 4] > 1 + 1e-9).sum())}."
            )


if __name__ == "__main__":
    main()
