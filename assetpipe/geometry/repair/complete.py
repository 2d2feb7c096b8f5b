"""The rungs that add surface: caps, solids of soups, thick sheets."""

from __future__ import annotations

from dataclasses import dataclass
from time import process_time

import numpy as np

from assetpipe.findings import Finding, Severity
from assetpipe.geometry.health.topology import (
    Edges,
    components,
    face_areas,
    face_components,
    groups,
)
from assetpipe.geometry.health.weld import referenced
from assetpipe.geometry.mesh import FloatArray, IntArray
from assetpipe.geometry.repair.clean import one_of_each, weld_exactly
from assetpipe.geometry.repair.deviation import farthest
from assetpipe.geometry.repair.holes import Opening, cap, openings
from assetpipe.geometry.repair.result import Rung, Step
from assetpipe.geometry.repair.sheets import thicken
from assetpipe.geometry.repair.split import split_nonmanifold
from assetpipe.geometry.repair.surface import Surface
from assetpipe.geometry.repair.unite import Shell, put_together, shells_of, signed_volume
from assetpipe.geometry.repair.winding import solid_of_soup
from assetpipe.geometry.repair.work import Job, Patch, Work, stacked

RESOLUTION = 2e-4
"""How sharp measured bounds are, in units."""
MINOR = 0.01
"""Share of a piece's area below which openings wider than the budget are closed, too: the
99th percentile of the deviation does not see them."""
CELL = 5e-3
"""Edge of the grid's cells, in units."""
_TRIAL = 2e-2


@dataclass(frozen=True, eq=False)
class Capped:
    """A patch with its caps, and what they would do.

    Attributes:
        caps: triangles of each opening.
        apart: bound on each cap's distance from the input's surface, units.
        areas: of each cap.
    """

    patch: Patch
    openings: tuple[Opening, ...]
    caps: tuple[IntArray, ...]
    apart: FloatArray
    areas: FloatArray


def capped(patch: Patch, job: Job) -> Capped:
    """Caps over all openings of a patch, measured."""
    found = tuple(openings(patch.vertices, patch.faces))
    caps = tuple(cap(patch.vertices, opening) for opening in found)
    apart = [
        farthest(job.surface, patch.vertices[own], side="surface", resolution=RESOLUTION)
        for own in caps
    ]
    areas = [float(face_areas(patch.vertices, own)[0].sum()) for own in caps]
    return Capped(patch, found, caps, np.array(apart), np.array(areas))


def filled(work: Work, job: Job) -> Work:
    """Rung: openings closed by caps that stay near the surface, or are minor."""
    clock = process_time()
    shells, patches, fresh = list(work.shells), [], [work.fresh]
    closed: list[tuple[float, float]] = []
    for patch in work.patches:
        job.check_time()
        trial = capped(patch, job)
        chosen = _acceptable(trial, job)
        if not chosen:
            patches.append(patch)
            continue
        faces = np.concatenate([patch.faces, *(trial.caps[i] for i in chosen)])
        if len(chosen) == len(trial.caps):
            shell = Shell.of(*split_nonmanifold(patch.vertices, faces)[:2])
            if _is_thin(shell, job):
                patches.append(patch)
                continue
            shells.append(shell)
        else:
            patches.append(Patch(patch.vertices, faces))
        fresh += [patch.vertices[trial.caps[i]] for i in chosen]
        closed += [(trial.openings[i].width, float(trial.apart[i])) for i in chosen]
    if not closed:
        return work
    scale = job.frame.scale
    step = Step(
        Rung.FILL,
        f"closed {len(closed)} openings, the widest {max(closed)[0] * scale:.4g} m",
        moved=max(apart for _, apart in closed) * scale,
        volume_change=None,
        seconds=process_time() - clock,
    )
    return work.after(step, shells=tuple(shells), patches=tuple(patches), fresh=stacked(*fresh))


def _acceptable(trial: Capped, job: Job) -> list[int]:
    """Which openings to close."""
    everything = list(range(len(trial.caps)))
    if job.policy.openings == "fill":
        return everything
    near = [i for i in everything if trial.apart[i] <= job.budget]
    wide = [i for i in everything if trial.apart[i] > job.budget]
    if job.policy.openings == "auto" and wide:
        area = float(face_areas(trial.patch.vertices, trial.patch.faces)[0].sum())
        if float(trial.areas[wide].sum()) <= MINOR * area:
            return everything
    return near


def _is_thin(shell: Shell, job: Job) -> bool:
    """Whether a closed shell is no body but a sheet and its cap."""
    area = float(face_areas(shell.vertices, shell.faces)[0].sum())
    return abs(shell.volume) < area / 2.0 * job.thickness / 4.0


def flattened(work: Work, job: Job) -> Work:
    """Closed shells that enclose nothing become patches: two sides of one sheet."""
    bodies, patches = [], list(work.patches)
    for shell in work.shells:
        area = float(face_areas(shell.vertices, shell.faces)[0].sum())
        if abs(shell.volume) > 1e-9 * area:
            bodies.append(shell)
        else:
            patches.append(Patch(shell.vertices, shell.faces))
    if len(bodies) == len(work.shells):
        return work
    return work.after(shells=tuple(bodies), patches=tuple(patches))


