"""The first rungs: closed pieces set aside, the rest wound and stitched."""

from __future__ import annotations

from time import process_time

import numpy as np

from assetpipe.geometry.health.topology import Edges, distinct, face_components, groups
from assetpipe.geometry.mesh import IntArray
from assetpipe.geometry.repair.clean import one_of_each
from assetpipe.geometry.repair.orient import wind_consistently
from assetpipe.geometry.repair.result import Rung, Step
from assetpipe.geometry.repair.split import split_nonmanifold
from assetpipe.geometry.repair.stitch import boundary_length, insert_junctions, weld_boundary
from assetpipe.geometry.repair.unite import Shell
from assetpipe.geometry.repair.wording import counted
from assetpipe.geometry.repair.work import Job, Work, stacked
from assetpipe.geometry.strays import referenced

_STITCHES = (1e-7, 1e-6, 1e-5, 1e-4, 1e-3)
"""Tolerances of the boundary weld, as shares of the unit; none beyond the budget."""


def set_aside(work: Work, job: Job) -> Work:
    """Components whose edges all have two faces of the same winding become shells.

    What is left in ``faces`` is what needs repair; of a face drawn from both sides that has
    no other neighbour one side.
    """
    clock = process_time()
    edges = Edges.of(work.faces, len(work.vertices))
    number, label = face_components(edges)
    rough = np.zeros(number, dtype=bool)
    irregular = np.flatnonzero((edges.count != 2) | (edges.balance != 0))
    rough[label[edges.order[edges.first[irregular]] // 3]] = True
    rest = rough[label]
    shells = []
    copied = 0
    for k, chosen in enumerate(groups(label, number)):
        if rough[k]:
            continue
        if len(chosen) == 2:
            rest[chosen[0]] = True
            continue
        vertices, faces, added = split_nonmanifold(*referenced(work.vertices, work.faces[chosen]))
        copied += added
        shells.append(Shell.of(vertices, faces))
    copied += _shared(work.faces, label, rough)
    steps: tuple[Step, ...] = ()
    if copied:
        what = f"took vertices apart at which pieces only touch ({copied} copies)"
        steps = (Step(Rung.SPLIT, what, seconds=process_time() - clock),)
    return work.after(*steps, faces=work.faces[rest], shells=tuple(shells))


def _shared(faces: IntArray, label: IntArray, rough: np.ndarray) -> int:
    """How many more vertices components have on their own than together."""
    smooth = ~rough[label]
    if not smooth.any():
        return 0
    own = np.repeat(label[smooth], 3) * np.int64(faces.max() + 1) + faces[smooth].ravel()
    return len(distinct(own)) - len(distinct(faces[smooth]))


def halved(work: Work) -> tuple[IntArray, IntArray]:
    """The faces in components all of whose edges have an even number of faces, and the others."""
    if not len(work.faces):
        return work.faces, work.faces
    edges = Edges.of(work.faces, len(work.vertices))
    number, label = face_components(edges)
    odd = np.zeros(number, dtype=bool)
    odd[label[edges.order[edges.first[np.flatnonzero(edges.count % 2)]] // 3]] = True
    return work.faces[~odd[label]], work.faces[odd[label]]


def wound(work: Work, job: Job) -> Work:
    """Rung: neighbouring faces wind the same way."""
    clock = process_time()
    faces, flipped, one_sided = wind_consistently(work.vertices, work.faces)
    if not flipped:
        return work
    what = f"turned {counted(flipped, 'face')} to agree with their neighbours"
    if one_sided:
        what += f"; {one_sided} patches are one-sided"
    return work.after(Step(Rung.ORIENT, what, seconds=process_time() - clock), faces=faces)


def stitched(work: Work, job: Job) -> Work:
    """Rung: boundaries that nearly meet are joined, tightest tolerance first."""
    clock = process_time()
    vertices, faces = work.vertices, work.faces
    left = boundary_length(vertices, faces)
    welded = inserted = 0
    moved = 0.0
    lost = work.lost
    for tolerance in _STITCHES:
        if left == 0.0 or tolerance > job.budget:
            break
        for join in (weld_boundary, insert_junctions, weld_boundary):
            job.deadline.check()
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
                lost = stacked(lost, tried.dropped)
    if not welded and not inserted:
        return work
    metres = moved * job.frame.scale
    joined = [f"{welded} boundary vertices"] * (welded > 0)
    joined += [counted(inserted, "T-junction")] * (inserted > 0)
    step = Step(
        Rung.STITCH,
        f"joined {' and '.join(joined)}, moving them at most {metres:.3g} m",
        moved=metres,
        volume_change=None,
        seconds=process_time() - clock,
    )
    moved += work.displacement
    # Faces that nearly were the same are the same now.
    faces = one_of_each(faces)
    return work.after(step, vertices=vertices, faces=faces, lost=lost, displacement=moved)
