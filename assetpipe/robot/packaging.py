"""Where everything goes so that OUT is complete: a plan, nothing is written here.

The URDF's text outside of its collision elements does not change, so every reference in it
has to lead somewhere from where the new file lies, for ROS tools, for PyBullet (which looks for
``name/rest`` and for relative paths in all folders above the URDF) and for yourdfpy. Hence:

* A description without ``package://`` references: OUT is its package (or, without a
  ``package.xml``, as many folders around the URDF as its relative references climb). The URDF
  keeps its place in the package: ``OUT/urdf/robot.urdf``.
* With ``package://name/rest``: OUT holds packages, ``OUT/name/rest``, with their
  ``package.xml`` where there is one; the URDF keeps its place in its own:
  ``OUT/name/urdf/robot.urdf``. A folder is called what the references call the package, so that
  one whose folder had another name resolves everywhere now.
* ``file://`` and absolute references keep pointing where they do; nothing is copied for them.

Hulls lie beside the meshes that they stand for, in ``collision_hulls`` in the nearest folder
called ``meshes``, and are referred to in the same style: ``package://`` stays ``package://``,
relative stays relative. Only for ``file://`` and absolute references they are relative to the
URDF instead, so that the result can be moved.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Literal

from assetpipe.errors import Location
from assetpipe.findings import Finding, Severity
from assetpipe.robot.companions import companions, is_drawn
from assetpipe.robot.model import Reference, Robot
from assetpipe.robot.resolution import shortened

HULLS = "collision_hulls"
"""Name of the folders that hold hulls."""
INNER = "inner_hulls"
"""Name of the folders that hold inner hulls."""

_UNSAFE = re.compile(r"[^A-Za-z0-9._-]+")
_LONGEST = 60
_Role = Literal["collision", "visual"]


@dataclass(frozen=True)
class Copy:
    """A file to copy: ``to`` is relative to OUT."""

    source: Path
    to: PurePosixPath


@dataclass(frozen=True)
class HullPlace:
    """Where the hulls of one collision or visual element go.

    Attributes:
        folder: relative to OUT.
        prefix: what references to files in that folder begin with, ``/`` at its end.
        stem: what the files' names begin with.
        inner: folder of the inner hulls, relative to OUT; nothing refers to them.
    """

    folder: PurePosixPath
    prefix: str
    stem: str
    inner: PurePosixPath

    def name(self, number: int) -> str:
        """File name of a hull: ``<link>_<index>_hull_000.obj``."""
        return f"{self.stem}_hull_{number:03d}.obj"

    def path(self, number: int) -> PurePosixPath:
        """The hull's file relative to OUT."""
        return self.folder / self.name(number)

    def inner_path(self, number: int) -> PurePosixPath:
        """File of an inner hull relative to OUT: ``<link>_<index>_inner_000.obj``."""
        return self.inner / f"{self.stem}_inner_{number:03d}.obj"

    def uri(self, number: int) -> str:
        """The reference to the hull for the URDF."""
        return self.prefix + self.name(number)


@dataclass(frozen=True)
class Layout:
    """What OUT holds for one robot besides the hulls themselves.

    Attributes:
        urdf: the URDF's place, relative to OUT.
        copies: files to copy, each place once, sorted by place.
        hulls: where hulls go, by role, link and index of every element that names a mesh.
        findings: places that two different files claim.
    """

    urdf: PurePosixPath
    copies: tuple[Copy, ...]
    hulls: dict[tuple[_Role, str, int], HullPlace]
    findings: tuple[Finding, ...]


def lay_out(robot: Robot, *, replaced: Collection[tuple[str, int]] = (), shelf: str = "") -> Layout:
    """Plan OUT for a robot.

    Args:
        robot: as read.
        replaced: link and index of the collision elements that get hulls; their meshes are
            copied only if something else needs them.
        shelf: a folder's name between ``collision_hulls`` and the hulls, to keep robots that
            share a package in one OUT apart.
    """
    plan = _Plan(robot)
    kept = [
        reference
        for reference in robot.references
        if not (reference.role == "collision" and (reference.link, reference.index) in replaced)
    ]
    copies, findings = plan.copies(kept)
    # what was built before may be built again: its hulls keep their folders
    taken = {str(copy.to.parent).casefold() for copy in copies}
    hulls: dict[tuple[_Role, str, int], HullPlace] = {}
    for reference in robot.references:
        if reference.role in ("collision", "visual") and reference.resolution.state == "found":
            role: _Role = "collision" if reference.role == "collision" else "visual"
            place = _unclaimed(plan, reference, shelf, taken)
            hulls[role, reference.link or "", reference.index or 0] = place
    return Layout(plan.folder / robot.urdf_name, copies, hulls, findings)


