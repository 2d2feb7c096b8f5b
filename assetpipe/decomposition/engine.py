"""``decompose``: a mesh in, certified convex hulls out."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from assetpipe.decomposition.certificate import Certificate, Interval
from assetpipe.decomposition.decomposition import Coverage, Decomposition, Node
from assetpipe.decomposition.hull import Hull
from assetpipe.decomposition.params import (
    CAVITIES,
    EFFORTS,
    METRICS,
    Cavities,
    Effort,
    Metric,
    Params,
)
from assetpipe.decomposition.reach import check_reach, close_unreachable
from assetpipe.decomposition.shaping import Shapes, check_shaping, shaped
from assetpipe.decomposition.tolerance import Tolerance
from assetpipe.errors import LimitError, MeshError, UsageError, unknown_name
from assetpipe.geometry.mesh import FloatArray, Mesh

if TYPE_CHECKING:
    import trimesh

    from assetpipe.geometry import Repaired

    Source = Mesh | Repaired | trimesh.Trimesh | tuple[Any, Any]

_THIN = 1e-9
"""Share of the cube of the diagonal below which a volume may be rounding."""
OnProgress = Callable[[float], object]

_SETTINGS: dict[Effort, dict[str, str | float]] = {
    "fast": {"policy": "greedy", "ways": "", "planes": 14, "samples": 1000},
    "balanced": {},
    "best": {"ways": "3,3,3", "gap": 0.004, "cells": 200000},
}
# Forbidden space is measured towards the whole solid: of what a part is refused for it foresees
# less. A second step makes up for it, and a first cut in two ways.
_POLICY: dict[Metric, dict[str, str]] = {
    "thickening": {},
    "concavity": {"policy": "lookahead", "ways": "2"},
}


def decompose(
    mesh: Source,
    tolerance: Tolerance | float | str,
    *,
    metric: Metric = "thickening",
    effort: Effort = "balanced",
    seed: int = 0,
    threads: int | None = None,
    max_hulls: int | None = None,
    max_hull_vertices: int | None = None,
    cavities: Cavities = "keep",
    reach: float = 0.0,
    shapes: Shapes = "hulls",
    overlap: float = 0.0,
    on_progress: OnProgress | None = None,
    params: Params | None = None,
) -> Decomposition:
    """Cover a solid with few convex hulls that thicken it by at most a tolerance.

    Args:
        mesh: a Mesh, a ``trimesh.Trimesh`` or a pair (vertices (n, 3), faces (m, 3)) in
            metres. A mesh that is no closed solid is repaired first; ``repair`` of the
            result says how and how far the surface moved. What :func:`repair` made of a
            mesh is taken as it is.
        tolerance: metres, a text such as ``"2mm"`` or ``"1%"``, or a :class:`Tolerance`.
        metric: what is held below the tolerance: ``"thickening"``, towards the whole
            solid, or ``"concavity"`` (Wei et al. 2022, Eq. 4), towards the part.
        effort: how long to search.
        seed: what Monte Carlo tree search draws from (``Params({"policy": "mcts"})``). No
            ``effort`` uses it, so without that the seed has no influence.
        threads: at most so many threads; ``None``: all cores. No influence on the result.
        max_hulls: budget; met by merging outwards, the certificate tells the price.
        max_hull_vertices: budget a hull; met by simplifying outwards, likewise.
        cavities: ``"fill"`` closes enclosed voids first; ``"keep"`` leaves them.
        reach: metres; space that no ball of this radius can enter from outside counts as
            solid, and certificates are towards the solid so closed; 0 closes nothing.
            ``closed`` of the result tells what it was: nothing where that saves no hull.
        shapes: ``"primitives"`` replaces hulls by boxes, cylinders and spheres that enclose
            them where these are proved to stay within the tolerance, as
            ``"primitives_and_capsules"`` does by capsules too; see :attr:`Hull.primitive`.
        overlap: metres by which neighbouring hulls overlap across their seams, as far as that
            is proved to stay within the tolerance; ``seams`` of the result counts.
        on_progress: called with the share done (0 to 1), about thirty times a second;
            returning ``False`` or raising stops the work.
        params: parameters of the search, for experiments.

    Returns:
        The decomposition; every hull's certificate is a proof, not a sample.

    Raises:
        UsageError: an unknown name or an impossible number.
        MeshError: the mesh encloses no volume or cannot be made a solid.
        LimitError: more parts than the engine allows, a reach too small for the mesh, or
            coordinates beyond those that volumes can be computed of.
        CancelledError: ``on_progress`` returned ``False``.
    """
    from assetpipe import _core

    _check(metric, effort, cavities)
    check_reach(reach)
    check_shaping(shapes, overlap, metric)
    if max_hull_vertices is not None and max_hull_vertices < 4:
        raise UsageError(f"max_hull_vertices must be at least 4, not {max_hull_vertices}")
    if max_hulls is not None and max_hulls < 1:
        raise UsageError(f"max_hulls must be at least 1, not {max_hulls}")
    if threads is not None and threads < 1:
        raise UsageError(f"threads must be at least 1, not {threads}")
    wanted = Tolerance.parse(tolerance)
    solid, repaired = as_solid(mesh, cavities)
    epsilon = wanted.on(solid)
    given, closing = solid, None
    if reach > 0.0:
        closed = close_unreachable(solid, reach, threads=threads, on_progress=on_progress)
        solid, closing = closed.solid, closed.closing
    settings: dict[str, str | float] = {
        **_POLICY[metric],
        **_SETTINGS[effort],
        "metric": metric,
        "most_vertices": max_hull_vertices or 0,
        "seed": seed,
        # Shapes fit hulls as they are; those that stay hulls are slimmed afterwards.
        **({} if shapes == "hulls" else {"slim": 0.0}),
        **(params.search if params else {}),
    }

    def search(body: Mesh) -> tuple[tuple[Node, ...], int]:
        found, leaves = _core.decompose(
            np.ascontiguousarray(body.vertices),
            np.ascontiguousarray(body.faces),
            epsilon,
            settings,
            threads or 0,
            on_progress,
        )
        return _nodes(found), leaves

    try:
        nodes, leaves = search(solid)
    except LimitError as error:
        raise _with_cause(error, repaired) from None
    if closing is not None and closing.pockets:
        # Mouths of pockets that are left open may cost more than pockets save.
        plain, count = search(given)
        if count <= leaves:
            solid, nodes, leaves, closing = given, plain, count, closing.undone()
    result = Decomposition(
        tuple(node.hull for node in nodes[:leaves]),
        Coverage("construction"),
        "assetpipe",
        wanted,
        epsilon,
        metric,
        repaired,
        nodes,
        given,
        closing,
        closed_solid=None if solid is given else solid,
    )
    if max_hulls is not None and len(result.hulls) > max_hulls:
        result = result.at(max_hulls=max_hulls)
    if shapes == "hulls" and overlap == 0.0:
        return result
    return shaped(
        result,
        solid,
        shapes=shapes,
        overlap=overlap,
        max_hull_vertices=max_hull_vertices,
        on_progress=on_progress,
    )


def _with_cause(error: LimitError, repaired: Repaired | None) -> LimitError:
    """The error, with what repair could not mend: it may need parts without end."""
    left = [f.message for f in repaired.findings if f.code == "AP209"] if repaired else []
    return LimitError("; ".join([error.message, *left])) if left else error


def _nodes(found: list[Any]) -> tuple[Node, ...]:
    """The engine's answer as values."""
    return tuple(
        Node(
            Hull(
                vertices,
                faces,
                volume,
                Certificate(Interval(*thickening), Interval(*concavity) if concavity else None),
            ),
            children,
        )
        for vertices, faces, volume, thickening, concavity, children in found
    )


