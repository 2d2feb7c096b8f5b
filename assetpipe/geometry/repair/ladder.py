"""The repair ladder: each rung only when needed, each measured."""

from __future__ import annotations

from time import process_time

import numpy as np

from assetpipe.errors import LimitError, MeshError
from assetpipe.findings import Finding, Severity
from assetpipe.geometry.health.topology import Edges, face_areas, face_components
from assetpipe.geometry.health.weld import degenerate, referenced
from assetpipe.geometry.mesh import IntArray, Mesh
from assetpipe.geometry.products import added
from assetpipe.geometry.repair.bury import buried
from assetpipe.geometry.repair.check import defect
from assetpipe.geometry.repair.clean import one_of_each, weld_exactly
from assetpipe.geometry.repair.deadline import Deadline
from assetpipe.geometry.repair.deviation import RESOLUTION, Side, farthest, quantile
from assetpipe.geometry.repair.divide import divided, enclosing_nothing, flattened
from assetpipe.geometry.repair.fill import filled
from assetpipe.geometry.repair.frame import Frame
from assetpipe.geometry.repair.overlap import TANGLED, disentangled, overlap
from assetpipe.geometry.repair.policy import RepairLimits, RepairPolicy
from assetpipe.geometry.repair.prepare import halved, set_aside, stitched, wound
from assetpipe.geometry.repair.result import Deviation, Repaired, Rung, Step
from assetpipe.geometry.repair.split import split_nonmanifold
from assetpipe.geometry.repair.stiffen import thickened
from assetpipe.geometry.repair.surface import Corners, Surface
from assetpipe.geometry.repair.unfold import folds, unfolded
from assetpipe.geometry.repair.unite import Shell, unite
from assetpipe.geometry.repair.work import Job, Work, stacked
from assetpipe.geometry.repair.wrap import enclosed, wrapped

_ROUNDING = 1e-11
"""Units below which a measured distance is rounding of the measurement."""


def repair(
    mesh: Mesh, *, policy: RepairPolicy | None = None, limits: RepairLimits | None = None
) -> Repaired:
    """Make a mesh a solid: closed, outward, every edge with exactly two faces.

    A mesh that is one already, and has no folds without thickness, comes back unchanged,
    bit for bit.

    Args:
        mesh: any triangles, metres.
        policy: what may be done, :class:`RepairPolicy`.
        limits: bounds on the work, :class:`RepairLimits`.

    Returns:
        :class:`Repaired`; ``solid`` is ``None`` if it can't be done within the policy, and
        then ``findings`` say why. Bad geometry raises nothing.

    Raises:
        MeshError: the mesh has no faces.
    """
    policy = policy or RepairPolicy()
    limits = limits or RepairLimits()
    if not len(mesh.faces):
        raise MeshError("the mesh has no faces")
    if len(mesh.faces) > limits.faces:
        return _beyond(f"{len(mesh.faces)} faces; repair takes at most {limits.faces}")
    try:
        # libigl takes down the process where squares of coordinates overflow.
        mesh.check_size()
    except LimitError as error:
        return _beyond(error.message)
    why = defect(mesh.vertices, mesh.faces)
    if policy.mode == "off":
        return Repaired(mesh) if why is None else _refused(why, hint="repair is off")
    if why is None and _sound(mesh, policy):
        return Repaired(mesh)
    try:
        return _climb(mesh, policy, limits)
    except LimitError as error:
        return _beyond(error.message)


def _beyond(message: str) -> Repaired:
    """Refused for a limit."""
    return Repaired(None, findings=(Finding("AP206", Severity.ERROR, message),))


def _sound(mesh: Mesh, policy: RepairPolicy) -> bool:
    """Whether a solid has one component that encloses something and does not overlap itself.

    Nor may it be folded; but to take folds out may move the surface, which strict repair
    does not.
    """
    if face_components(Edges.of(mesh.faces, len(mesh.vertices)))[0] != 1:
        return False
    shell = Shell.of(Frame.around(mesh.vertices).inward(mesh.vertices), mesh.faces)
    if policy.mode != "strict" and folds(shell.vertices, shell.faces):
        return False
    return not enclosing_nothing(shell) and overlap(shell) <= TANGLED


