"""How far a repair moved the surface, told by bounds."""

from __future__ import annotations

import numpy as np

from assetpipe.geometry.health.topology import BoolArray, unit_normals
from assetpipe.geometry.health.weld import degenerate
from assetpipe.geometry.mesh import Mesh
from assetpipe.geometry.repair.deadline import Deadline
from assetpipe.geometry.repair.deviation import RESOLUTION, Side, farthest, quantile, sample
from assetpipe.geometry.repair.pieces import quarters
from assetpipe.geometry.repair.result import Deviation
from assetpipe.geometry.repair.surface import Corners, Surface
from assetpipe.geometry.repair.unite import United
from assetpipe.geometry.repair.within import whole
from assetpipe.geometry.repair.work import Job, Work

_ROUNDING = 1e-11
"""Units below which a measured distance is rounding of the measurement."""
_SHARP = 1e-8
"""Units by which bounds on what a union did may be too large."""
_FINE = 2e-5
"""The same, where it is not known what the surface divides."""
_QUARTERINGS = 3
_FEW = 100
"""Triangles that are looked at so closely."""
_POINTS = 4000
_ASIDE = 1e-6
"""Units next to the surface where the two sides of it are told apart."""


def moved_by_union(united: United, deadline: Deadline) -> tuple[float, float]:
    """(removed, added): bounds, in units, on how far a union moved the surface of its shells.

    manifold3d joins shells exactly that do not cross themselves. What it makes of others, and
    of faces that all but coincide, only shows when it is measured.
    """
    if not len(united.gone) and not len(united.put):
        return 0.0, 0.0
    removed = _left_out(Surface(united.vertices, united.faces), united.gone, deadline)
    shells = Surface(*united.taken)
    added = farthest(shells, united.put, side="surface", resolution=_SHARP, deadline=deadline)
    return (removed if removed > _ROUNDING else 0.0), (added if added > _ROUNDING else 0.0)


def _left_out(solid: Surface, corners: Corners, deadline: Deadline) -> float:
    """Upper bound on how far any point of triangles is outside a solid.

    Those that its surface divides are quartered, so that fewer parts of them are divided.
    """

    def bound(parts: Corners, resolution: float, undivided: BoolArray | None = None) -> float:
        return farthest(
            solid, parts, side="solid", resolution=resolution, whole=undivided, deadline=deadline
        )

    result = 0.0
    for _ in range(_QUARTERINGS):
        if not len(corners):
            return result
        deadline.check()
        undivided = whole(corners, solid.vertices, solid.faces)
        sharp = bound(corners[undivided], _SHARP, undivided[undivided])
        result = max(result, sharp)
        corners = corners[~undivided]
        if len(corners) > _FEW:
            break
        corners = quarters(corners)
    rest = bound(corners, RESOLUTION)
    if result < rest and len(corners) <= 4 * _FEW:
        # The finer resolution can run out of triangles: then the other one is better.
        rest = min(rest, bound(corners, _FINE))
    return max(result, rest)


def measured(work: Work, job: Job, solid: Mesh) -> Deviation:
    """Bounds from what was moved, added and given up; the rest of the surface stayed.

    The percentiles are of the surfaces as they are, not of the bounds.
    """
    fresh, lost = work.fresh, work.lost
    if (
        work.displacement == work.beside == work.dropped == work.grown == 0.0
        and not len(fresh)
        and not len(lost)
    ):
        return Deviation()
    scale = job.frame.scale
    after = Surface(job.frame.inward(solid.vertices), solid.faces)

    def bound(target: Surface, corners: Corners, side: Side, floor: float) -> float:
        undivided = None
        if side == "solid":
            undivided = whole(corners, target.vertices, target.faces)
        return farthest(
            target,
            corners,
            side=side,
            resolution=RESOLUTION,
            floor=max(job.budget / 10.0, floor),
            whole=undivided,
            deadline=job.deadline,
        )

    # What was put beside lies about that far away: no need to know the rest more sharply.
    added = max(bound(job.surface, fresh, "surface", work.beside), work.beside)
    removed = max(bound(after, lost, "solid", work.dropped), work.dropped)
    added, removed = added + work.grown + work.displacement, removed + work.displacement
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


def strays(deviation: Deviation, job: Job, solid: Mesh) -> bool:
    """Whether more than a hundredth of either surface is farther than the budget from the other.

    A part of the input that bounds nothing, as a lid without thickness over a pocket, may go.
    """
    budget = job.budget * job.frame.scale
    if deviation.p99 <= budget or deviation.added_p99 > budget:
        return deviation.p99 > budget
    points = sample(job.surface.vertices, job.surface.faces, _POINTS)
    after = Surface(job.frame.inward(solid.vertices), solid.faces)
    points = points[after.outside(points) > job.budget]
    face = job.surface.closest(points)[1]
    aside = _ASIDE * unit_normals(job.surface.vertices, job.surface.faces)[face]
    jump = job.surface.exact_winding(points + aside) - job.surface.exact_winding(points - aside)
    return int(np.count_nonzero(np.abs(jump) > 0.5)) > _POINTS / 100.0
