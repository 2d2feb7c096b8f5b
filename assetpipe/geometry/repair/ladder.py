"""The repair ladder: each rung only when needed, each measured."""

from __future__ import annotations

from dataclasses import dataclass, replace
from time import process_time

import numpy as np

from assetpipe.errors import MeshError
from assetpipe.findings import Finding, Severity
from assetpipe.geometry.health.topology import Edges, face_components
from assetpipe.geometry.health.weld import degenerate, referenced
from assetpipe.geometry.mesh import FloatArray, IntArray, Mesh
from assetpipe.geometry.repair.check import defect
from assetpipe.geometry.repair.clean import drop_duplicates, weld_exactly
from assetpipe.geometry.repair.deviation import deviation
from assetpipe.geometry.repair.frame import Frame
from assetpipe.geometry.repair.holes import Opening, cap, openings
from assetpipe.geometry.repair.orient import wind_consistently
from assetpipe.geometry.repair.policy import RepairLimits, RepairPolicy
from assetpipe.geometry.repair.result import Deviation, Repaired, Rung, Step
from assetpipe.geometry.repair.split import split_nonmanifold
from assetpipe.geometry.repair.unite import nest, put_together, shells_of, unite


@dataclass(frozen=True, eq=False)
class State:
    """A mesh on its way up, in units of the frame, and what has been done to it."""

    vertices: FloatArray
    faces: IntArray
    steps: tuple[Step, ...] = ()
    findings: tuple[Finding, ...] = ()

    def after(
        self,
        vertices: FloatArray,
        faces: IntArray,
        *steps: Step,
        findings: tuple[Finding, ...] = (),
    ) -> State:
        """The next state."""
        return replace(
            self,
            vertices=vertices,
            faces=faces,
            steps=self.steps + steps,
            findings=self.findings + findings,
        )


