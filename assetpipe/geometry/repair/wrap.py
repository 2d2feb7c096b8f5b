"""The rung that makes open pieces a solid by winding number."""

from __future__ import annotations

from dataclasses import dataclass
from time import process_time
from typing import Literal

import numpy as np

from assetpipe.findings import Finding, Severity
from assetpipe.geometry.health.topology import Edges, components, face_components
from assetpipe.geometry.mesh import FloatArray
from assetpipe.geometry.repair.deviation import RESOLUTION, farthest, farthest_each, quantile
from assetpipe.geometry.repair.divide import connected
from assetpipe.geometry.repair.fill import MINOR
from assetpipe.geometry.repair.result import Rung, Step
from assetpipe.geometry.repair.rows import as_rows
from assetpipe.geometry.repair.stiffen import IF_SOLID, wide_openings
from assetpipe.geometry.repair.surface import Surface
from assetpipe.geometry.repair.unite import Shell, shells_of, signed_volume
from assetpipe.geometry.repair.winding import CELL, solid_of_soup
from assetpipe.geometry.repair.work import Job, Patch, Work, stacked, triangles_of

_TRIAL = 2e-2


def wrapped(work: Work, job: Job) -> Work:
    """Rung: open pieces that enclose a volume together become a solid by winding number.

    Pieces near to each other are tried, then at once all that are left.
    """
    if not work.patches:
        return work
    clock = process_time()
    tried = []
    for group in _neighbours(work.patches, job.budget):
        patches = [work.patches[i] for i in group]
        tried.append((patches, _wrap(patches, job, minor="kept")))
    kept = [patch for patches, found in tried for patch in _left(patches, found)]
    plain = (len(tried) > 1 or tried[-1][1] == "apart") and _plain(kept, job)
    if plain and len(tried) > 1:
        tried.append((kept, _wrap(kept, job, minor="kept")))
        kept = _left(*tried[-1])
    if plain and tried[-1][1] == "apart":
        work = work.after(findings=(_nearly(kept, job),))
    made = [(patches, found) for patches, found in tried if isinstance(found, Wrap)]
    if not made:
        return work
    moved = max(found.apart for _, found in made)
    number = sum(len(patches) for patches, _ in made)
    what = f"made {number} open pieces a solid by winding number"
    return work.after(
        _step(what, moved, clock, job),
        shells=(*work.shells, *(shell for _, found in made for shell in found.shells)),
        patches=tuple(kept),
        lost=stacked(work.lost, *(patch.corners for patches, _ in made for patch in patches)),
        beside=max(work.beside, moved),
    )


def _left(patches: list[Patch], found: Wrap | Literal["apart"] | None) -> list[Patch]:
    """The pieces that stay open."""
    return [patches[i] for i in found.outside] if isinstance(found, Wrap) else patches


def _plain(patches: list[Patch], job: Job) -> bool:
    """Whether there are several pieces, and none whose own openings are wide."""
    return len(patches) > 1 and not any(wide_openings(patch, job) for patch in patches)


def _nearly(patches: list[Patch], job: Job) -> Finding:
    """What to say of several pieces, none of which encloses anything alone."""
    low = np.min([patch.vertices.min(axis=0) for patch in patches], axis=0)
    high = np.max([patch.vertices.max(axis=0) for patch in patches], axis=0)
    return Finding(
        "AP208",
        Severity.WARNING,
        f"{len(patches)} open pieces, {job.frame.scale * np.linalg.norm(high - low):.4g} m "
        "in size together, nearly enclose a volume; their gaps are wider than the repair "
        "budget allows to close, and their surfaces were given a thickness",
        hint=IF_SOLID,
    )


