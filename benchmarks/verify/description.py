"""The URDF: nothing but its collisions may change, and what it refers to must be there."""

from __future__ import annotations

import re
from pathlib import Path

from verify.urdf import cut_at_collisions, resolve
from verify.verdict import Verdict


def check_urdf(verdict: Verdict, original: bytes, built: bytes, successors: list[int]) -> None:
    """Bytes outside the collision elements are those of the original."""
    before, old = cut_at_collisions(original)
    after, new = cut_at_collisions(built)
    if not verdict.expect(
        sum(successors) == len(new) and len(successors) == len(old),
        f"report names {sum(successors)} collision elements for {len(successors)} old ones, "
        f"the URDFs have {len(new)} for {len(old)}",
    ):
        return
    place, kept = 0, [after[0]]
    for count in successors:
        for k in range(place + 1, place + count):
            verdict.expect(
                not after[k].strip(), f"text between successors: {after[k].strip()[:60]!r}"
            )
        place += count
        kept.append(after[place])
    differing = [k for k, (a, b) in enumerate(zip(before, kept, strict=True)) if a != b]
    verdict.expect(
        not differing,
        f"bytes outside of collision elements differ in {len(differing)} places, e.g. "
        f"{before[differing[0]][-80:]!r} -> {kept[differing[0]][-80:]!r}"
        if differing
        else "",
    )


def check_references(verdict: Verdict, root, old_root, urdf: Path, old_urdf: Path, out: Path):
    """Everything that is referred to is there and inside, if the original had it."""
    missing_before = {
        e.get("filename")
        for e in old_root.iter("mesh", "texture")
        if e.get("filename") and resolve(e.get("filename"), old_urdf) is None
    }
    for element in root.iter("mesh", "texture"):
        uri = element.get("filename")
        if not uri:
            continue
        path = resolve(uri, urdf, out)
        if path is None:
            if uri in missing_before:
                verdict.notes.append(f"'{uri}' was missing before, too")
            else:
                verdict.violations.append(f"'{uri}' does not resolve inside the package")
        elif out.resolve() not in path.resolve().parents:
            verdict.violations.append(f"'{uri}' leaves the package")
        elif path.suffix.lower() == ".obj" and path.stat().st_size < 50_000_000:
            for side in re.findall(rb"^mtllib\s+(.+?)\s*$", path.read_bytes(), re.MULTILINE):
                old = resolve(uri, old_urdf)
                name = side.decode(errors="replace")
                if old is not None and (old.parent / name).is_file():
                    verdict.expect(
                        (path.parent / name).is_file(), f"'{uri}' lost its material '{name}'"
                    )
