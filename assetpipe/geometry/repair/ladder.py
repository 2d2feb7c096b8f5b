"""The repair ladder: each rung only when needed, each measured."""

from __future__ import annotations

from time import process_time
from typing import Literal

from assetpipe.errors import LimitError, MeshError
from assetpipe.findings import Finding, Severity
from assetpipe.geometry.health.topology import Edges, face_areas, face_components
from assetpipe.geometry.mesh import IntArray, Mesh
from assetpipe.geometry.repair.bury import buried
from assetpipe.geometry.repair.check import defect
from assetpipe.geometry.repair.clean import one_of_each, weld_exactly
from assetpipe.geometry.repair.deadline import Deadline
from assetpipe.geometry.repair.divide import divided, enclosing_nothing, flattened
from assetpipe.geometry.repair.fill import filled
from assetpipe.geometry.repair.frame import Frame
from assetpipe.geometry.repair.measured import measured, moved_by_union, strays
from assetpipe.geometry.repair.overlap import TANGLED, disentangled, overlap
from assetpipe.geometry.repair.policy import RepairLimits, RepairPolicy
from assetpipe.geometry.repair.prepare import halved, set_aside, stitched, wound
from assetpipe.geometry.repair.remake import remade
from assetpipe.geometry.repair.result import Deviation, Repaired, Rung, Step
from assetpipe.geometry.repair.split import split_nonmanifold
from assetpipe.geometry.repair.stiffen import thickened
from assetpipe.geometry.repair.surface import Surface
from assetpipe.geometry.repair.unfold import folds, unfolded
from assetpipe.geometry.repair.unite import Shell, unite
from assetpipe.geometry.repair.wording import counted
from assetpipe.geometry.repair.work import Job, Work, stacked
from assetpipe.geometry.repair.wrap import enclosed, wrapped
from assetpipe.geometry.strays import referenced