def safe_name(name: str) -> str:
    """A name that every file system takes: ASCII letters, digits, ``. _ -``, not too long.

    What had to be changed is told apart by a digest of the original.
    """
    safe = _UNSAFE.sub("_", name).strip("._-")[:_LONGEST].rstrip("._-")
    if safe and safe == name:
        return safe
    digest = hashlib.sha256(name.encode("utf-8", "surrogatepass")).hexdigest()[:6]
    return f"{safe}_{digest}" if safe else digest


def _unclaimed(plan: _Plan, reference: Reference, shelf: str, taken: set[str]) -> HullPlace:
    """A folder ``<link>_<index>`` that nothing else has, whatever the case of letters."""
    kind = "visual_" if reference.role == "visual" else ""
    stem = f"{safe_name(reference.link or '')}_{kind}{reference.index}"
    place = plan.hull_place(reference, stem, shelf)
    number = 1
    while not taken.isdisjoint(_folded(place)):
        number += 1
        place = plan.hull_place(reference, f"{stem}_{number}", shelf)
    taken.update(_folded(place))
    return place


def _folded(place: HullPlace) -> set[str]:
    return {str(folder).casefold() for folder in (place.folder, place.inner)}


class _Plan:
    """The URDF's folder in OUT, and from it the place of every reference."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._source = Path(os.path.abspath(robot.path)).parent
        found = [r.resolution for r in robot.references if r.resolution.state == "found"]
        self._roots: dict[str, list[Path]] = {}
        for resolution in found:
            if resolution.package is not None and resolution.root is not None:
                roots = self._roots.setdefault(resolution.package, [])
                if resolution.root not in roots:
                    roots.append(resolution.root)
        inner, self._top = self._place()
        climbs = [_climb(r.rest) for r in found if r.package is None and r.means != "file"]
        # further folders around where relative references climb above OUT
        missing = max([0, *(climb - len(inner.parts) for climb in climbs)])
        outer = list(self._top.parts[1:])[-missing:] if missing else []
        outer = ["_"] * (missing - len(outer)) + outer
        self._workspace = PurePosixPath(*outer)
        self.folder = self._workspace / inner

    def _place(self) -> tuple[PurePosixPath, Path]:
        """The URDF's folder below OUT, and the folder on disk that OUT stands for."""
        package = self._robot.package
        around = [
            (root, name)
            for name, roots in self._roots.items()
            for root in roots
            if self._source.is_relative_to(root)
        ]
        if package is not None and package.name in self._roots:
            around = [(package.root, package.name)]
        if around:
            root, name = max(around, key=lambda pair: len(pair[0].parts))
            return PurePosixPath(name, *self._source.relative_to(root).parts), root.parent
        if package is not None:
            inside = self._source.relative_to(package.root).parts
            if self._roots:
                return PurePosixPath(package.name, *inside), package.root.parent
            return PurePosixPath(*inside), package.root
        return PurePosixPath(), self._source

    def hull_place(self, reference: Reference, stem: str, shelf: str) -> HullPlace:
        """Beside the mesh, referred to in its style."""
        resolution = reference.resolution
        own = f"{safe_name(shelf)}/{stem}" if shelf else stem
        below = f"{HULLS}/{own}"
        if resolution.means == "file":
            inside = _inside(self.folder, f"{INNER}/{own}")
            return HullPlace(_inside(self.folder, below), f"{below}/", stem, inside)
        shown = _shelf_of(resolution.rest, resolution.package)
        above = f"{shown}/" if shown else ""
        outer, inner = above + below, f"{above}{INNER}/{own}"
        if resolution.package is None:
            folder = self.folder
            return HullPlace(_inside(folder, outer), f"{outer}/", stem, _inside(folder, inner))
        scheme = "model" if reference.uri.lower().startswith("model:") else "package"
        folder = self._workspace / resolution.package
        prefix = f"{scheme}://{resolution.package}/{outer}/"
        return HullPlace(_inside(folder, outer), prefix, stem, _inside(folder, inner))

    def copies(
        self, references: Iterable[Reference]
    ) -> tuple[tuple[Copy, ...], tuple[Finding, ...]]:
        """Every file that these references need; places that several files claim, and files that
        strangers may not have meant to be handed on."""
        places: dict[str, Copy] = {}
        findings: list[Finding] = []
        references = tuple(references)
        for named in references:
            path = named.resolution.path
            if path is not None and not is_drawn(path):
                findings.append(
                    Finding(
                        "AP102",
                        Severity.WARNING,
                        f"'{shortened(named.uri)}' is no kind of mesh or image: not copied",
                        location=Location(self._robot.path, named.line),
                        link=named.link,
                    )
                )
        wanted: list[tuple[Copy, Reference | None]]
        wanted = [(copy, r) for r in references for copy in self._needed(r)]
        wanted += [(copy, None) for copy in self._manifests()]
        for copy, reference in wanted:
            key = str(copy.to).casefold()
            other = places.setdefault(key, copy)
            if other.source != copy.source and not _same(other.source, copy.source):
                line = reference.line if reference is not None else None
                findings.append(
                    Finding(
                        "AP101",
                        Severity.WARNING,
                        f"two files named '{copy.source.name}' belong at '{copy.to}'; the one from "
                        f"'{os.path.relpath(other.source.parent, self._source)}' is written",
                        location=Location(self._robot.path, line),
                        link=reference.link if reference is not None else None,
                    )
                )
        return tuple(sorted(places.values(), key=lambda c: str(c.to))), tuple(findings)

    def _needed(self, reference: Reference) -> Iterable[Copy]:
        resolution = reference.resolution
        if resolution.path is None or resolution.root is None or resolution.means == "file":
            return
        if not is_drawn(resolution.path):
            return
        if resolution.package is None:
            to = _inside(self.folder, resolution.rest)
        else:
            within = os.path.relpath(resolution.path, resolution.root)
            to = _inside(self._workspace / resolution.package, Path(within).as_posix())
        yield Copy(resolution.path, to)
        home = self._robot.home
        # a mesh of a neighbouring package has its textures there
        root = home if resolution.path.is_relative_to(home) else resolution.root
        for companion in companions(resolution.path, root):
            place = _normal(to.parent / companion.reference)
            if place is not None:
                yield Copy(companion.source, place)

    def _manifests(self) -> Iterable[Copy]:
        package = self._robot.package
        found = {name: roots[0] for name, roots in self._roots.items()}
        if package is not None and found:
            found.setdefault(package.name, package.root)
        for name, root in found.items():
            if (root / "package.xml").is_file():
                yield Copy(root / "package.xml", self._workspace / name / "package.xml")
        if package is not None and not found:
            # the URDF's folder without what lies between it and its package
            within = len(self._source.relative_to(package.root).parts)
            top = PurePosixPath(*self.folder.parts[: len(self.folder.parts) - within])
            yield Copy(package.root / "package.xml", top / "package.xml")
        for reference in self._robot.references:
            yield from self._neighbour(reference)

    def _neighbour(self, reference: Reference) -> Iterable[Copy]:
        """The manifest of the package that a relative reference leads into."""
        resolution = reference.resolution
        if resolution.path is None or resolution.package is not None or resolution.means == "file":
            return
        to = _inside(self.folder, resolution.rest)
        for above in resolution.path.parents:
            if (above / "package.xml").is_file():
                within = resolution.path.relative_to(above).parts
                if to.parts[-len(within) :] == within:
                    top = PurePosixPath(*to.parts[: -len(within)])
                    yield Copy(above / "package.xml", top / "package.xml")
                return


