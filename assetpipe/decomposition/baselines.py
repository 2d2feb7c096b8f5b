"""Other engines behind the same interface: CoACD, V-HACD and the plain hull.

Their hulls are certified by our own bounds, so all results are comparable.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, get_args

import numpy as np

from assetpipe.decomposition.certification import certify
from assetpipe.decomposition.decomposition import Coverage, Decomposition, EngineName
from assetpipe.decomposition.engine import as_solid, decompose
from assetpipe.decomposition.hull import Hull
from assetpipe.decomposition.reach import close_unreachable
from assetpipe.decomposition.shaping import check_shaping, shaped
from assetpipe.decomposition.tolerance import Tolerance
from assetpipe.errors import CancelledError, EngineError, MeshError, UsageError, unknown_name
from assetpipe.geometry.mesh import FloatArray, Mesh

ENGINES: tuple[EngineName, ...] = get_args(EngineName)
_SAMPLES = 4000


def decompose_with(
    engine: EngineName,
    mesh: Any,
    tolerance: Tolerance | float | str,
    **options: Any,
) -> Decomposition:
    """Decompose with a named engine.

    Args:
        engine: ``"assetpipe"``, ``"coacd"``, ``"vhacd"`` or ``"hull"``.
        mesh: as in :func:`decompose`.
        tolerance: as in :func:`decompose`. CoACD gets it in its own unit; V-HACD knows no
            length, its defaults are used and the certificate tells what came of it.
        **options: those of :func:`decompose`. The others use ``seed``, ``max_hulls``,
            ``max_hull_vertices``, ``cavities``, ``reach``, ``shapes``, ``overlap`` and
            ``on_progress`` where they can.

    Raises:
        UsageError: an unknown engine, or one that is not installed.
        EngineError: the engine failed.
    """
    if engine == "assetpipe":
        return decompose(mesh, tolerance, **options)
    if engine not in ENGINES:
        raise UsageError(unknown_name("engine", engine, ENGINES))
    wanted = Tolerance.parse(tolerance)
    solid, repaired = as_solid(mesh, options.get("cavities", "keep"))
    on_progress: Callable[[float], object] | None = options.get("on_progress")
    if on_progress is not None and on_progress(0.0) is False:
        raise CancelledError("cancelled")
    epsilon = wanted.on(solid)
    given, closing = solid, None
    if options.get("reach"):
        closed = close_unreachable(solid, options["reach"], on_progress=on_progress)
        solid, closing = closed.solid, closed.closing
    run = {"coacd": _coacd, "vhacd": _vhacd, "hull": _hull}[engine]
    parts = run(solid, wanted, options)
    hulls = _hulls(solid, parts, engine, on_progress)
    shapes, overlap = options.get("shapes", "hulls"), options.get("overlap", 0.0)
    check_shaping(shapes, overlap, "thickening")
    result = Decomposition(
        hulls,
        _coverage(solid, hulls),
        engine,
        wanted,
        epsilon,
        repair=repaired,
        solid=given,
        closed=closing,
        closed_solid=None if solid is given else solid,
    )
    return shaped(
        result,
        solid,
        shapes=shapes,
        overlap=overlap,
        max_hull_vertices=options.get("max_hull_vertices"),
        on_progress=on_progress,
    )


def _hull(solid: Mesh, _tolerance: Tolerance, _options: dict[str, Any]) -> list[FloatArray]:
    return [solid.vertices]


def _coacd(solid: Mesh, tolerance: Tolerance, options: dict[str, Any]) -> list[FloatArray]:
    try:
        import coacd
    except ImportError as error:
        raise UsageError("engine 'coacd' is not installed: pip install coacd") from error
    half = 0.5 * float((solid.bounds[1] - solid.bounds[0]).max())
    coacd.set_log_level("off")
    found = coacd.run_coacd(
        coacd.Mesh(solid.vertices, solid.faces),
        threshold=min(max(tolerance.on(solid) / half, 0.01), 1.0),
        seed=options.get("seed", 0),
        max_convex_hull=options.get("max_hulls") or -1,
        decimate=options.get("max_hull_vertices") is not None,
        max_ch_vertex=options.get("max_hull_vertices") or 256,
    )
    return [np.asarray(part[0], dtype=np.float64) for part in found]


def _vhacd(solid: Mesh, _tolerance: Tolerance, options: dict[str, Any]) -> list[FloatArray]:
    try:
        import vhacdx
    except ImportError as error:
        raise UsageError("engine 'vhacd' is not installed: pip install vhacdx") from error
    faces = np.column_stack([np.full(len(solid.faces), 3), solid.faces]).astype(np.uint32).ravel()
    found = vhacdx.compute_vhacd(
        solid.vertices,
        faces,
        maxConvexHulls=options.get("max_hulls") or 64,
        maxNumVerticesPerCH=options.get("max_hull_vertices") or 64,
        asyncACD=False,
    )
    return [np.asarray(part[0], dtype=np.float64) for part in found]


def _hulls(
    solid: Mesh,
    parts: list[FloatArray],
    engine: EngineName,
    on_progress: Callable[[float], object] | None,
) -> tuple[Hull, ...]:
    from assetpipe import _core

    shapes = []
    for points in parts:
        try:
            vertices, faces = _core.convex_hull(np.ascontiguousarray(points))
        except MeshError:  # a flat part of the other engine: no volume, nothing to write
            continue
        shapes.append(Mesh(vertices, faces))
    if not shapes:
        raise EngineError(f"engine '{engine}' returned no hull with a volume")
    certificates = certify(solid, shapes, on_progress=on_progress)
    return tuple(
        Hull(shape.vertices, shape.faces, shape.volume, certificate)
        for shape, certificate in zip(shapes, certificates, strict=True)
    )


def _coverage(solid: Mesh, hulls: tuple[Hull, ...]) -> Coverage:
    """Largest distance from sampled surface points to the hulls."""
    rng = np.random.default_rng(0)
    corners = solid.vertices[solid.faces]
    area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    picked = rng.choice(len(area), _SAMPLES, p=area / area.sum())
    u, v = np.sqrt(rng.random(_SAMPLES)), rng.random(_SAMPLES)
    weights = np.stack([1 - u, u * (1 - v), u * v], axis=1)
    points = np.einsum("ij,ijk->ik", weights, corners[picked])
    outside = np.full(_SAMPLES, np.inf)
    for hull in hulls:
        a, b, c = (hull.vertices[hull.faces[:, k]] for k in range(3))
        normals = np.cross(b - a, c - a)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
        heights = points @ normals.T - np.einsum("ij,ij->i", normals, a)
        outside = np.minimum(outside, heights.max(axis=1))
    # The largest plane distance bounds the distance to a hull from below.
    worst = float(outside.max())
    return Coverage("sample", worst if worst > 1e-9 * solid.diagonal else 0.0, _SAMPLES)
