"""The rung that makes open pieces a solid by winding number."""

from __future__ import annotations

from time import process_time

import numpy as np

from assetpipe.geometry.health.topology import components
from assetpipe.geometry.mesh import FloatArray, IntArray
from assetpipe.geometry.repair.deviation import RESOLUTION, farthest, farthest_each
from assetpipe.geometry.repair.result import Rung, Step
from assetpipe.geometry.repair.surface import Surface
from assetpipe.geometry.repair.unite import shells_of
from assetpipe.geometry.repair.winding import solid_of_soup
from assetpipe.geometry.repair.work import Job, Patch, Work, stacked

CELL = 5e-3
"""Edge of the grid's cells, in units."""
_TRIAL = 2e-2


def wrapped(work: Work, job: Job) -> Work:
    """Rung: open pieces that enclose a volume together become a solid by winding number."""
    if not work.patches:
        return work
    clock = process_time()
    shells, kept = list(work.shells), []
    fresh, lost = [work.fresh], [work.lost]
    moved = 0.0
    number = 0
    for group in _neighbours(work.patches, job.budget):
        job.check_time()
        patches = [work.patches[i] for i in group]
        found = _wrap(patches, job)
        if found is None:
            kept += patches
            continue
        (vertices, faces), apart = found
        shells += shells_of(vertices, faces)
        fresh.append(vertices[faces])
        lost += [patch.corners for patch in patches]
        # What stands out of the solid stays for the next rung.
        solid = Surface(vertices, faces)
        out = farthest_each(
            solid,
            stacked(*(patch.corners for patch in patches)),
            np.repeat(np.arange(len(patches)), [len(patch.faces) for patch in patches]),
            len(patches),
            side="solid",
            resolution=RESOLUTION,
            floor=job.budget,
            ceiling=job.budget,
        )
        kept += [patch for patch, far in zip(patches, out, strict=True) if far > job.budget]
        moved = max(moved, apart)
        number += len(patches)
    if not number:
        return work
    step = Step(
        Rung.WINDING,
        f"made {number} open pieces a solid by winding number",
        moved=moved * job.frame.scale,
        volume_change=None,
        seconds=process_time() - clock,
    )
    return work.after(
        step,
        shells=tuple(shells),
        patches=tuple(kept),
        fresh=stacked(*fresh),
        lost=stacked(*lost),
    )


def _wrap(patches: list[Patch], job: Job) -> tuple[tuple[FloatArray, IntArray], float] | None:
    """The solid of some patches and how far it lies from the input, if within the budget."""
    vertices = np.concatenate([patch.vertices for patch in patches])
    offsets = np.cumsum([0, *(len(patch.vertices) for patch in patches)])
    faces = np.concatenate([patch.faces + at for patch, at in zip(patches, offsets, strict=False)])
    allowed = np.inf if job.policy.openings == "fill" else job.budget
    trial = solid_of_soup(vertices, faces, _TRIAL, job.limits.cells)
    if trial is None:
        return None
    strayed = job.surface.distance(trial[0])
    if float(strayed.max()) > allowed + _TRIAL:
        return None
    fine = solid_of_soup(vertices, faces, CELL, job.limits.cells)
    if fine is None:
        return None
    apart = farthest(
        job.surface,
        fine[0][fine[1]],
        side="surface",
        resolution=RESOLUTION,
        floor=job.budget / 4.0,
    )
    return (fine, apart) if apart <= allowed else None


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