def _refused(why: str, work: Work | None = None, hint: str | None = None) -> Repaired:
    finding = Finding("AP202", Severity.ERROR, f"the mesh is no solid: {why}", hint=hint)
    if work is None:
        return Repaired(None, findings=(finding,))
    return Repaired(None, work.steps, findings=(*work.findings, finding), notes=work.notes)


def _climb(mesh: Mesh, policy: RepairPolicy, limits: RepairLimits) -> Repaired:
    clock, deadline = process_time(), Deadline.after(limits.seconds)
    weld = weld_exactly(mesh.vertices, mesh.faces)
    steps: tuple[Step, ...] = ()
    if weld.welded or weld.degenerate or weld.repeated:
        what = f"joined {weld.welded} coinciding vertices, dropped {weld.degenerate} faces"
        if weld.repeated:
            what += f" and {weld.repeated} repeated ones"
        steps = (Step(Rung.WELD, what, seconds=process_time() - clock),)
    if not len(weld.faces) or not face_areas(weld.vertices, weld.faces)[0].any():
        finding = Finding("AP204", Severity.ERROR, "all faces are degenerate: there is no surface")
        return Repaired(None, steps, findings=(finding,))
    if steps and defect(weld.vertices, weld.faces) is None:
        welded = Mesh(weld.vertices, weld.faces)
        if _sound(welded, policy):
            return Repaired(welded, steps)
    frame = Frame.around(weld.vertices)
    units = frame.inward(weld.vertices)
    job = Job(
        mesh,
        frame,
        Surface(units, weld.faces),
        policy,
        limits,
        policy.budget_on(mesh) / frame.scale,
        policy.thickness_on(mesh) / frame.scale,
        deadline,
    )
    work = set_aside(Work(units, weld.faces, steps=steps), job)
    work = flattened(work, job)
    even, odd = halved(work)
    work = divided(work, even, job)
    if policy.mode == "strict" and (len(odd) or work.patches):
        return _refused(_open(work, odd), work, "strict repair closes no openings")
    work = _completed(work.after(faces=one_of_each(odd)), job)
    if work.patches:
        return _refused(_open(work, odd), work)
    job.deadline.check()
    if policy.mode != "strict":
        work = unfolded(work, job)
    return _finished(disentangled(work, job), job)


def _completed(work: Work, job: Job) -> Work:
    """The rungs for open pieces, one after the other."""
    if len(work.faces):
        work = wound(stitched(wound(work, job), job), job)
        job.deadline.check()
        before, work = work, _capped(work, job)
        if work.patches and job.policy.openings in ("auto", "fill"):
            whole = enclosed(before, work, job)
            work = work if whole is None else _capped(whole, job)
    work = buried(work, job)
    if not work.patches or job.policy.openings == "refuse":
        return work
    if job.policy.openings != "sheet":
        work = wrapped(work, job)
        work = buried(work, job)
    job.deadline.check()
    return thickened(work, job)


def _capped(work: Work, job: Job) -> Work:
    """Caps over openings, and what they close taken apart."""
    work = filled(work, job)
    return buried(divided(work, one_of_each(work.faces), job), job)


def _open(work: Work, odd: IntArray) -> str:
    edges = len(Edges.of(odd, len(work.vertices)).boundary)
    faces = len(odd) + sum(len(patch.faces) for patch in work.patches)
    return f"{faces} faces bound nothing, with {edges} open edges"


