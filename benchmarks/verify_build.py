"""Checks a built robot from outside: shares no code with assetpipe.

    python benchmarks/verify_build.py ORIGINAL.urdf BUILT_PACKAGE [--rebuild] [--json]

lxml reads the URDFs, trimesh the original meshes, Qhull judges convexity, libigl measures
distances and winding numbers, PyBullet loads the result in a process of its own. Measures
are taken on samples: a violation disproves a claim, none only fails to. With ``--rebuild``
the robot is built three times more, with other jobs, hash seed and working directory, and again
with a warm cache. Exit code 1 if anything is wrong.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

import numpy as np
from lxml import etree
from verify.again import check_rebuild
from verify.description import check_references, check_urdf
from verify.engine import check_bullet
from verify.mesh import check_mesh
from verify.package import check_files
from verify.shapes import simple_shape
from verify.urdf import collisions, elements_of, origin, parse, resolve, source_of
from verify.verdict import Verdict


def verify(original: Path, out: Path, samples: int) -> Verdict:
    """Everything but the rebuild."""
    verdict = Verdict()
    report = json.loads((out / "report.json").read_text())
    robot = report["robots"][0]
    urdf = out / robot["urdf"]
    old, new = source_of(original), urdf.read_bytes()
    old_root, root = parse(old), parse(new)
    before, after = collisions(old_root), collisions(root)
    by_link: dict[str, list] = {}
    for link, _, element in after:
        by_link.setdefault(link, []).append(element)
    successors, kept = [], set()
    simple: dict[Path, tuple] = {}
    for link, index, element in before:
        told = [e for e in elements_of(robot["links"].get(link, [])) if e["index"] == index]
        if not verdict.expect(
            len(told) == 1, f"link '{link}' collision {index}: not in the report"
        ):
            successors.append(1)
            continue
        files = told[0]["files"]
        count = len(files) or 1
        successors.append(count)
        mine, by_link[link] = by_link.get(link, [])[:count], by_link.get(link, [])[count:]
        if not verdict.expect(len(mine) == count, f"link '{link}' collision {index}: LOST"):
            continue
        if files:
            for child, file in zip(mine, files, strict=True):
                shape = simple_shape(child, element)
                if shape is not None:
                    simple[out / file] = shape
                    continue
                mesh = child.find("geometry/mesh")
                path = None if mesh is None else resolve(mesh.get("filename") or "", urdf, out)
                verdict.expect(
                    path is not None and path.resolve() == (out / file).resolve(),
                    f"link '{link}' collision {index}: refers to {path}, report says {file}",
                )
                verdict.expect(
                    np.allclose(origin(child), origin(element), atol=1e-12, rtol=0),
                    f"link '{link}' collision {index}: other origin",
                )
                verdict.expect(
                    mesh is None
                    or not mesh.get("scale")
                    or set(mesh.get("scale").split()) <= {"1", "1.0"},
                    f"link '{link}' collision {index}: scale left on a baked hull",
                )
        else:
            kept.add(link)
            same = etree.tostring(element, with_tail=False) == etree.tostring(
                mine[0], with_tail=False
            )
            if not same and element.find("geometry/mesh") is not None:
                verdict.notes.append(f"link '{link}' collision {index}: kept, reference rewritten")
            else:
                verdict.expect(same, f"link '{link}' collision {index}: kept but changed")
    extra = {k: len(v) for k, v in by_link.items() if v}
    verdict.expect(not extra, f"collision elements from nowhere: {extra}")
    check_urdf(verdict, old, new, successors)
    check_references(verdict, root, old_root, urdf, original, out)
    hulls_of: dict[int, list[Path]] = {}
    for link in robot["links"].values():
        for element in elements_of(link):
            if element["mesh"] is not None and element["files"]:
                hulls_of.setdefault(element["mesh"], [out / f for f in element["files"]])
    for number, entry in enumerate(robot["meshes"]):
        if number not in hulls_of:
            verdict.notes.append(f"{entry['name']}: {entry['treatment']}")
            continue
        path = resolve(entry["name"], original)
        if not verdict.expect(path is not None, f"{entry['name']}: built, but not found by us"):
            continue
        check_mesh(verdict, entry, path, hulls_of[number], simple, samples)
    check_files(verdict, out, report, original)
    bullet_source = original if original.suffix != ".xacro" else urdf
    check_bullet(verdict, root, urdf, kept, bullet_source)
    verdict.facts["collisions"] = [len(before), len(after)]
    verdict.facts["hulls"] = sum(len(h) for h in hulls_of.values())
    return verdict


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("original", type=Path)
    parser.add_argument("built", type=Path)
    parser.add_argument("--samples", type=int, default=20_000, help="on every mesh")
    parser.add_argument("--rebuild", action="store_true")
    parser.add_argument("--json", action="store_true")
    a = parser.parse_args()
    verdict = verify(a.original.resolve(), a.built.resolve(), a.samples)
    if a.rebuild:
        check_rebuild(verdict, a.original)
    if a.json:
        print(json.dumps(vars(verdict), indent=2, default=str))
    else:
        for mesh in verdict.facts.pop("meshes", []):
            print("  ", json.dumps(mesh))
        print(json.dumps(verdict.facts))
        for note in verdict.notes:
            print("note:", note)
        for violation in verdict.violations:
            print("VIOLATION:", violation)
        print(
            f"{a.original.name}: {'WRONG' if verdict.violations else 'right'}, "
            f"{len(verdict.violations)} violations"
        )
    return 1 if verdict.violations else 0


if __name__ == "__main__":
    sys.exit(main())
