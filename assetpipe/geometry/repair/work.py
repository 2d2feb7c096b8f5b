"""A mesh on its way up the ladder."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from assetpipe.findings import Finding
from assetpipe.geometry.mesh import FloatArray, IntArray, Mesh
from assetpipe.geometry.repair.deadline import Deadline
from assetpipe.geometry.repair.frame import Frame
from assetpipe.geometry.repair.policy import RepairLimits, RepairPolicy
from assetpipe.geometry.repair.result import Step
from assetpipe.geometry.repair.surface import Corners, Surface, no_corners
from assetpipe.geometry.repair.unite import Shell


@dataclass(frozen=True, eq=False)
class Patch:
    """One connected piece of open surface, in units; every vertex has one umbrella."""

    vertices: FloatArray
    faces: IntArray

    @property
    def corners(self) -> Corners:
        """(m, 3, 3)."""
        return self.vertices[self.faces]


@dataclass(frozen=True, eq=False)
class Piece:
    """Faces that belong together by their winding, with caps; vertices of its own.

    Attributes:
        vertices: (n, 3), units.
        faces: (m, 3).
        closed: whether no opening is left.
    """

    vertices: FloatArray
    faces: IntArray
    closed: bool


@dataclass(frozen=True, eq=False)
class Job:
    """What stays the same on the way: the input, what may be done, and how long.

    Attributes:
        mesh: the input, metres.
        frame: units in which the work is done.
        surface: the input's surface, units.
        budget: units.
        thickness: of sheets, units.
        deadline: of the whole repair.
    """

    mesh: Mesh
    frame: Frame
    surface: Surface
    policy: RepairPolicy
    limits: RepairLimits
    budget: float
    thickness: float
    deadline: Deadline


@dataclass(frozen=True, eq=False)
class Work:
    """The state between two rungs. Lengths are units of the job's frame.

    Attributes:
        vertices: (n, 3) of the surface that is not yet taken apart.
        faces: (m, 3).
        shells: closed pieces.
        patches: open pieces.
        pieces: what ``faces`` are apart, once openings have been closed.
        fresh: triangles that the input did not have.
        lost: triangles of the input that were replaced or dropped.
        dropped: bound on how far from the solid lies what was dropped and is not ``lost``.
        grown: bound on how far a union put the surface from the pieces that it united.
        displacement: bound on how far points of the input were moved.
        beside: bound on how far from the input the surface lies that is not ``fresh`` and
            was put beside it.
    """

    vertices: FloatArray
    faces: IntArray
    shells: tuple[Shell, ...] = ()
    patches: tuple[Patch, ...] = ()
    pieces: tuple[Piece, ...] = ()
    fresh: Corners = field(default_factory=no_corners)
    lost: Corners = field(default_factory=no_corners)
    dropped: float = 0.0
    grown: float = 0.0
    displacement: float = 0.0
    beside: float = 0.0
    cavities_kept: int = 0
    cavities_filled: int = 0
    steps: tuple[Step, ...] = ()
    findings: tuple[Finding, ...] = ()
    notes: tuple[str, ...] = ()

    def after(self, *steps: Step, findings: tuple[Finding, ...] = (), **changes: Any) -> Work:
        """The next state: fields replaced, steps and findings appended."""
        return replace(self, steps=self.steps + steps, findings=self.findings + findings, **changes)


def triangles_of(patches: Sequence[Patch]) -> tuple[Corners, IntArray]:
    """Triangles of all patches, and the index of the patch of each."""
    sizes = [len(patch.faces) for patch in patches]
    return stacked(*(patch.corners for patch in patches)), np.repeat(np.arange(len(sizes)), sizes)


def stacked(*parts: Corners) -> Corners:
    """Triangles of all parts."""
    return np.concatenate([no_corners(), *parts])