def buried(work: Work, job: Job) -> Work:
    """Rung: stray sheets that lie inside the solid, or on it, are dropped."""
    if not work.patches or not work.shells:
        return work
    clock = process_time()
    solid = Surface(*put_together(list(outward(work.shells))))
    kept, gone, worst = [], [], 0.0
    for patch in work.patches:
        job.check_time()
        apart = farthest(solid, patch.corners, side="solid", resolution=RESOLUTION)
        if apart <= job.thickness:
            gone.append(patch.corners)
            worst = max(worst, apart)
        else:
            kept.append(patch)
    if not gone:
        return work
    step = Step(
        Rung.CLEAN,
        f"dropped {len(gone)} open sheets inside the solid",
        moved=worst * job.frame.scale,
        seconds=process_time() - clock,
    )
    return work.after(step, patches=tuple(kept), lost=stacked(work.lost, *gone))


def outward(shells: tuple[Shell, ...]) -> list[Shell]:
    """Shells, those facing inward reversed."""
    return [shell if shell.volume >= 0.0 else shell.reversed() for shell in shells]


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
        kept += [
            patch
            for patch in patches
            if farthest(solid, patch.corners, side="solid", resolution=RESOLUTION) > job.budget
        ]
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
    apart = farthest(job.surface, fine[0][fine[1]], side="surface", resolution=RESOLUTION)
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


def thickened(work: Work, job: Job) -> Work:
    """Rung: what is still open becomes a thick sheet."""
    if not work.patches:
        return work
    clock = process_time()
    scale = job.frame.scale
    shells, fresh = list(work.shells), [work.fresh]
    moved = 0.0
    findings = [finding for patch in work.patches for finding in _wide(patch, job)]
    sheets = _rejoined(work.patches)
    for sheet in sheets:
        job.check_time()
        bounds, faces = _turned(sheet.vertices, one_of_each(sheet.faces))
        vertices, closed = thicken(
            sheet.vertices, faces, job.thickness, "inward" if bounds else "centred"
        )
        shells += shells_of(vertices, closed)
        fresh.append(vertices[closed])
        apart = farthest(job.surface, vertices[closed], side="surface", resolution=RESOLUTION)
        moved = max(moved, apart)
    step = Step(
        Rung.SHEET,
        f"gave {len(sheets)} open sheets a thickness of {job.thickness * scale:.3g} m",
        moved=moved * scale,
        volume_change=None,
        seconds=process_time() - clock,
    )
    return work.after(
        step,
        findings=tuple(findings),
        shells=tuple(shells),
        patches=(),
        fresh=stacked(*fresh),
    )


def _rejoined(patches: tuple[Patch, ...]) -> list[Patch]:
    """Patches joined again over the edges at which non-manifold ones were taken apart."""
    offsets = np.cumsum([0, *(len(patch.vertices) for patch in patches)])
    joined = weld_exactly(
        np.concatenate([patch.vertices for patch in patches]),
        np.concatenate([p.faces + at for p, at in zip(patches, offsets, strict=False)]),
    )
    number, label = face_components(Edges.of(joined.faces, len(joined.vertices)))
    return [
        Patch(*referenced(joined.vertices, joined.faces[chosen]))
        for chosen in groups(label, number)
    ]


def _turned(vertices: FloatArray, faces: IntArray) -> tuple[bool, IntArray]:
    """The winding that faces outward, judged by the volume over the caps, if it can be."""
    area = float(face_areas(vertices, faces)[0].sum())
    edges = Edges.of(faces, len(vertices))
    if len(edges.inconsistent) or len(edges.nonmanifold):
        return False, faces
    split, own, _ = split_nonmanifold(vertices, faces)
    caps = [cap(split, opening) for opening in openings(split, own)]
    volume = signed_volume(split, np.concatenate([own, *caps]))
    if abs(volume) < 1e-6 * area:
        return False, faces
    return True, faces if volume > 0.0 else faces[:, ::-1]


def _wide(patch: Patch, job: Job) -> list[Finding]:
    """What to say about the widest opening of a patch that bounds a body nearly."""
    trial = capped(patch, job)
    wide = np.flatnonzero(trial.apart > job.budget)
    if not len(wide):
        return []
    scale = job.frame.scale
    opening = max((trial.openings[i] for i in wide), key=lambda o: o.width)
    at = ", ".join(f"{x:.4g}" for x in job.frame.outward(opening.centre[None])[0])
    flat = "plane" if opening.flatness < 0.01 * opening.width else "not plane"
    return [
        Finding(
            "AP208",
            Severity.WARNING,
            f"{len(wide)} openings are wider than the repair budget allows to close; the "
            f"widest, {opening.width * scale:.4g} m at ({at}) and {flat}, was left open and "
            f"the surface given a thickness of {job.thickness * scale:.3g} m",
            hint="if the part is solid, close the mesh or set repair openings to 'fill'",
        )
    ]