def repair(
    mesh: Mesh, *, policy: RepairPolicy | None = None, limits: RepairLimits | None = None
) -> Repaired:
    """Make a mesh a solid: closed, outward, every edge with exactly two faces.

    A mesh that is one already comes back unchanged, bit for bit.

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
        message = f"{len(mesh.faces)} faces; repair takes at most {limits.faces}"
        return Repaired(None, findings=(Finding("AP206", Severity.ERROR, message),))
    if mesh.diagonal <= 0.0:
        return Repaired(None, findings=(Finding("AP204", Severity.ERROR, "all vertices coincide"),))
    why = defect(mesh.vertices, mesh.faces)
    if policy.mode == "off":
        if why is None:
            return Repaired(mesh)
        return Repaired(None, findings=(_no_solid(why, "repair is off"),))
    if why is None and _single(mesh.faces, len(mesh.vertices)):
        return Repaired(mesh)
    return _climb(mesh, policy, limits)


def _single(faces: IntArray, vertices: int) -> bool:
    return face_components(Edges.of(faces, vertices))[0] == 1


def _no_solid(why: str, hint: str | None = None) -> Finding:
    return Finding("AP202", Severity.ERROR, f"the mesh is no solid: {why}", hint=hint)


def _climb(mesh: Mesh, policy: RepairPolicy, limits: RepairLimits) -> Repaired:
    state = cleaned(State(mesh.vertices, mesh.faces))
    if not len(state.faces):
        finding = Finding("AP204", Severity.ERROR, "every face is degenerate or cancels another")
        return Repaired(None, state.steps, findings=(finding,))
    state = wound(state)
    state = taken_apart(state)
    if policy.mode == "auto":
        state = filled(state, policy, mesh)
    if len(Edges.of(state.faces, len(state.vertices)).boundary):
        why = "it has openings that are not small"
        return Repaired(None, state.steps, findings=(*state.findings, _no_solid(why)))
    united = made_one(state, policy)
    if isinstance(united, str):
        return Repaired(None, state.steps, findings=(*state.findings, _no_solid(united)))
    state, kept, dropped = united
    still = defect(state.vertices, state.faces)
    if still is not None:
        return Repaired(None, state.steps, findings=(*state.findings, _no_solid(still)))
    solid = Mesh(state.vertices, state.faces)
    measured = _measured(mesh, solid, state.steps)
    return Repaired(solid, state.steps, measured, state.findings, kept, dropped)


def _measured(mesh: Mesh, solid: Mesh, steps: tuple[Step, ...]) -> Deviation:
    """Zero if no step moved anything; else what branch and bound finds."""
    if all(step.moved == 0.0 for step in steps):
        return Deviation()
    faces = np.delete(mesh.faces, degenerate(mesh.faces), axis=0)
    return deviation((mesh.vertices, faces), (solid.vertices, solid.faces))


def cleaned(state: State) -> State:
    """Rung 1: weld exactly, drop degenerate and duplicate faces."""
    clock = process_time()
    weld = weld_exactly(state.vertices, state.faces)
    unique = drop_duplicates(weld.vertices, weld.faces)
    steps = []
    if weld.welded or weld.degenerate:
        what = (
            f"joined {weld.welded} coinciding vertices, dropped {weld.degenerate} faces with them"
        )
        steps.append(Step(Rung.WELD, what, seconds=process_time() - clock))
    if unique.duplicate:
        steps.append(Step(Rung.CLEAN, f"dropped {unique.duplicate} duplicate faces"))
    return state.after(unique.vertices, unique.faces, *steps)


def wound(state: State) -> State:
    """Rung: neighbouring faces wind the same way."""
    clock = process_time()
    faces, flipped, one_sided = wind_consistently(state.vertices, state.faces)
    if not flipped:
        return state
    what = f"turned {flipped} faces to agree with their neighbours"
    if one_sided:
        what += f"; {one_sided} patches are one-sided"
    return state.after(
        state.vertices, faces, Step(Rung.ORIENT, what, seconds=process_time() - clock)
    )


def taken_apart(state: State) -> State:
    """Rung: no edge with more than two faces, no vertex with several umbrellas."""
    clock = process_time()
    vertices, faces, added = split_nonmanifold(state.vertices, state.faces)
    if not added:
        return state
    what = f"split non-manifold edges and vertices ({added} vertices copied)"
    return state.after(vertices, faces, Step(Rung.SPLIT, what, seconds=process_time() - clock))


def filled(state: State, policy: RepairPolicy, mesh: Mesh) -> State:
    """Rung: caps over openings."""
    clock = process_time()
    frame = Frame.around(mesh.vertices)
    units = frame.inward(state.vertices)
    found = openings(units, state.faces)
    if not found:
        return state
    caps = [cap(units, opening) for opening in found if _closable(opening, policy)]
    if not caps:
        return state
    faces = np.concatenate([state.faces, *caps])
    widest = max(opening.width for opening in found if _closable(opening, policy)) * frame.scale
    step = Step(
        Rung.FILL,
        f"closed {len(caps)} openings, the widest {widest:.4g} m",
        moved=widest / 2.0,
        volume_change=None,
        seconds=process_time() - clock,
    )
    return state.after(state.vertices, faces, step)


def _closable(opening: Opening, policy: RepairPolicy) -> bool:
    if policy.openings == "fill":
        return True
    return opening.width < 0.1 or opening.flatness < 1e-3 * opening.width


def made_one(state: State, policy: RepairPolicy) -> tuple[State, int, int] | str:
    """Rung: closed shells turned outward, nested ones recognised, overlapping ones united."""
    clock = process_time()
    frame = Frame.around(state.vertices)
    units = frame.inward(state.vertices)
    shells = shells_of(units, state.faces)
    sound = [shell for shell in shells if shell.volume != 0.0]
    if not sound:
        return "it encloses no volume"
    before = sum(abs(shell.volume) for shell in sound)
    nested = nest(sound)
    steps = []
    if nested.inverted:
        what = f"turned {nested.inverted} inside-out shells"
        steps.append(Step(Rung.ORIENT, what, seconds=process_time() - clock))
    if len(sound) == 1:
        vertices, faces = put_together(list(nested.shells))
        restored, _ = frame.restored(vertices, state.vertices)
        if len(restored) == len(state.vertices) and not nested.inverted:
            return state, 0, 0
        return state.after(restored, faces, *steps), 0, 0
    clock = process_time()
    united = unite(nested, policy.cavities)
    if united is None:
        return "the union of its components failed"
    vertices, new = frame.restored(united.vertices, state.vertices)
    faces = united.faces
    vertices, faces, _ = split_nonmanifold(*referenced(vertices, faces))
    what = {
        "apart": f"{len(sound)} shells lie apart",
        "union": f"united {len(sound)} shells, {new} vertices on their intersections",
    }[united.joined]
    if united.buried:
        what += f", {united.buried} buried in others"
    if united.cavities:
        done = "kept" if policy.cavities == "keep" else "filled"
        what += f"; {united.cavities} enclosed cavities {done}"
    solid = Mesh(frame.inward(vertices), faces)
    cubed = frame.scale**3
    step = Step(
        Rung.UNITE,
        what,
        volume_change=(solid.volume - before) * cubed,
        seconds=process_time() - clock,
    )
    kept = united.cavities if policy.cavities == "keep" else 0
    return state.after(vertices, faces, *steps, step), kept, united.cavities - kept
