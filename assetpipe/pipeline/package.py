"""One robot's package, staged: hulls, URDF and what else its references need."""

from __future__ import annotations

import os
import shutil
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import assetpipe
from assetpipe.decomposition.primitives import Primitive
from assetpipe.findings import Finding
from assetpipe.geometry.files import obj_text
from assetpipe.geometry.mesh import FloatArray
from assetpipe.geometry.products import composed
from assetpipe.pipeline.config import Config, Source
from assetpipe.pipeline.elements import Element, elements_of
from assetpipe.pipeline.identity import digest_file
from assetpipe.pipeline.outcome import MeshOutcome
from assetpipe.pipeline.output import Stage
from assetpipe.pipeline.plan import MeshJob
from assetpipe.pipeline.reading import Read
from assetpipe.pipeline.run import Done
from assetpipe.robot import (
    Box,
    Capsule,
    Cylinder,
    HullMesh,
    Link,
    MeshShape,
    NewCollision,
    NewShape,
    OtherShape,
    Robot,
    Sphere,
    write_urdf,
)
from assetpipe.robot.packaging import INNER, Copy, HullPlace, Layout, lay_out

Key = tuple[Source, str, int]
"""Kind, link and index of an element."""


@dataclass(frozen=True, eq=False)
class Worked:
    """Jobs of a plan and what became of them, in the same order."""

    jobs: tuple[MeshJob, ...]
    done: tuple[Done, ...]

    @property
    def outcomes(self) -> tuple[MeshOutcome, ...]:
        """One a job."""
        return tuple(item.outcome for item in self.done)


@dataclass(frozen=True, eq=False)
class Draft:
    """A staged package that still has to be proved and reported.

    Attributes:
        stage: where it lies.
        read: the source.
        number: the robot's index in the plan.
        jobs: of the plan.
        elements: what became of every collision element.
        meshes: index of the job and its outcome, for every mesh of this robot.
        files: hull files by kind, link and index of the element, relative to the stage.
        inner_files: files of inner hulls, likewise.
        urdf: the written URDF, relative to the stage; ``None`` for a bare mesh.
        inputs: SHA-256 by absolute path of every file that was read or copied.
        named_inputs: SHA-256 by a name that is the same on every machine.
        roots: folders that paths are told relative to.
        findings: about the package.
    """

    stage: Stage
    read: Read
    number: int
    jobs: Sequence[MeshJob]
    elements: tuple[Element, ...]
    meshes: tuple[tuple[int, Done], ...]
    files: Mapping[Key, tuple[str, ...]] = field(default_factory=dict)
    inner_files: Mapping[Key, tuple[str, ...]] = field(default_factory=dict)
    urdf: str | None = None
    inputs: Mapping[str, str] = field(default_factory=dict)
    named_inputs: Mapping[str, str] = field(default_factory=dict)
    roots: tuple[Path, ...] = ()
    findings: tuple[Finding, ...] = ()

    @property
    def robot(self) -> Robot:
        """As read."""
        return self.read.robot

    @property
    def outcomes(self) -> Mapping[int, MeshOutcome]:
        """By index of the job."""
        return {job: done.outcome for job, done in self.meshes}


def draft(stage: Stage, read: Read, number: int, worked: Worked, config: Config) -> Draft:
    """Stage everything of one robot but its report.

    Args:
        stage: where to.
        read: the source.
        number: the robot's index in the plan.
        worked: the plan's jobs and their outcomes.
        config: what is asked.
    """
    elements = elements_of(read.robot, number, worked.jobs, worked.outcomes, config)
    meshes = tuple(
        (place, done)
        for place, (job, done) in enumerate(zip(worked.jobs, worked.done, strict=True))
        if any(use.robot == number for use in job.uses)
    )
    bare = Draft(stage, read, number, worked.jobs, elements, meshes)
    return _bare(bare) if read.source.kind == "mesh" else _robot(bare, config)


