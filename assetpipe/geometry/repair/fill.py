"""The rung that closes openings by caps.

The surface is first paired over its edges (see :mod:`split`), so that every opening is a
simple loop and a capped piece is closed by construction, even where loops touch.
"""

from __future__ import annotations

from dataclasses import dataclass
from time import process_time

import numpy as np

from assetpipe.geometry.health.topology import (
    Edges,
    boundary_loops,
    components,
    face_areas,
    groups,
    umbrellas,
)
from assetpipe.geometry.health.weld import degenerate
from assetpipe.geometry.mesh import FloatArray, IntArray
from assetpipe.geometry.repair.deviation import RESOLUTION, farthest_each
from assetpipe.geometry.repair.holes import Opening, cap, opening_of
from assetpipe.geometry.repair.result import Rung, Step
from assetpipe.geometry.repair.split import pair_half_edges
from assetpipe.geometry.repair.unite import signed_volume
from assetpipe.geometry.repair.wording import counted
from assetpipe.geometry.repair.work import Job, Piece, Work, stacked
from assetpipe.geometry.strays import referenced

MINOR = 0.01
"""Share of a piece's area below which openings wider than the budget are closed, too: the
99th percentile of the deviation does not see them."""
_NO_FACES = np.zeros((0, 3), dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Capped:
    """A surface paired over its edges, with caps over its openings.

    Attributes:
        vertices: (n, 3), copied where umbrellas come apart.
        faces: (m, 3).
        source: (n,) the vertex each is a copy of.
        piece: (m,) connected piece of each face.
        pieces: how many.
        openings: all of them.
        owner: (k,) piece of each opening.
        caps: triangles over each opening.
        apart: (k,) bound on each cap's distance from the input's surface, units.
        areas: (k,) of the caps.
    """

    vertices: FloatArray
    faces: IntArray
    source: IntArray
    piece: IntArray
    pieces: int
    openings: tuple[Opening, ...]
    owner: IntArray
    caps: tuple[IntArray, ...]
    apart: FloatArray
    areas: FloatArray


def capped(vertices: FloatArray, faces: IntArray, job: Job) -> Capped:
    """Caps over all openings of a surface, measured."""
    first, second = pair_half_edges(vertices, Edges.of(faces, len(vertices)))
    number, corners = umbrellas(faces, first, second)
    source = np.zeros(number, dtype=np.int64)
    source[corners.ravel()] = faces.ravel()
    pieces, piece = components(len(faces), first // 3, second // 3)
    apart = vertices[source]
    loops = boundary_loops(corners, first, second)
    found = tuple(opening_of(apart, loop) for loop in loops)
    caps = []
    for opening in found:
        job.deadline.check()
        caps.append(cap(apart, opening))
    at = np.zeros(number, dtype=np.int64)
    at[corners.ravel()] = np.repeat(piece, 3)
    distance = farthest_each(
        job.surface,
        apart[np.concatenate([_NO_FACES, *caps])],
        np.repeat(np.arange(len(caps)), [len(own) for own in caps]),
        len(caps),
        side="surface",
        resolution=RESOLUTION,
        floor=job.budget / 4.0,
        ceiling=job.budget,
        deadline=job.deadline,
    )
    return Capped(
        apart,
        corners,
        source,
        piece,
        pieces,
        found,
        np.array([at[loop[0]] for loop in loops], dtype=np.int64),
        tuple(caps),
        distance,
        np.array([float(face_areas(apart, own)[0].sum()) for own in caps]),
    )


def filled(work: Work, job: Job) -> Work:
    """Rung: openings closed by caps that stay near the surface, or are minor."""
    if not len(work.faces):
        return work
    clock = process_time()
    trial = capped(work.vertices, work.faces, job)
    area = np.bincount(trial.piece, face_areas(trial.vertices, trial.faces)[0], trial.pieces)
    pieces: list[Piece] = []
    taken: list[int] = []
    for k, chosen in enumerate(groups(trial.piece, trial.pieces)):
        job.deadline.check()
        own = np.flatnonzero(trial.owner == k)
        wanted = own[_acceptable(trial.apart[own], trial.areas[own], float(area[k]), job)]
        whole = np.concatenate([trial.faces[chosen], *(trial.caps[i] for i in wanted)])
        closed = len(wanted) == len(own)
        if closed and len(own) and _is_thin(trial.vertices, whole, job):
            whole, wanted, closed = trial.faces[chosen], wanted[:0], False
        taken += wanted.tolist()
        whole = np.delete(whole, degenerate(whole), axis=0)
        pieces.append(Piece(*referenced(trial.vertices, whole), closed))
    work = work.after(pieces=tuple(pieces))
    if not taken:
        return work
    caps = np.concatenate([trial.caps[i] for i in taken])
    widest = max(trial.openings[i].width for i in taken) * job.frame.scale
    step = Step(
        Rung.FILL,
        f"closed {counted(len(taken), 'opening')}, the widest {widest:.4g} m",
        moved=float(trial.apart[taken].max()) * job.frame.scale,
        volume_change=None,
        seconds=process_time() - clock,
    )
    named = trial.source[caps]
    named = np.delete(named, degenerate(named), axis=0)
    return work.after(
        step,
        faces=np.concatenate([work.faces, named]),
        fresh=stacked(work.fresh, trial.vertices[caps]),
    )


def _acceptable(apart: FloatArray, areas: FloatArray, area: float, job: Job) -> IntArray:
    """Which openings of a piece of that area to close."""
    wide = apart > job.budget
    if job.policy.openings == "fill":
        return np.arange(len(apart))
    if job.policy.openings == "auto" and float(areas[wide].sum()) <= MINOR * area:
        return np.arange(len(apart))
    return np.flatnonzero(~wide)


def _is_thin(vertices: FloatArray, faces: IntArray, job: Job) -> bool:
    """Whether closed faces are no body but a sheet and its cap."""
    area = float(face_areas(vertices, faces)[0].sum())
    return abs(signed_volume(vertices, faces)) < area / 2.0 * job.thickness / 4.0