def _climb(rest: str) -> int:
    """How many folders a relative path climbs above where it starts."""
    depth = lowest = 0
    for part in PurePosixPath(rest).parts:
        depth += -1 if part == ".." else 1
        lowest = min(lowest, depth)
    return -lowest


def _normal(path: PurePosixPath) -> PurePosixPath | None:
    """The path with ``..`` taken out, or ``None`` if it leads out of OUT."""
    parts: list[str] = []
    for part in path.parts:
        if part == "..":
            if not parts:
                return None
            parts.pop()
        elif part != "/":
            parts.append(part)
    return PurePosixPath(*parts)


def _inside(folder: PurePosixPath, rest: str) -> PurePosixPath:
    place = _normal(folder / rest.lstrip("/"))
    assert place is not None  # noqa: S101 - OUT was made as deep as references climb
    return place


def _shelf_of(rest: str, package: str | None) -> str:
    """The part of a reference up to its last folder called ``meshes``, else its folder."""
    # of package://meshes/… the name is that folder
    parts = (package or "", *PurePosixPath(rest).parts[:-1])
    named = [k for k, part in enumerate(parts) if part.casefold() in ("meshes", "mesh")]
    return "/".join(parts[1 : named[-1] + 1] if named else parts[1:])


def _same(a: Path, b: Path) -> bool:
    try:
        return os.path.samefile(a, b)
    except OSError:
        return False