def _finished(work: Work, job: Job) -> Repaired:
    """One solid of all closed pieces, checked and measured."""
    clock = process_time()
    shells = tuple(shell for shell in work.shells if not enclosing_nothing(shell))
    flat = [s.vertices[s.faces] for s in work.shells if enclosing_nothing(s)]
    work = work.after(lost=stacked(work.lost, *flat))
    if flat:
        number = f"{len(flat)} piece{'s' * (len(flat) > 1)}"
        work = work.after(Step(Rung.CLEAN, f"dropped {number} without volume"))
    if not shells:
        return _refused("it encloses no volume", work)
    united = unite(shells, job.policy.cavities, job.deadline)
    if united is None:
        return _refused("the union of its pieces failed", work)
    work = work.after(lost=stacked(work.lost, united.gone), fresh=stacked(work.fresh, united.put))
    vertices, new = job.frame.restored(united.vertices, job.mesh.vertices)
    vertices, faces, _ = split_nonmanifold(*referenced(vertices, united.faces))
    steps = []
    if united.inverted:
        steps.append(Step(Rung.ORIENT, f"turned {united.inverted} inside-out pieces"))
    kept = united.cavities if job.policy.cavities == "keep" else 0
    if len(shells) > 1:
        what = (
            f"united {len(shells)} pieces"
            if united.joined == "union"
            else (f"{len(shells)} pieces do not overlap")
        )
        if united.joined == "union":
            what += f", with {new} vertices where they meet"
        if united.buried:
            what += f", {united.buried} buried in others"
        if united.cavities:
            what += f"; {united.cavities} enclosed cavities {'kept' if kept else 'filled'}"
        enclosed = added(abs(shell.volume) for shell in shells)
        change = Mesh(job.frame.inward(vertices), faces).volume - enclosed
        steps.append(
            Step(
                Rung.UNITE,
                what,
                volume_change=change * job.frame.scale**3,
                seconds=process_time() - clock,
            )
        )
    work = work.after(*steps)
    still = defect(vertices, faces)
    if still is not None:
        return _refused(still, work)
    solid = Mesh(vertices, faces)
    measured = _measured(work, job, solid)
    if job.policy.mode == "strict" and measured.largest > 1e-9 * job.mesh.diagonal:
        return _refused("strict repair may not move the surface", work)
    return Repaired(
        solid,
        work.steps,
        measured,
        (*work.findings, *_said(work, measured, united.cavities, kept)),
        kept,
        united.cavities - kept,
        work.notes,
    )


def _said(work: Work, measured: Deviation, cavities: int, kept: int) -> list[Finding]:
    """What the user should know about a mesh that was repaired."""
    found = []
    taken = [step for step in work.steps if step.rung is not Rung.WELD]
    if taken:
        what = "; ".join(step.what for step in taken)
        severity = Severity.WARNING if measured.largest > 0.0 else Severity.NOTE
        found.append(Finding("AP201", severity, what))
    if cavities:
        done = "kept" if kept else "filled"
        found.append(Finding("AP207", Severity.NOTE, f"{cavities} enclosed cavities were {done}"))
    return found


def _measured(work: Work, job: Job, solid: Mesh) -> Deviation:
    """Bounds from what was moved, added and given up; the rest of the surface stayed.

    The percentiles are of the surfaces as they are, not of the bounds.
    """
    fresh, lost = work.fresh, work.lost
    if work.displacement == work.beside == work.dropped == 0.0 and not len(fresh) and not len(lost):
        return Deviation()
    scale = job.frame.scale
    after = Surface(job.frame.inward(solid.vertices), solid.faces)

    def bound(target: Surface, corners: Corners, side: Side, floor: float) -> float:
        sharp = max(job.budget / 10.0, floor)
        return farthest(
            target,
            corners,
            side=side,
            resolution=RESOLUTION,
            floor=sharp,
            deadline=job.deadline,
        )

    # What was put beside lies about that far away: no need to know the rest more sharply.
    added = max(bound(job.surface, fresh, "surface", work.beside), work.beside)
    removed = max(bound(after, lost, "solid", work.dropped), work.dropped)
    added, removed = added + work.displacement, removed + work.displacement
    if max(removed, added) < _ROUNDING:
        return Deviation()
    faces = np.delete(job.mesh.faces, degenerate(job.mesh.faces), axis=0)
    before = job.frame.inward(job.mesh.vertices), faces
    return Deviation(
        removed * scale,
        added * scale,
        min(quantile(after, before, side="solid"), removed) * scale,
        min(quantile(job.surface, (after.vertices, after.faces), side="surface"), added) * scale,
        "bound",
    )
