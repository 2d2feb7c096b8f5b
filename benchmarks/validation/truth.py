"""Contact truth and self-collision of built robots, with sample sizes and intervals.

    python benchmarks/validation/truth.py [ROBOT…] [--samples 1000] [--poses 1000]

Builds every robot with the default configuration (into ``--built``) and prints what its
``report.json`` says: false and missed contacts among poses near contact with Wilson's 95%
interval, the clearance error over the certificate, and pairs of links that touch only before
or only after over seeded joint configurations within limits (mimic joints follow).
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import Any

from variants import robot_files

import assetpipe

CACHE = Path.home() / ".cache" / "assetpipe-benchmarks"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    files = robot_files()
    parser.add_argument("robots", nargs="*", metavar="ROBOT", help=", ".join(files))
    parser.add_argument("--samples", type=int, default=1000, help="poses a mesh")
    parser.add_argument("--poses", type=int, default=1000, help="joint configurations")
    parser.add_argument("--built", type=Path, default=CACHE / "built")
    a = parser.parse_args()
    config = assetpipe.Config(validation={"samples": a.samples, "poses": a.poses})
    print("| robot | meshes | poses | false contacts | missed | undecided | beyond certificate |"
          " error p50 / p95 / worst, of the certificate | configurations × pairs | new | vanished |"
          " s |\n|---|---|---|---|---|---|---|---|---|---|---|---|")  # fmt: skip
    every: list[dict[str, Any]] = []
    for name in a.robots or files:
        began = time.perf_counter()
        assetpipe.build(files[name], a.built / name, config=config)
        seconds = time.perf_counter() - began
        (robot,) = json.loads((a.built / name / "report.json").read_text())["robots"]
        told = [m["contact"] for m in robot["meshes"] if "contact" in m]
        every += told
        own = robot["validation"].get("self_collision")
        again = (
            f"{own['configurations']} × {own['pairs']} | {changes(own['new'])} | "
            f"{changes(own['vanished'])}"
            if own
            else "- | - | -"
        )
        print(f"| {name} | {len(told)} | {contact(told)} | {again} | {seconds:.0f} |", flush=True)
    print(f"| all | {len(every)} | {contact(every)} | | | | |")


def contact(told: list[dict[str, Any]]) -> str:
    """Rates over all meshes of a robot; errors in units of each mesh's certificate."""
    from assetpipe.validation.statistics import Rate

    def rate(key: str) -> str:
        count, of = (sum(t[key][k] for t in told) for k in ("count", "of"))
        found = Rate.wilson(count, of)
        return f"{found.value * 100:.2g}% [{found.low * 100:.2g}, {found.high * 100:.2g}]"

    def error(key: str) -> str:
        shares = [t["clearance_error"][key] / t["allowed"] for t in told if t["allowed"] > 0.0]
        return f"{max(shares, default=0.0):.2f}"

    beyond = sum(t["beyond_certificate"]["count"] for t in told)
    samples = sum(t["samples"] for t in told)
    errors = " / ".join(error(key) for key in ("p50", "p95", "worst"))
    return (
        f"{samples} | {rate('false_contacts')} | {rate('missed_contacts')} | "
        f"{rate('undecided')} | {beyond} | {errors}"
    )


def changes(pairs: list[dict[str, Any]]) -> str:
    """How many pairs changed, in how many configurations at most, and the largest gap."""
    if not pairs:
        return "0"
    gap = max(p["gap"] for p in pairs)
    most = max(p["configurations"] for p in pairs)
    return f"{len(pairs)} (in up to {most}; gap {gap * 1e3:.2g} mm)"


if __name__ == "__main__":
    main()
