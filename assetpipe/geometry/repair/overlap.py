"""A closed shell that overlaps itself, made one that does not.

manifold3d unites *different* solids; a shell that overlaps itself has to be cut into such
first. Cut by planes in halves, again and again, until what overlaps has come into
different components, then put together.
"""

from __future__ import annotations

from time import process_time
from typing import Any

import numpy as np
import numpy.typing as npt

from assetpipe.geometry.health.topology import face_areas
from assetpipe.geometry.mesh import FloatArray, IntArray, Mesh
from assetpipe.geometry.products import added, products
from assetpipe.geometry.repair.deadline import NEVER, Deadline
from assetpipe.geometry.repair.frame import Frame
from assetpipe.geometry.repair.result import Rung, Step
from assetpipe.geometry.repair.surface import Surface
from assetpipe.geometry.repair.unite import Shell, arrays_of, manifold_of, shells_of, unite
from assetpipe.geometry.repair.work import Job, Work, stacked

_POINTS = 256
_ASIDE = 7.7e-6
_SURE = 32
_DEPTH = 5
_TRIED = 3
_HOPELESS = 0.7
"""Where three halvings leave more than this share of the overlap, two more do not help."""
_ON_PLANE = 1e-9
TANGLED = 5e-3
"""Share of the area that may lie inside the shell itself."""


def disentangled(work: Work, job: Job) -> Work:
    """Rung: shells that overlap themselves enclose everything once."""
    clock = process_time()
    shells: list[Shell] = []
    done, left = 0, 0
    change = 0.0
    fresh, lost = [work.fresh], [work.lost]
    for shell in work.shells:
        job.deadline.check()
        if overlap(shell) <= TANGLED:
            shells.append(shell)
            continue
        outward = shell if shell.volume > 0.0 else shell.reversed()
        parts = untangled(outward, job.deadline)
        lost.append(shell.vertices[shell.faces])
        fresh += [part.vertices[part.faces] for part in parts or [shell]]
        if parts is None:
            shells.append(shell)
            left += 1
            continue
        done += 1
        change += added(part.volume for part in parts) - outward.volume
        shells += parts if shell.volume > 0.0 else [part.reversed() for part in parts]
    notes = (f"{left} pieces overlap themselves; where they do, they enclose twice",) * (left > 0)
    if not done and not left:
        return work
    work = work.after(notes=work.notes + notes, fresh=stacked(*fresh), lost=stacked(*lost))
    if not done:
        return work
    step = Step(
        Rung.UNTANGLE,
        f"made {done} pieces that overlapped themselves enclose everything once",
        volume_change=change * job.frame.scale**3,
        seconds=process_time() - clock,
    )
    return work.after(step, shells=tuple(shells))


def overlap(shell: Shell) -> float:
    """Share of a shell's area next to which it encloses twice or inside-out (fixed sample).

    The winding number of a sound shell that faces outward is one below its surface and
    zero above. Thin walls and gaps exchange the two and are no fault; two or more below,
    or less than zero above, are.
    """
    import igl

    areas, normals = face_areas(shell.vertices, shell.faces)
    total = areas.cumsum()
    places = (np.arange(_POINTS) + 0.5) / _POINTS * total[-1]
    face = np.minimum(np.searchsorted(total, places), len(areas) - 1)
    unit = normals[face] / np.maximum(2.0 * areas[face], np.finfo(float).tiny)[:, None]
    centres = shell.vertices[shell.faces[face]].mean(axis=1)
    sense = np.sign(shell.volume)
    aside = sense * _ASIDE * unit
    surface = Surface(shell.vertices, shell.faces)
    points = np.concatenate([centres - aside, centres + aside])
    suspect = np.flatnonzero(_wrong(sense * surface.winding(points)))
    if len(suspect) <= TANGLED * _POINTS:
        return len(suspect) / _POINTS
    # Fast winding numbers are wrong next to needles: look again, exactly, at some.
    chosen = suspect[:: max(1, len(suspect) // _SURE)]
    exact = igl.winding_number(shell.vertices, shell.faces, points[chosen])
    below = chosen < _POINTS
    sure = np.where(below, sense * exact > 1.5, sense * exact < -0.5)
    return float(np.mean(sure)) * len(suspect) / _POINTS


def components_disagree(mesh: Mesh, label: IntArray) -> bool:
    """Whether components of a closed mesh, told by (m,) ``label``, overlap each other or lie
    inside-out in the open.

    Of the first it knows by samples, :func:`overlap`, of the second by the winding number
    within every component that faces inward.
    """
    number = int(label.max()) + 1
    if number == 1:
        return False
    import igl

    units = Frame.around(mesh.vertices).inward(mesh.vertices)
    a, b, c = (units[mesh.faces[:, k]] for k in range(3))
    inward = np.bincount(label, products(a, np.cross(b, c)), number) < 0.0
    areas, normals = face_areas(units, mesh.faces)
    order = np.lexsort((-areas, label))
    largest = order[np.searchsorted(label[order], np.flatnonzero(inward))]
    unit = normals[largest] / np.maximum(2.0 * areas[largest], np.finfo(float).tiny)[:, None]
    within = units[mesh.faces[largest]].mean(axis=1) + _ASIDE * unit
    if (igl.winding_number(units, mesh.faces, within) < -0.5).any():
        return True
    return overlap(Shell.of(units, mesh.faces)) > TANGLED


def _wrong(winding: FloatArray) -> npt.NDArray[np.bool_]:
    """Which points, the first half below the surface and the others above, are at fault."""
    below, above = winding[:_POINTS] > 1.5, winding[_POINTS:] < -0.5
    return np.concatenate([below, above])


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
