"""A closed shell that overlaps itself, made one that does not.

manifold3d unites *different* solids; a shell that overlaps itself has to be cut into such
first. Cut by planes in halves, again and again, until what overlaps has come into
different components, then put together.
"""

from __future__ import annotations

from time import process_time
from typing import Any

import numpy as np

from assetpipe.findings import Finding, Severity
from assetpipe.geometry.health.topology import face_areas, unit_normals
from assetpipe.geometry.mesh import FloatArray, IntArray, Mesh
from assetpipe.geometry.products import added, products
from assetpipe.geometry.repair.deadline import NEVER, Deadline
from assetpipe.geometry.repair.deviation import RESOLUTION, farthest, sample
from assetpipe.geometry.repair.frame import Frame
from assetpipe.geometry.repair.result import Rung, Step
from assetpipe.geometry.repair.rows import as_rows
from assetpipe.geometry.repair.surface import Surface
from assetpipe.geometry.repair.unite import (
    Shell,
    arrays_of,
    manifold_of,
    put_together,
    shells_of,
    unite,
)
from assetpipe.geometry.repair.winding import CELL, solid_of_soup
from assetpipe.geometry.repair.wording import counted
from assetpipe.geometry.repair.work import Job, Patch, Work, stacked

_POINTS = 256
_ASIDE = 7.7e-6
_DEPTH = 5
_TRIED = 3
_HOPELESS = 0.7
"""Where three halvings leave more than this share of the overlap, two more do not help."""
_ON_PLANE = 1e-9
_MANY = 20_000
_INVERTED = 0.01
"""Share of a shell that may be lost, because it encloses inside-out."""
TANGLED = 5e-3
"""Share of the area that may lie inside the shell itself."""


def disentangled(work: Work, job: Job) -> Work:
    """Rung: shells that overlap themselves enclose everything once."""
    clock = process_time()
    shells: list[Shell] = []
    done, left = 0, 0
    change, area, tangled = 0.0, 0.0, 0.0
    hollow: list[Patch] = []
    fresh, lost = [work.fresh], [work.lost]
    for shell in work.shells:
        job.deadline.check()
        shares = overlaps(shell)
        if sum(shares) <= TANGLED:
            shells.append(shell)
            continue
        # What is enclosed inside-out is lost, whether the shell is made another or stays.
        lost.append(shell.vertices[shell.faces])
        outward = shell.outward
        parts = untangled(outward, job.deadline)
        if parts is None or _strays(parts, outward, job):
            parts = by_winding(outward, job) if shares[0] > TANGLED else None
        if parts is None:
            if _lost(outward, job.budget) > _INVERTED:
                hollow.append(Patch(shell.vertices, shell.faces))
                continue
            shells.append(shell)
            left += 1
            area, tangled = area + _area(shell), tangled + sum(shares) * _area(shell)
            continue
        fresh += [part.vertices[part.faces] for part in parts]
        done += 1
        change += added(part.volume for part in parts) - outward.volume
        shells += parts if shell.volume >= 0.0 else [part.reversed() for part in parts]
    if not done and not left and not hollow:
        return work
    work = work.after(fresh=stacked(*fresh), lost=stacked(*lost), shells=tuple(shells))
    if left:
        where = f"{_overlapping(left)} along {tangled / area:.1%} of the area"
        work = work.after(findings=(Finding("AP209", Severity.WARNING, where),))
    if hollow:
        work = work.after(findings=(_inverted(len(hollow)),), patches=(*work.patches, *hollow))
    if not done:
        return work
    step = Step(
        Rung.UNTANGLE,
        f"made {counted(done, 'piece')} that overlapped themselves enclose everything once",
        volume_change=change * job.frame.scale**3,
        seconds=process_time() - clock,
    )
    return work.after(step)


def by_winding(shell: Shell, job: Job) -> list[Shell] | None:
    """All that a shell goes around, whichever way, as a body by winding number.

    ``None`` if that would lie farther from it than the budget.
    """
    body = solid_of_soup(
        shell.vertices, shell.faces, CELL, job.limits.cells, job.deadline, sense="either"
    )
    parts = None if body is None else shells_of(*body)
    return None if parts is None or _strays(parts, shell, job) else parts


def _strays(parts: list[Shell], shell: Shell, job: Job) -> bool:
    """Whether what was made of a shell lies farther from it than the budget, either way."""
    made = Surface(*put_together(parts))
    budget, deadline = job.budget, job.deadline
    removed = farthest(
        made,
        shell.vertices[shell.faces],
        side="solid",
        resolution=RESOLUTION,
        floor=budget,
        deadline=deadline,
    )
    added = farthest(
        Surface(shell.vertices, shell.faces),
        made.vertices[made.faces],
        side="surface",
        resolution=RESOLUTION,
        floor=budget,
        deadline=deadline,
    )
    return max(removed, added) > budget


def _area(shell: Shell) -> float:
    return float(face_areas(shell.vertices, shell.faces)[0].sum())


def _lost(shell: Shell, budget: float) -> float:
    """Share of a shell's area that is farther than the budget from what it encloses outward.

    Where it goes around inside-out it bounds no solid; near to some that it does bound, that
    makes no difference. Told from points spread over the area.
    """
    from scipy.spatial import cKDTree

    points = sample(shell.vertices, shell.faces, _MANY)
    surface = Surface(shell.vertices, shell.faces)
    aside = _ASIDE * unit_normals(shell.vertices, shell.faces)[surface.closest(points)[1]]
    bounds = (surface.turns(points - aside) > 0) | (surface.turns(points + aside) > 0)
    if not bounds.any():
        return 1.0
    away = cKDTree(points[bounds]).query(points[~bounds])[0]
    return float(np.count_nonzero(away > budget)) / len(points)