def enclosed(before: Work, after: Work, job: Job) -> Work | None:
    """Rung: open pieces whose borders nearly meet become the solid that they enclose together.

    Caps are no answer to a body of many sheets: each closes one sheet by itself, near to the
    sheets beside it, and what is between all of them is lost.

    Args:
        before: the pieces before caps were put over their openings.
        after: the pieces with caps; some of them are still open.
        job: as ever.

    Returns:
        ``before`` without the faces of all groups of pieces that ``after`` could not close and
        that enclose a solid; their solids are among its shells. ``None`` if there are none.
    """
    clock = process_time()
    sheets = connected(before.vertices, before.faces)
    _, label = face_components(Edges.of(before.faces, len(before.vertices)))
    still = np.concatenate([patch.vertices for patch in after.patches])
    shells, lost = list(before.shells), [before.lost]
    done: list[int] = []
    moved = 0.0
    for group in _neighbours(tuple(sheets), job.budget):
        own = np.concatenate([sheets[i].vertices for i in group])
        if len(group) < 2 or not _share_any(own, still):
            continue
        job.deadline.check()
        found = _wrap([sheets[i] for i in group], job, minor="closed")
        if not isinstance(found, Wrap):
            continue
        shells += found.shells
        lost += [sheets[i].corners for i in group]
        done += [i for k, i in enumerate(group) if k not in found.outside]
        moved = max(moved, found.apart)
    if not done:
        return None
    what = f"made {len(done)} open pieces the solid that they enclose, by winding number"
    return before.after(
        _step(what, moved, clock, job),
        faces=before.faces[~np.isin(label, done)],
        shells=tuple(shells),
        lost=stacked(*lost),
        beside=max(before.beside, moved),
    )


def _step(what: str, moved: float, clock: float, job: Job) -> Step:
    """What was done since ``clock``; ``moved`` in units."""
    return Step(
        Rung.WINDING,
        what,
        moved=moved * job.frame.scale,
        volume_change=None,
        seconds=process_time() - clock,
    )


def _share_any(points: FloatArray, others: FloatArray) -> bool:
    """Whether some point is among others, bit for bit."""
    return bool(np.isin(as_rows(points), as_rows(others)).any())


@dataclass(frozen=True, eq=False)
class Wrap:
    """A solid in place of some patches.

    Attributes:
        shells: its surface.
        apart: bound on how far that lies from the input, units.
        outside: which patches stand out of it by more than the budget.
    """

    shells: list[Shell]
    apart: float
    outside: list[int]


def _wrap(
    patches: list[Patch], job: Job, minor: Literal["kept", "closed"]
) -> Wrap | Literal["apart"] | None:
    """The solid of some patches, if its surface lies within the budget of the input.

    ``minor="closed"``: but for a share of its area that is minor. ``"apart"``: it does not;
    ``None``: the patches enclose nothing, or too much to be computed.
    """
    vertices = np.concatenate([patch.vertices for patch in patches])
    offsets = np.cumsum([0, *(len(patch.vertices) for patch in patches)])
    faces = np.concatenate([patch.faces + at for patch, at in zip(patches, offsets, strict=False)])
    if signed_volume(vertices, faces) < 0.0:
        faces = faces[:, ::-1]
    allowed = np.inf if job.policy.openings == "fill" else job.budget
    trial = solid_of_soup(vertices, faces, _TRIAL, job.limits.cells, job.deadline)
    if trial is None:
        return None
    # The coarse solid is as far off as the fine one; only its farthest point is rough.
    share, enough = (1.0, allowed + _TRIAL) if minor == "kept" else (1.0 - MINOR, 1.2 * allowed)
    if quantile(job.surface, trial, side="surface", share=share) > enough:
        return "apart"
    fine = solid_of_soup(vertices, faces, CELL, job.limits.cells, job.deadline)
    if fine is None:
        return None
    if quantile(job.surface, fine, side="surface", share=share) > allowed:
        return "apart"
    apart = farthest(
        job.surface,
        fine[0][fine[1]],
        side="surface",
        resolution=RESOLUTION,
        floor=job.budget / 4.0,
        deadline=job.deadline,
    )
    if apart > allowed and minor == "kept":
        return "apart"
    out = farthest_each(
        Surface(*fine),
        *triangles_of(patches),
        len(patches),
        side="solid",
        resolution=RESOLUTION,
        floor=job.budget,
        ceiling=job.budget,
        deadline=job.deadline,
    )
    return Wrap(shells_of(*fine), apart, np.flatnonzero(out > job.budget).tolist())


def _neighbours(patches: tuple[Patch, ...], margin: float) -> list[list[int]]:
    """Groups of patches whose boxes come nearer than the margin."""
    low = np.array([patch.vertices.min(axis=0) for patch in patches]) - margin / 2.0
    high = np.array([patch.vertices.max(axis=0) for patch in patches]) + margin / 2.0
    a, b = [], []
    for i in range(len(patches)):
        meet = ((low[i:] <= high[i]) & (high[i:] >= low[i])).all(axis=1)
        a.append(np.full(int(meet.sum()), i))
        b.append(i + np.flatnonzero(meet))
    number, label = components(len(patches), np.concatenate(a), np.concatenate(b))
    return [np.flatnonzero(label == k).tolist() for k in range(number)]