def _bare(start: Draft) -> Draft:
    """Hulls of a mesh file, beside each other."""
    path = start.read.source.path
    files: dict[Key, tuple[str, ...]] = {}
    inner: dict[Key, tuple[str, ...]] = {}
    for element, outcome in zip(start.elements, start.outcomes.values(), strict=True):
        key = (element.kind, element.link, element.index)
        files[key] = tuple(
            _write_hull(start.stage, f"{path.stem}_hull_{index:03d}.obj", outcome, index)
            for index in range(len(outcome.hulls))
        )
        inner[key] = tuple(
            _write_inner(start.stage, f"{INNER}/{path.stem}_inner_{index:03d}.obj", outcome, index)
            for index in range(len(outcome.inner))
        )
    digest = start.jobs[start.meshes[0][0]].digest
    return replace(
        start,
        files=files,
        inner_files=inner,
        inputs={str(path): digest},
        named_inputs={path.name: digest},
        roots=(path.parent,),
    )


def _robot(start: Draft, config: Config) -> Draft:
    """Hulls beside the meshes that they stand for, the patched URDF, and copies of the rest."""
    robot, stage = start.robot, start.stage
    decomposed = [e for e in start.elements if e.treatment == "decomposed"]
    standing_in = {e.link for e in start.elements if e.kind == "visual"}
    replaced = {(e.link, e.index) for e in decomposed if e.kind == "collision"}
    replaced |= {
        (link.name, element.index)
        for link in robot.links
        if link.name in standing_in
        for element in link.collisions
    }
    layout = lay_out(robot, replaced=replaced)
    places = _shared(decomposed, layout)
    files: dict[tuple[int, HullPlace], tuple[str, ...]] = {}
    inner: dict[tuple[int, HullPlace], tuple[str, ...]] = {}
    for element in decomposed:
        place = places[element.kind, element.link, element.index]
        assert element.job is not None  # noqa: S101 - decomposed elements have one
        if (element.job, place) not in files:
            outcome = start.outcomes[element.job]
            files[element.job, place] = tuple(
                _write_hull(stage, str(place.path(index)), outcome, index)
                for index in range(len(outcome.hulls))
            )
            inner[element.job, place] = tuple(
                _write_inner(stage, str(place.inner_path(index)), outcome, index)
                for index in range(len(outcome.inner))
            )
    replacements, additions = new_collisions(start, places)
    stage.path(str(layout.urdf)).write_bytes(write_urdf(robot, replacements, additions))
    for copy in layout.copies:
        shutil.copyfile(copy.source, stage.path(str(copy.to)))
    inputs, named = _inputs(start, layout.copies)
    keys = {(e.kind, e.link, e.index): e.job for e in decomposed if e.job is not None}
    return replace(
        start,
        files={key: files[job, places[key]] for key, job in keys.items()},
        inner_files={key: inner[job, places[key]] for key, job in keys.items()},
        urdf=str(layout.urdf),
        inputs=inputs,
        named_inputs=named,
        roots=_roots(robot, start.read.source.root),
        findings=layout.findings,
    )


def new_collisions(
    start: Draft, places: Mapping[Key, HullPlace]
) -> tuple[dict[tuple[str, int], tuple[NewCollision, ...]], dict[str, tuple[NewCollision, ...]]]:
    """What :func:`assetpipe.robot.write_urdf` is asked: replacements and additions."""
    replacements: dict[tuple[str, int], tuple[NewCollision, ...]] = {}
    additions: dict[str, tuple[NewCollision, ...]] = {}
    for element in start.elements:
        origin: FloatArray | Literal["kept"] = "kept"
        if element.kind == "visual":
            origin = element.link_from_shape
        if element.treatment == "decomposed" and element.job is not None:
            place = places[element.kind, element.link, element.index]
            made = tuple(
                NewCollision(HullMesh(place.uri(index)), origin)
                if hull.primitive is None
                else _simple(hull.primitive, element.link_from_shape)
                for index, hull in enumerate(start.outcomes[element.job].hulls)
            )
        elif element.kind == "visual" and not isinstance(element.shape, MeshShape | OtherShape):
            made = (NewCollision(element.shape, origin),)
        else:
            continue
        if element.kind == "collision":
            replacements[element.link, element.index] = made
        else:
            additions[element.link] = (*additions.get(element.link, ()), *made)
    for link in robot_links(start, additions):
        for old in link.collisions:
            replacements[link.name, old.index] = ()
    return replacements, additions


