"""One robot's package, staged: hulls, URDF and what else its references need."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import assetpipe
from assetpipe.geometry.files import obj_text
from assetpipe.pipeline.config import Config
from assetpipe.pipeline.elements import Element, elements_of
from assetpipe.pipeline.outcome import MeshOutcome
from assetpipe.pipeline.output import Stage
from assetpipe.pipeline.plan import MeshJob
from assetpipe.pipeline.reading import Read
from assetpipe.pipeline.run import Done
from assetpipe.robot import Robot


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
        files: hull files by index of the job, relative to the stage.
        urdf: the written URDF, relative to the stage; ``None`` for a bare mesh.
        inputs: SHA-256 by absolute path of every file that was read or copied.
        named_inputs: SHA-256 by a name that is the same on every machine.
        roots: folders that paths are told relative to.
    """

    stage: Stage
    read: Read
    number: int
    jobs: Sequence[MeshJob]
    elements: tuple[Element, ...]
    meshes: tuple[tuple[int, Done], ...]
    files: Mapping[int, tuple[str, ...]] = field(default_factory=dict)
    urdf: str | None = None
    inputs: Mapping[str, str] = field(default_factory=dict)
    named_inputs: Mapping[str, str] = field(default_factory=dict)
    roots: tuple[Path, ...] = ()

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
    files = {
        job: tuple(
            _write_hull(start.stage, f"{path.stem}_{index:03d}.obj", done.outcome, index)
            for index in range(len(done.outcome.hulls))
        )
        for job, done in start.meshes
    }
    digest = start.jobs[start.meshes[0][0]].digest
    return replace(
        start,
        files=files,
        inputs={str(path): digest},
        named_inputs={path.name: digest},
        roots=(path.parent,),
    )


def _write_hull(stage: Stage, name: str, outcome: MeshOutcome, index: int) -> str:
    """Write one hull; its path in the stage."""
    hull = outcome.hulls[index]
    comment = (
        f"assetpipe {assetpipe.__version__}: convex hull {index + 1} of {len(outcome.hulls)}, "
        f"metres, thickening at most {hull.thickening[1]!r} m"
    )
    stage.path(name).write_bytes(obj_text(hull.mesh, comment=comment))
    return name
