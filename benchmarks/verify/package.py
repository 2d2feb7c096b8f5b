"""The files of a package: no times, no folders of the machine, digests that hold."""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path

from verify.urdf import elements_of
from verify.verdict import Verdict

TIME_STAMP = re.compile(r"\b20\d\d-\d\d-\d\d[T ]\d\d:\d\d")


ABSOLUTE = re.compile(r'(?:^|[\s"\'(=])/(?:[\w.\-]+/)+[\w.\-]*')


def check_files(verdict: Verdict, out: Path, report: dict, original: Path) -> None:
    """report.json and assetpipe.json tell what lies there, and nothing of this machine."""
    listed = {
        file
        for robot in report["robots"]
        for link in robot["links"].values()
        for element in elements_of(link)
        for file in element["files"]
    }
    verdict.expect(
        all((out / f).is_file() for f in listed), "report names hull files that are not there"
    )
    there = {p.relative_to(out).as_posix() for p in out.rglob("*_hull_*.obj")}
    stray = sorted(there - listed)
    verdict.expect(not stray, f"hull files that the report does not name: {stray[:3]}")
    inner = {
        file
        for robot in report["robots"]
        for link in robot["links"].values()
        for element in elements_of(link)
        for file in element.get("inner_files", [])
    }
    there = {p.relative_to(out).as_posix() for p in out.rglob("inner_hulls/**/*.obj")}
    verdict.expect(there == inner, f"inner hulls on disk and told: {sorted(there ^ inner)[:3]}")
    provenance = json.loads((out / "assetpipe.json").read_text())
    outputs = provenance["outputs"]
    disk = {
        p.relative_to(out).as_posix()
        for p in out.rglob("*")
        if p.is_file() and p.name != "assetpipe.json"
    }
    verdict.expect(
        disk == set(outputs), f"provenance and disk differ: {sorted(disk ^ set(outputs))[:3]}"
    )
    wrong = [
        name
        for name, digest in outputs.items()
        if (out / name).is_file()
        and hashlib.sha256((out / name).read_bytes()).hexdigest() != digest
    ]
    verdict.expect(not wrong, f"SHA-256 differ: {wrong[:3]}")
    for name in ("assetpipe.json", "report.json"):
        text = (out / name).read_text()
        verdict.expect(not TIME_STAMP.search(text), f"{name} holds a time stamp")
        for place in (str(original.resolve().parent), str(out.resolve()), str(Path.home())):
            if place != "/":
                verdict.expect(place not in text, f"{name} holds '{place}'")
        found = [m.group().strip() for m in ABSOLUTE.finditer(text)]
        verdict.expect(not found, f"{name} holds absolute paths: {found[:3]}")