def _simple(shape: Primitive, link_from_hull: FloatArray) -> NewCollision:
    """A simple shape where its hull would lie."""
    made: NewShape
    if shape.kind == "box":
        x, y, z = shape.size
        made = Box((x, y, z))
    elif shape.kind == "sphere":
        made = Sphere(shape.size[0])
    elif shape.kind == "cylinder":
        made = Cylinder(*shape.size)
    else:
        made = Capsule(*shape.size)
    return NewCollision(made, composed(link_from_hull, shape.frame))


def robot_links(start: Draft, names: Container[str]) -> list[Link]:
    """The links with these names."""
    return [link for link in start.robot.links if link.name in names]


def _shared(elements: Sequence[Element], layout: Layout) -> dict[Key, HullPlace]:
    """Where each element's hulls lie: elements of one mesh share the first one's files,
    as long as these can be referred to in the same style."""
    first: dict[tuple[int, str, str], HullPlace] = {}
    places: dict[Key, HullPlace] = {}
    for element in elements:
        assert element.job is not None  # noqa: S101 - decomposed elements have one
        own = layout.hulls[element.kind, element.link, element.index]
        above = own.prefix.rstrip("/").rpartition("/")[0]
        group = (element.job, str(own.folder.parent), above)
        places[element.kind, element.link, element.index] = first.setdefault(group, own)
    return places


def _inputs(start: Draft, copies: Sequence[Copy]) -> tuple[dict[str, str], dict[str, str]]:
    """SHA-256 of everything that was read: by absolute path, and by a portable name."""
    robot = start.robot
    top = robot.package.root if robot.package else Path(os.path.abspath(robot.path)).parent
    own = [robot.path, *robot.includes]
    inputs = {os.path.abspath(path): digest_file(path) for path in own}
    inputs |= {os.path.abspath(copy.source): digest_file(copy.source) for copy in copies}
    named = {
        Path(os.path.relpath(os.path.abspath(path), top)).as_posix(): inputs[os.path.abspath(path)]
        for path in own
    }
    for job, _ in start.meshes:
        mesh = start.jobs[job]
        inputs[os.path.abspath(mesh.path)] = digest_file(mesh.path)
        for use in mesh.uses:
            if use.robot == start.number:
                named[use.uri] = mesh.digest
    named |= {str(copy.to): inputs[os.path.abspath(copy.source)] for copy in copies}
    return inputs, named


def _roots(robot: Robot, root: Path) -> tuple[Path, ...]:
    """Folders that stand before the paths in messages, the deepest first."""
    found = {root, Path(os.path.abspath(robot.path)).parent}
    if robot.package is not None:
        found.add(robot.package.root)
    found |= {r.resolution.root for r in robot.references if r.resolution.root is not None}
    return tuple(sorted(found, key=lambda path: (-len(path.parts), str(path))))


def _write_hull(stage: Stage, name: str, outcome: MeshOutcome, index: int) -> str:
    """Write one hull; its path in the stage."""
    hull = outcome.hulls[index]
    around = f", around a {hull.primitive.kind}" if hull.primitive else ""
    comment = (
        f"assetpipe {assetpipe.__version__}: convex hull {index + 1} of {len(outcome.hulls)}, "
        f"metres, thickening at most {hull.thickening[1]!r} m{around}"
    )
    stage.path(name).write_bytes(obj_text(hull.mesh, comment=comment))
    return name


def _write_inner(stage: Stage, name: str, outcome: MeshOutcome, index: int) -> str:
    """Write one inner hull; its path in the stage."""
    comment = (
        f"assetpipe {assetpipe.__version__}: inner hull {index + 1} of {len(outcome.inner)}, "
        "metres, proved to be inside the mesh after repair; not for the URDF"
    )
    stage.path(name).write_bytes(obj_text(outcome.inner[index], comment=comment))
    return name
