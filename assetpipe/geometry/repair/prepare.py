"""The first rungs: one surface, wound consistently, taken apart into closed and open pieces."""

from __future__ import annotations

from time import process_time

import numpy as np

from assetpipe.geometry.health.topology import Edges, face_components, groups
from assetpipe.geometry.health.weld import referenced
from assetpipe.geometry.repair.clean import drop_duplicates
from assetpipe.geometry.repair.orient import wind_consistently
from assetpipe.geometry.repair.result import Rung, Step
from assetpipe.geometry.repair.split import split_nonmanifold
from assetpipe.geometry.repair.stitch import boundary_length, insert_junctions, weld_boundary
from assetpipe.geometry.repair.unite import Shell
from assetpipe.geometry.repair.work import Job, Patch, Work, stacked

_STITCHES = (1e-7, 1e-6, 1e-5, 1e-4, 1e-3)
"""Tolerances of the boundary weld, as shares of the unit; none beyond the budget."""


def balanced(work: Work) -> bool:
    """Whether the surface is a closed chain: every edge passed as often each way."""
    return not Edges.of(work.faces, len(work.vertices)).balance.any()


def deduplicated(work: Work, job: Job) -> Work:
    """Rung: faces over the same vertices as others, where dropping them leaves less open."""
    clock = process_time()
    cleaned = drop_duplicates(work.vertices, work.faces)
    if not cleaned.duplicate:
        return work
    step = Step(
        Rung.CLEAN,
        f"dropped {cleaned.duplicate} duplicate faces",
        seconds=process_time() - clock,
    )
    return work.after(
        step,
        vertices=cleaned.vertices,
        faces=cleaned.faces,
        lost=stacked(work.lost, cleaned.gone),
    )


def stitched(work: Work, job: Job) -> Work:
    """Rung: boundaries that nearly meet are joined, tightest tolerance first."""
    clock = process_time()
    vertices, faces = work.vertices, work.faces
    left = boundary_length(vertices, faces)
    welded = inserted = 0
    moved = 0.0
    for tolerance in _STITCHES:
        if left == 0.0 or tolerance > job.budget:
            break
        for join in (weld_boundary, insert_junctions, weld_boundary):
            tried = join(vertices, faces, tolerance)
            if not tried.welded and not tried.inserted:
                continue
            rest = boundary_length(tried.vertices, tried.faces)
            if not len(tried.faces) or rest > left * (1.0 + 1e-9):
                continue
            if rest < left or tried.inserted:
                vertices, faces, left = tried.vertices, tried.faces, rest
                welded, inserted = welded + tried.welded, inserted + tried.inserted
                moved += tried.displacement
    if not welded and not inserted:
        return work
    metres = moved * job.frame.scale
    step = Step(
        Rung.STITCH,
        f"joined {welded} boundary vertices and {inserted} T-junctions, "
        f"moving them at most {metres:.3g} m",
        moved=metres,
        volume_change=None,
        seconds=process_time() - clock,
    )
    return work.after(step, vertices=vertices, faces=faces, displacement=work.displacement + moved)


def wound(work: Work, job: Job) -> Work:
    """Rung: neighbouring faces wind the same way."""
    clock = process_time()
    faces, flipped, one_sided = wind_consistently(work.vertices, work.faces)
    if not flipped:
        return work
    what = f"turned {flipped} faces to agree with their neighbours"
    if one_sided:
        what += f"; {one_sided} patches are one-sided"
    return work.after(Step(Rung.ORIENT, what, seconds=process_time() - clock), faces=faces)


def taken_apart(work: Work, job: Job) -> Work:
    """Rung: no edge with more than two faces, no vertex with several umbrellas; pieces."""
    clock = process_time()
    vertices, faces, added = split_nonmanifold(work.vertices, work.faces)
    steps: tuple[Step, ...] = ()
    if added:
        what = f"split non-manifold edges and vertices ({added} vertices added)"
        steps = (Step(Rung.SPLIT, what, seconds=process_time() - clock),)
    edges = Edges.of(faces, len(vertices))
    number, label = face_components(edges)
    odd = np.flatnonzero(edges.balance != 0)
    open_faces = edges.order[edges.first[odd]] // 3
    is_open = np.zeros(number, dtype=bool)
    is_open[label[open_faces]] = True
    shells, patches = [], []
    for k, chosen in enumerate(groups(label, number)):
        piece, own = referenced(vertices, faces[chosen])
        if is_open[k]:
            patches.append(Patch(piece, own))
        else:
            shells.append(Shell.of(piece, own))
    return work.after(
        *steps, vertices=vertices, faces=faces, shells=tuple(shells), patches=tuple(patches)
    )
