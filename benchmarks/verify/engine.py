"""PyBullet loads the result, in a process of its own."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

from verify.urdf import collisions
from verify.verdict import Verdict

LOAD = """
import json, sys, pybullet as p
p.connect(p.DIRECT)
body = p.loadURDF(sys.argv[1], useFixedBase=True)
names = {-1: p.getBodyInfo(body)[0].decode()}
for j in range(p.getNumJoints(body)):
    names[j] = p.getJointInfo(body, j)[12].decode()
print("SHAPES" + json.dumps({n: len(p.getCollisionShapeData(body, k)) for k, n in names.items()}))
"""


def load_in_bullet(urdf: Path, seconds: float = 300) -> dict[str, int] | str:
    """Collision shapes by link, or what went wrong."""
    try:
        done = subprocess.run(
            [sys.executable, "-c", LOAD, str(urdf)],
            capture_output=True,
            timeout=seconds,
            check=False,
            text=True,
            errors="replace",
        )
    except subprocess.TimeoutExpired:
        return "out of time"
    # Bullet may leave its own line unfinished.
    line = next((x for x in done.stdout.splitlines() if "SHAPES{" in x), None)
    if line is None:
        return f"exit {done.returncode}: {(done.stderr or done.stdout).strip()[-200:]}"
    return json.loads(line[line.index("SHAPES{") + 6 :])


def check_bullet(verdict: Verdict, root, urdf: Path, kept: set[str], original: Path) -> None:
    """PyBullet loads it with one shape a collision element."""
    expected: dict[str, int] = {}
    for link, _, _ in collisions(root):
        expected[link] = expected.get(link, 0) + 1
    shapes = load_in_bullet(urdf)
    if isinstance(shapes, str):
        before = load_in_bullet(original)
        if isinstance(before, str):
            verdict.notes.append(f"PyBullet loads neither the original nor the result: {before}")
        else:
            verdict.violations.append(f"PyBullet does not load it: {shapes}")
        return
    for link, count in expected.items():
        got = shapes.get(link, shapes.get(link.rsplit("/")[-1]))
        if got is not None and got != count and link not in kept:
            verdict.violations.append(f"link '{link}': PyBullet has {got} shapes, not {count}")
        if got is None and link in (e.get("name") for e in root.findall("link")):
            verdict.notes.append(f"link '{link}' is told by another name in PyBullet")
