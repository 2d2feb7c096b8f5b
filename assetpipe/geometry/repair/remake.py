"""The rung for pieces that a union would distort.

manifold3d tidies a shell before it unites it: it swaps the edges of faces that look folded to it.
Next to needles that run back and forth in nearly one plane, that can tear a hole.
"""

from __future__ import annotations

from time import process_time

from assetpipe.geometry.repair.divide import enclosing_nothing
from assetpipe.geometry.repair.measured import moved_by_union
from assetpipe.geometry.repair.overlap import by_winding
from assetpipe.geometry.repair.result import Rung, Step
from assetpipe.geometry.repair.unite import Shell, compared, manifold_of
from assetpipe.geometry.repair.wording import counted
from assetpipe.geometry.repair.work import Job, Work, stacked


def remade(work: Work, job: Job) -> Work:
    """Rung: what manifold3d would move beyond the budget is made a body by winding number."""
    clock = process_time()
    shells: list[Shell] = []
    fresh, lost = [work.fresh], [work.lost]
    for shell in work.shells:
        job.deadline.check()
        outward = shell.outward
        parts = by_winding(outward, job) if _is_distorted(outward, job) else None
        if parts is None:
            shells.append(shell)
            continue
        fresh += [part.vertices[part.faces] for part in parts]
        lost.append(shell.vertices[shell.faces])
        shells += parts if shell.volume >= 0.0 else [part.reversed() for part in parts]
    number = len(lost) - 1
    if not number:
        return work
    step = Step(
        Rung.WINDING,
        f"made {counted(number, 'piece')} that a union would tear a body by winding number",
        seconds=process_time() - clock,
    )
    return work.after(step, shells=tuple(shells), fresh=stacked(*fresh), lost=stacked(*lost))


def _is_distorted(shell: Shell, job: Job) -> bool:
    """Whether manifold3d moves an outward shell beyond the budget before it does anything."""
    if enclosing_nothing(shell):
        return False
    solid = manifold_of(shell.vertices, shell.faces)
    if solid is None:
        return True
    tidied = compared(solid, (shell.vertices, shell.faces))
    return max(moved_by_union(tidied, job.deadline)) > job.budget