def _check(metric: str, effort: str, cavities: str) -> None:
    for kind, name, known in (
        ("metric", metric, METRICS),
        ("effort", effort, EFFORTS),
        ("cavities", cavities, CAVITIES),
    ):
        if name not in known:
            raise UsageError(unknown_name(kind, name, known))


def as_solid(mesh: Source, cavities: Cavities) -> tuple[Mesh, Repaired | None]:
    """The mesh itself if it is a closed solid without folds, otherwise repaired.

    What repair has made already is not repaired again.

    Raises:
        MeshError: it cannot be made a solid.
        LimitError: coordinates beyond those that volumes can be computed of.
    """
    from assetpipe.geometry import Repaired, RepairPolicy, repair

    if isinstance(mesh, Repaired):
        return _solid_of(mesh), mesh if mesh.steps or mesh.findings else None
    mesh = Mesh.of(mesh).without_strays()
    if not len(mesh.faces):
        raise MeshError("the mesh has no faces")
    mesh.check_size()
    if cavities == "keep" and _is_solid(mesh):
        return mesh, None
    repaired = repair(mesh, policy=RepairPolicy(cavities=cavities))
    solid = _solid_of(repaired)
    return (solid, repaired) if repaired.steps or repaired.findings else (mesh, None)


def _solid_of(repaired: Repaired) -> Mesh:
    if repaired.solid is None:
        reasons = "; ".join(finding.message for finding in repaired.findings)
        raise MeshError(f"the mesh cannot be made a solid: {reasons or 'no rung of repair did'}")
    return repaired.solid


def _is_solid(mesh: Mesh) -> bool:
    """Whether a mesh can be taken as it is; where it is not clear, repair tells."""
    from assetpipe import _core
    from assetpipe.geometry.repair.overlap import components_disagree

    closed, edges, component, folds = _core.connections(mesh.vertices, mesh.faces)
    return (
        closed
        and not folds
        and mesh.volume > _THIN * mesh.diagonal**3
        and not _repeats_faces(mesh, edges)
        and not components_disagree(mesh, component)
    )


def is_closed(mesh: Mesh) -> bool:
    """Whether every edge is used as often in one sense as in the other."""
    from assetpipe import _core

    return _core.connections(mesh.vertices, mesh.faces)[0]


def _repeats_faces(mesh: Mesh, edges: int) -> bool:
    """Whether a face stands in the mesh twice, from whichever side: such shells are closed,
    but tell neither what is inside nor which cavity belongs to which body."""
    if 2 * edges == 3 * len(mesh.faces) and _are_apart(mesh.vertices):
        return False
    from assetpipe.geometry.repair.clean import same_corners, weld_exactly

    welded = weld_exactly(mesh.vertices, mesh.faces)
    return welded.repeated > 0 or same_corners(welded.faces)[1] < len(welded.faces)


def _are_apart(points: FloatArray) -> bool:
    """Whether no two points coincide, seen by one number that most points have for themselves;
    False may be a mistake."""
    number = points[:, 0] + points[:, 1] * 1.6180339887498949 + points[:, 2] * 2.718281828459045
    number.sort()
    return bool((number[1:] != number[:-1]).all())