def repair(
    mesh: Mesh, *, policy: RepairPolicy | None = None, limits: RepairLimits | None = None
) -> Repaired:
    """Make a mesh a solid: closed, outward, every edge with exactly two faces.

    A mesh that is one already, and has no folds without thickness, comes back unchanged,
    bit for bit, but for vertices that no face uses.

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
    mesh = mesh.without_strays()
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
        what = (
            f"joined {weld.welded} coinciding vertices, dropped {counted(weld.degenerate, 'face')}"
        )
        if weld.repeated:
            what += f" and {weld.repeated} repeated ones"
        steps = (Step(Rung.WELD, what, seconds=process_time() - clock),)
    if not len(weld.faces) or not face_areas(weld.vertices, weld.faces)[0].any():
        finding = Finding("AP204", Severity.ERROR, "all faces are degenerate: there is no surface")
        return Repaired(None, steps, findings=(finding,))
    welded = Mesh(weld.vertices, weld.faces)
    if steps and defect(weld.vertices, weld.faces) is None and _sound(welded, policy):
        return Repaired(welded, steps)
    frame = Frame.around(weld.vertices)
    units = frame.inward(weld.vertices)
    # Faces that lost a corner may have reached anywhere: the budget is of what is left.
    job = Job(
        mesh,
        frame,
        Surface(units, weld.faces),
        policy,
        limits,
        policy.budget_on(welded) / frame.scale,
        policy.thickness_on(welded) / frame.scale,
        deadline,
    )
    work = set_aside(Work(units, weld.faces, steps=steps), job)
    work = flattened(work, job)
    even, odd = halved(work)
    work = buried(divided(work, even, job), job)
    if policy.mode == "strict" and (len(odd) or work.patches):
        return _refused(_open(work, odd), work, "strict repair closes no openings")
    work = _completed(work.after(faces=one_of_each(odd)), job)
    if work.patches:
        hint = None if job.thickness > 0.0 else "a budget of 0 leaves sheets no thickness"
        return _refused(_open(work, odd[:0]), work, hint)
    job.deadline.check()
    if policy.mode != "strict":
        work = unfolded(work, job)
    work = disentangled(work, job)
    if work.patches and job.thickness == 0.0:
        return _refused(
            "it runs through itself, and a budget of 0 leaves sheets no thickness", work
        )
    return _finished(thickened(work, job), job)


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
    if not work.patches or job.policy.openings == "refuse" or job.thickness == 0.0:
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
    pieces = [(work.vertices, odd), *((p.vertices, p.faces) for p in work.patches)]
    faces = sum(len(faces) for _, faces in pieces)
    edges = sum(len(Edges.of(faces, len(points)).boundary) for points, faces in pieces)
    return f"{faces} faces bound nothing, with {edges} open edges"


def _finished(work: Work, job: Job, union: Literal["first", "second"] = "first") -> Repaired:
    """One solid of all closed pieces, checked and measured."""
    clock = process_time()
    shells = tuple(shell for shell in work.shells if not enclosing_nothing(shell))
    flat = [s.vertices[s.faces] for s in work.shells if enclosing_nothing(s)]
    work = work.after(lost=stacked(work.lost, *flat))
    if flat:
        dropped = f"dropped {counted(len(flat), 'piece')} without volume"
        work = work.after(Step(Rung.CLEAN, dropped))
    if not shells:
        return _refused("it encloses no volume", work)
    united = unite(shells, job.policy.cavities, job.deadline)
    if united is None:
        return _refused("the union of its pieces failed", work)
    removed, grown = moved_by_union(united, job.deadline)
    if union == "first" and max(removed, grown) > job.budget and job.policy.mode != "strict":
        other = remade(work, job)
        if other is not work:
            return _finished(other, job, "second")
    work = work.after(dropped=max(work.dropped, removed), grown=grown)
    vertices, new = job.frame.restored(united.vertices, job.mesh.vertices)
    vertices, faces, _ = split_nonmanifold(*referenced(vertices, united.faces))
    steps = []
    if united.inverted:
        steps.append(Step(Rung.ORIENT, f"turned {counted(united.inverted, 'inside-out piece')}"))
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
        change = Mesh(job.frame.inward(vertices), faces).volume - united.enclosed
        steps.append(
            Step(
                Rung.UNITE,
                what,
                moved=max(removed, grown) * job.frame.scale,
                volume_change=change * job.frame.scale**3,
                seconds=process_time() - clock,
            )
        )
    work = work.after(*steps)
    still = defect(vertices, faces)
    if still is not None:
        return _refused(still, work)
    solid = Mesh(vertices, faces)
    deviation = measured(work, job, solid)
    if job.policy.mode == "strict" and deviation.largest > 1e-9 * solid.diagonal:
        return _refused("strict repair may not move the surface", work)
    asked = job.policy.openings == "fill" or job.policy.thickness is not None
    if not asked and strays(deviation, job, solid):
        return _too_far(deviation, work, job)
    return Repaired(
        solid,
        work.steps,
        deviation,
        (*work.findings, *_said(work, deviation, united.cavities, kept)),
        kept,
        united.cavities - kept,
        work.notes,
    )


def _too_far(deviation: Deviation, work: Work, job: Job) -> Repaired:
    finding = Finding(
        "AP203",
        Severity.ERROR,
        f"a hundredth of the surface would move by {deviation.p99 * 1000:.3g} mm and more, "
        f"{deviation.largest * 1000:.3g} mm at most; the budget is "
        f"{job.budget * job.frame.scale * 1000:.3g} mm",
        hint="mend the mesh, or allow repair a larger budget",
    )
    return Repaired(None, work.steps, deviation, (*work.findings, finding), notes=work.notes)


def _said(work: Work, deviation: Deviation, cavities: int, kept: int) -> list[Finding]:
    """What the user should know about a mesh that was repaired."""
    found = []
    taken = [step for step in work.steps if step.rung is not Rung.WELD]
    if taken:
        what = "; ".join(step.what for step in taken)
        severity = Severity.WARNING if deviation.largest > 0.0 else Severity.NOTE
        found.append(Finding("AP201", severity, what))
    if cavities:
        done = "kept" if kept else "filled"
        found.append(Finding("AP207", Severity.NOTE, f"{cavities} enclosed cavities were {done}"))
    return found
