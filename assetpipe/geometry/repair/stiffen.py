"""The rung that gives open sheets a thickness."""

from __future__ import annotations

from time import process_time
from typing import Literal

import numpy as np

from assetpipe.findings import Finding, Severity
from assetpipe.geometry.health.topology import Edges, face_areas
from assetpipe.geometry.mesh import FloatArray, IntArray
from assetpipe.geometry.repair.clean import one_of_each
from assetpipe.geometry.repair.deviation import RESOLUTION, farthest, farthest_each
from assetpipe.geometry.repair.fill import capped
from assetpipe.geometry.repair.holes import cap, openings
from assetpipe.geometry.repair.result import Rung, Step
from assetpipe.geometry.repair.sheets import manifold_pieces, thicken
from assetpipe.geometry.repair.unite import shells_of, signed_volume
from assetpipe.geometry.repair.wording import counted
from assetpipe.geometry.repair.work import Job, Patch, Work, stacked, triangles_of

IF_SOLID = (
    "if the part is solid, close the mesh or set openings to 'fill', for all (in "
    "repair:, or --openings fill) or for this link (in links:)"
)
"""What to do about an opening that is ambiguous."""


def thickened(work: Work, job: Job) -> Work:
    """Rung: what is still open becomes a thick sheet."""
    if not work.patches:
        return work
    clock = process_time()
    scale = job.frame.scale
    findings, slabs, away = [], [], []
    for sheet in work.patches:
        own = []
        job.deadline.check()
        findings += wide_openings(sheet, job)
        for vertices, faces in manifold_pieces(sheet.vertices, one_of_each(sheet.faces)):
            bounds, wound = _turned(vertices, faces)
            side: Literal["inward", "centred"] = "inward" if bounds else "centred"
            own.append(thicken(vertices, wound, job.thickness, side))
        slabs += own
        away.append(max((slab.away for slab in own), default=0.0))
    shells = [shell for slab in slabs for shell in shells_of(slab.vertices, slab.faces)]
    caps = stacked(*(slab.caps for slab in slabs))
    beside = float((_apart(work, job) + away).max())
    moved = max(
        beside,
        farthest(
            job.surface,
            caps,
            side="surface",
            resolution=RESOLUTION,
            floor=beside,
            deadline=job.deadline,
        ),
    )
    step = Step(
        Rung.SHEET,
        f"gave {counted(len(work.patches), 'open sheet')} "
        f"a thickness of {job.thickness * scale:.3g} m",
        moved=moved * scale,
        volume_change=None,
        seconds=process_time() - clock,
    )
    return work.after(
        step,
        findings=tuple(findings),
        shells=(*work.shells, *shells),
        patches=(),
        fresh=stacked(work.fresh, caps),
        # Where sheets are narrower than their thickness, slabs need not hold all of them.
        lost=stacked(work.lost, *(sheet.corners for sheet in work.patches)),
        beside=max(work.beside, beside),
    )


def _apart(work: Work, job: Job) -> FloatArray:
    """(patches,) bounds on how far any point of each lies from the input: caps of narrow
    openings, of which sheets may have some, do not lie on it."""
    patches = work.patches
    if not len(work.fresh):
        return np.zeros(len(patches))
    return farthest_each(
        job.surface,
        *triangles_of(patches),
        len(patches),
        side="surface",
        resolution=RESOLUTION,
        deadline=job.deadline,
    )


def _turned(vertices: FloatArray, faces: IntArray) -> tuple[bool, IntArray]:
    """The winding that faces outward, judged by the volume over the caps, if it can be."""
    edges = Edges.of(faces, len(vertices))
    if len(edges.inconsistent) or len(edges.nonmanifold):
        return False, faces
    area = float(face_areas(vertices, faces)[0].sum())
    caps = [cap(vertices, opening) for opening in openings(vertices, faces)]
    volume = signed_volume(vertices, np.concatenate([faces, *caps]))
    if abs(volume) < 1e-6 * area:
        return False, faces
    return True, faces if volume > 0.0 else faces[:, ::-1]


def wide_openings(patch: Patch, job: Job) -> list[Finding]:
    """What to say about the widest opening of a patch that bounds a body nearly."""
    trial = capped(patch.vertices, patch.faces, job)
    wide = np.flatnonzero(trial.apart > job.budget)
    if not len(wide):
        return []
    scale = job.frame.scale
    opening = max((trial.openings[i] for i in wide), key=lambda o: o.width)
    at = ", ".join(f"{x:.4g}" for x in job.frame.outward(opening.centre[None])[0])
    flat = "flat" if opening.flatness < 0.01 * opening.width else "not flat"
    return [
        Finding(
            "AP208",
            Severity.WARNING,
            f"{counted(len(wide), 'opening')} {'is' if len(wide) == 1 else 'are'} wider than the "
            f"repair budget allows to close; the widest, {opening.width * scale:.4g} m at ({at}) "
            f"and {flat}, was left open and "
            f"the surface given a thickness of {job.thickness * scale:.3g} m",
            hint=IF_SOLID,
        )
    ]
