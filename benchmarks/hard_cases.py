"""Every hard solid of the test corpus under every change: the full product, with a table.

    python benchmarks/hard_cases.py [FAMILY...]

``large`` asks for solids of 40,000 and a million faces, as they are. Prints hulls for each solid
and change, and every broken promise; ends with exit code 1 if there is one.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "corpus"))

import guarantees
from changes import CHANGES, plain
from hard_solids import LARGE, SOLIDS, Solid

from assetpipe import decompose


def rows(families: list[str]) -> list[Solid]:
    """What was asked for; the large ones only by name."""
    if not families:
        return list(SOLIDS)
    return [row for row in (*SOLIDS, *LARGE) if row.family in families]


def main() -> int:
    families = sys.argv[1:]
    broken = 0
    clock = time.process_time()
    print("| solid | " + " | ".join(change.__name__ for change in CHANGES) + " |")
    print("|---" * (len(CHANGES) + 1) + "|")
    for row in rows(families):
        cells = []
        for change in CHANGES if row in SOLIDS else (plain,):
            mesh = change(row.mesh)
            try:
                d = decompose(mesh, row.epsilon(mesh), metric=row.metric, threads=1)
                solid = d.repair.solid if d.repair else mesh
                guarantees.check_hulls(solid, d)
                guarantees.check_cover(solid, d)
                guarantees.check_certificate(solid, d)
                guarantees.check_levels(solid, d)
                parts = guarantees.parts_of(solid, d.epsilon, row.metric)
                guarantees.check_parts(solid, d, parts)
                known = row.hulls[0] <= len(d.hulls) <= row.hulls[1]
                cells.append(f"{len(d.hulls)}" if known else f"**{len(d.hulls)}**")
                broken += not known
            except Exception as error:
                broken += 1
                cells.append("**broken**")
                print(f"{row.name}, {change.__name__}: {error!r:.300}", file=sys.stderr)
        print(f"| {row.family}: {row.name} | " + " | ".join(cells) + " |", flush=True)
    print(f"\n{broken} broken; {time.process_time() - clock:.0f} s of processor time")
    return 1 if broken else 0


if __name__ == "__main__":
    raise SystemExit(main())
