"""The rung that takes a complex of faces apart into closed shells and open sheets.

Two ways are tried. *Cells* ignore how faces are wound and drop walls between material,
but leak where faces cross without a common edge. *Brackets* pair faces around edges by their
winding and always close what is passed as often each way, but twist where windings disagree.
The one that leaves less area in sheets and in shells that overlap themselves is taken.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from time import process_time

import numpy as np

from assetpipe.geometry.health.topology import (
    Edges,
    components,
    face_areas,
    face_components,
    groups,
    umbrellas,
)
from assetpipe.geometry.mesh import FloatArray, IntArray
from assetpipe.geometry.repair.cells import separate
from assetpipe.geometry.repair.deadline import NEVER, Deadline
from assetpipe.geometry.repair.overlap import overlap
from assetpipe.geometry.repair.result import Rung, Step
from assetpipe.geometry.repair.split import pair_half_edges, split_nonmanifold
from assetpipe.geometry.repair.surface import Surface
from assetpipe.geometry.repair.unite import (
    Shell,
    compared,
    manifold_of,
    put_together,
    shells_of,
)
from assetpipe.geometry.repair.wording import counted
from assetpipe.geometry.repair.work import Job, Patch, Piece, Work
from assetpipe.geometry.strays import referenced

_FLAT = 1e-9
_FAR = 1e-3
_WORSE = 20.0
"""How much worse distorted area is than area in sheets, which stay where they are."""


@dataclass(frozen=True, eq=False)
class Divided:
    """A complex taken apart.

    Attributes:
        shells: closed pieces.
        sheets: open ones, closed ones that enclose nothing, and walls between material.
        fault: area of sheets other than walls between material, of what overlaps itself, and
            of what a union would distort.
    """

    shells: tuple[Shell, ...]
    sheets: tuple[Patch, ...]
    fault: float


def divided(work: Work, faces: IntArray, job: Job) -> Work:
    """Rung: a complex of faces divided into shells and sheets.

    ``work.pieces`` are the same faces paired by winding; if there are none, they are found.
    """
    if not len(faces):
        return work
    clock = process_time()
    parts = by_cells(work.vertices, faces, job.deadline)
    if parts.fault > 0.0:
        job.deadline.check()
        pieces = work.pieces or paired(work.vertices, faces)
        parts = min(parts, by_brackets(pieces, job.deadline), key=lambda p: p.fault)
    steps: tuple[Step, ...] = ()
    if parts.shells:
        shells = counted(len(parts.shells), "shell")
        what = f"took {len(faces)} faces at irregular edges apart into {shells}"
        steps = (Step(Rung.SPLIT, what, seconds=process_time() - clock),)
    return work.after(
        *steps,
        shells=work.shells + parts.shells,
        patches=work.patches + parts.sheets,
        pieces=(),
    )


def by_cells(vertices: FloatArray, faces: IntArray, deadline: Deadline = NEVER) -> Divided:
    """Divide by cells of space, see :mod:`cells`."""
    parts = separate(vertices, faces)
    shells: list[Shell] = []
    if len(parts.skin):
        shells = shells_of(*split_nonmanifold(*referenced(vertices, parts.skin))[:2])
    result = _divided(shells, connected(vertices, parts.sheets), deadline)
    if not len(parts.inner):
        return result
    # Cells that leak may put faces inside which are not: these are at fault, too. Whether
    # the others are wholly inside is for the next rung to prove.
    inner = connected(vertices, parts.inner)
    outside = sum(_area(patch) for patch in inner)
    if shells:
        solid = Surface(*put_together([shell.outward for shell in shells]))
        below = np.abs(solid.winding(vertices[parts.inner].mean(axis=1))) > 0.5
        outside -= float(face_areas(vertices, parts.inner[below])[0].sum())
    fault = result.fault + outside
    if fault <= _FLAT * sum(_area(shell) for shell in shells):
        fault = 0.0
    return replace(result, sheets=result.sheets + tuple(inner), fault=fault)


def connected(vertices: FloatArray, faces: IntArray) -> list[Patch]:
    """Faces by edge-connected component."""
    if not len(faces):
        return []
    number, label = face_components(Edges.of(faces, len(vertices)))
    return [Patch(*referenced(vertices, faces[chosen])) for chosen in groups(label, number)]


def by_brackets(pieces: tuple[Piece, ...], deadline: Deadline = NEVER) -> Divided:
    """Divide by winding: pieces that are closed are shells."""
    shells: list[Shell] = []
    for piece in pieces:
        if piece.closed:
            shells += shells_of(*split_nonmanifold(piece.vertices, piece.faces)[:2])
    return _divided(shells, [Patch(p.vertices, p.faces) for p in pieces if not p.closed], deadline)


def paired(vertices: FloatArray, faces: IntArray) -> tuple[Piece, ...]:
    """The pieces of a closed complex, see :mod:`split`."""
    first, second = pair_half_edges(vertices, Edges.of(faces, len(vertices)))
    number, corners = umbrellas(faces, first, second)
    source = np.zeros(number, dtype=np.int64)
    source[corners.ravel()] = faces.ravel()
    pieces, label = components(len(faces), first // 3, second // 3)
    alone = np.ones(faces.size, dtype=bool)
    alone[first] = alone[second] = False
    is_open = np.zeros(pieces, dtype=bool)
    is_open[label[np.flatnonzero(alone) // 3]] = True
    return tuple(
        Piece(*referenced(vertices[source], corners[chosen]), not is_open[k])
        for k, chosen in enumerate(groups(label, pieces))
    )


def _divided(shells: list[Shell], sheets: list[Patch], deadline: Deadline) -> Divided:
    bodies = [shell for shell in shells if not enclosing_nothing(shell)]
    sheets = sheets + [Patch(s.vertices, s.faces) for s in shells if enclosing_nothing(s)]
    fault = sum(_area(sheet) for sheet in sheets)
    for shell in bodies:
        deadline.check()
        fault += _area(shell) * overlap(shell) + _WORSE * _distorted(shell)
    return Divided(tuple(bodies), tuple(sheets), fault)


def _area(piece: Shell | Patch) -> float:
    return float(face_areas(piece.vertices, piece.faces)[0].sum())


def _distorted(shell: Shell) -> float:
    """Area that a union would put far from the shell, because it is folded onto itself."""
    solid = manifold_of(shell.vertices, shell.faces)
    if solid is None:
        return _area(shell)
    tidied = compared(solid, (shell.vertices, shell.faces))
    areas = 0.0
    for target, triangles in (
        (Surface(*tidied.taken), tidied.put),
        (Surface(tidied.vertices, tidied.faces), tidied.gone),
    ):
        far = target.distance(triangles.mean(axis=1)) > _FAR
        normals = np.cross(
            triangles[far, 1] - triangles[far, 0], triangles[far, 2] - triangles[far, 0]
        )
        areas += float(np.linalg.norm(normals, axis=1).sum()) / 2.0
    return areas


def enclosing_nothing(shell: Shell) -> bool:
    """Whether a closed shell is two sides of one sheet."""
    return abs(shell.volume) <= _FLAT * _area(shell)


def flattened(work: Work, job: Job) -> Work:
    """Closed shells that enclose nothing become patches: two sides of one sheet."""
    bodies = tuple(shell for shell in work.shells if not enclosing_nothing(shell))
    if len(bodies) == len(work.shells):
        return work
    patches = [Patch(s.vertices, s.faces) for s in work.shells if enclosing_nothing(s)]
    return work.after(shells=bodies, patches=(*work.patches, *patches))