def _overlapping(pieces: int) -> str:
    return "1 piece overlaps itself" if pieces == 1 else f"{pieces} pieces overlap themselves"


def _inverted(pieces: int) -> Finding:
    return Finding(
        "AP209",
        Severity.WARNING,
        f"{_overlapping(pieces)} and partly inside-out, so that nobody knows what is inside: "
        "the surface was given a thickness",
        hint="mend the mesh: it runs through itself",
    )


def overlap(shell: Shell) -> float:
    """Share of a shell's area next to which it encloses twice or inside-out (fixed sample)."""
    return sum(overlaps(shell))


def overlaps(shell: Shell) -> tuple[float, float]:
    """Shares of a shell's area next to which it encloses inside-out, and only twice.

    Known at 256 places spread over the area, the same for every order of the faces. The
    winding number of a sound shell that faces outward is one below its surface and zero
    above. Thin walls and gaps exchange the two and are no fault; two or more below,
    or less than zero above, are.
    """
    faces = shell.faces[_order(shell.vertices, shell.faces)]
    areas = face_areas(shell.vertices, faces)[0]
    total = areas.cumsum()
    places = (np.arange(_POINTS) + 0.5) / _POINTS * total[-1]
    face = np.minimum(np.searchsorted(total, places), len(areas) - 1)
    centres = shell.vertices[faces[face]].mean(axis=1)
    sense = 1 if shell.volume >= 0.0 else -1
    aside = sense * _ASIDE * unit_normals(shell.vertices, faces)[face]
    surface = Surface(shell.vertices, faces)
    below, above = (sense * surface.turns(centres + way * aside) for way in (-1.0, 1.0))
    inverted = above < 0
    return float(np.mean(inverted)), float(np.mean((below > 1) & ~inverted))


def _order(vertices: FloatArray, faces: IntArray) -> IntArray:
    """(m,) an order of faces that follows from their corners, whatever the order they have."""
    _, rank = np.unique(as_rows(vertices), return_inverse=True)
    low, middle, high = np.sort(rank.reshape(-1)[faces], axis=1).T
    order: IntArray = np.lexsort((high, middle, low))
    return order


def components_disagree(mesh: Mesh, label: IntArray) -> bool:
    """Whether components of a closed mesh, told by (m,) ``label``, overlap each other or
    themselves, or lie inside-out in the open.

    Of the first it knows by samples, :func:`overlap`, of the second by the winding number
    within every component that faces inward.
    """
    number = int(label.max()) + 1
    units = Frame.around(mesh.vertices).inward(mesh.vertices)
    if number > 1:
        order = _order(units, mesh.faces)
        faces, label = mesh.faces[order], label[order]
        a, b, c = (units[faces[:, k]] for k in range(3))
        inward = np.bincount(label, products(a, np.cross(b, c)), number) < 0.0
        order = np.lexsort((-face_areas(units, faces)[0], label))
        largest = order[np.searchsorted(label[order], np.flatnonzero(inward))]
        aside = _ASIDE * unit_normals(units, faces)[largest]
        within = units[faces[largest]].mean(axis=1) + aside
        if (Surface(units, faces).turns(within) < 0).any():
            return True
    return overlap(Shell.of(units, mesh.faces)) > TANGLED


def untangled(shell: Shell, deadline: Deadline = NEVER) -> list[Shell] | None:
    """The union of what an outward shell encloses; ``None`` if it does not come out sound.

    What it encloses twice or inside-out it encloses once afterwards.
    """
    solid = manifold_of(shell.vertices, shell.faces)
    if solid is None:
        return None
    low, high = shell.vertices.min(axis=0), shell.vertices.max(axis=0)
    before = overlap(shell)
    for depth in range(1, _DEPTH + 1):
        whole = _halved(solid, low, high, depth, deadline)
        if whole is None:
            return None
        parts = shells_of(*arrays_of(whole))
        left = max((overlap(part) for part in parts if part.volume > 0.0), default=0.0)
        if left <= TANGLED:
            return parts
        if depth >= _TRIED and left > _HOPELESS * before:
            return None
    return None


def _halved(
    solid: Any, low: FloatArray, high: FloatArray, depth: int, deadline: Deadline
) -> Any | None:
    """Cut along the longest side, make each half sound, and put them together."""
    deadline.check()
    if depth == 0:
        united = unite(tuple(shells_of(*arrays_of(solid))), "keep", deadline)
        return None if united is None else manifold_of(united.vertices, united.faces)
    axis = int(np.argmax(high - low))
    at = float(low[axis] + high[axis]) / 2.0
    normal = tuple(float(i == axis) for i in range(3))
    above, below = solid.split_by_plane(normal, at)
    middle_low, middle_high = low.copy(), high.copy()
    middle_low[axis] = middle_high[axis] = at
    halves = []
    for half, start, end in ((above, middle_low, high), (below, low, middle_high)):
        if half.is_empty():
            continue
        flat = _flattened(half, axis, at)
        sound = None if flat is None else _halved(flat, start, end, depth - 1, deadline)
        flat = None if sound is None else _flattened(sound, axis, at)
        if flat is None:
            return None
        halves.append(flat)
    return halves[0] + halves[1] if len(halves) == 2 else halves[0]


def _flattened(solid: Any, axis: int, at: float) -> Any | None:
    """Put vertices next to the cutting plane onto it, so that the halves fit together."""
    vertices, faces = arrays_of(solid)
    near = np.abs(vertices[:, axis] - at) < _ON_PLANE
    vertices[near, axis] = at
    return manifold_of(vertices, faces)
