"""The rung that drops stray sheets."""

from __future__ import annotations

from time import process_time

from assetpipe.geometry.repair.deviation import RESOLUTION, farthest_each
from assetpipe.geometry.repair.result import Rung, Step
from assetpipe.geometry.repair.surface import Surface
from assetpipe.geometry.repair.unite import Shell, put_together
from assetpipe.geometry.repair.within import whole
from assetpipe.geometry.repair.wording import counted
from assetpipe.geometry.repair.work import Job, Work, stacked, triangles_of

_ON = 1e-9
"""Units from the solid within which a sheet counts as one on it."""


def buried(work: Work, job: Job) -> Work:
    """Rung: stray sheets that lie inside the solid, or on it, are dropped."""
    if not work.patches or not work.shells:
        return work
    clock = process_time()
    solid = Surface(*put_together(list(outward(work.shells))))
    corners, owner = triangles_of(work.patches)
    allowed = max(job.thickness, _ON)
    apart = farthest_each(
        solid,
        corners,
        owner,
        len(work.patches),
        side="solid",
        resolution=RESOLUTION,
        floor=allowed,
        ceiling=allowed,
        whole=whole(corners, solid.vertices, solid.faces),
        deadline=job.deadline,
    )
    kept = [patch for patch, a in zip(work.patches, apart, strict=True) if a > allowed]
    gone = [patch.corners for patch, a in zip(work.patches, apart, strict=True) if a <= allowed]
    if not gone:
        return work
    worst = float(apart[apart <= allowed].max())
    step = Step(
        Rung.CLEAN,
        f"dropped {counted(len(gone), 'open sheet')} inside the solid",
        moved=worst * job.frame.scale,
        seconds=process_time() - clock,
    )
    return work.after(step, patches=tuple(kept), lost=stacked(work.lost, *gone))


def outward(shells: tuple[Shell, ...]) -> list[Shell]:
    """Shells, those facing inward reversed."""
    return [shell.outward for shell in shells]
