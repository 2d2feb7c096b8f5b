"""What is measured: engines as named variants, meshes as named files."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

MESH_ENDINGS = {".off", ".stl", ".obj", ".ply"}


@dataclass(frozen=True)
class Run:
    """Hulls of one engine on one mesh; seconds of CPU and of wall time, preparation excluded."""

    hulls: list[np.ndarray]
    cpu_s: float
    wall_s: float
    certified: float | None


def data_folders() -> list[Path]:
    """Benchmark meshes: ``ASSETPIPE_BENCH_DATA`` or ``shared/data`` beside the checkout."""
    root = Path(
        os.environ.get("ASSETPIPE_BENCH_DATA")
        or Path(__file__).resolve().parents[2] / "shared" / "data"
    )
    return [p for p in (root / "vhacd", root / "cad") if p.is_dir()]


def meshes(paths: list[Path]) -> Iterator[Path]:
    """All mesh files in the given folders or files, in a stable order."""
    for path in paths:
        if path.is_dir():
            yield from sorted(p for p in path.iterdir() if p.suffix.lower() in MESH_ENDINGS)
        else:
            yield path


def ours(effort: str, metric: str, threads: int = 1) -> Callable[..., Run]:
    def run(vertices, faces, threshold: float) -> Run:
        import assetpipe

        tolerance = assetpipe.Tolerance.coacd(threshold)
        cpu, wall = time.process_time(), time.perf_counter()
        d = assetpipe.decompose(
            (vertices, faces), tolerance=tolerance, metric=metric, effort=effort, threads=threads
        )
        cpu, wall = time.process_time() - cpu, time.perf_counter() - wall
        upper = max(
            (h.certificate.upper if metric == "thickening" else h.certificate.concavity.upper)
            for h in d.hulls
        )
        return Run([np.asarray(h.vertices) for h in d.hulls], cpu, wall, float(upper))

    return run


def coacd(vertices, faces, threshold: float) -> Run:
    """CoACD with its defaults, one thread."""
    os.environ["OMP_NUM_THREADS"] = "1"
    import coacd as engine

    engine.set_log_level("off")
    mesh = engine.Mesh(vertices, faces)
    cpu, wall = time.process_time(), time.perf_counter()
    parts = engine.run_coacd(mesh, threshold=threshold, seed=0)
    return Run(
        [np.asarray(p[0]) for p in parts],
        time.process_time() - cpu,
        time.perf_counter() - wall,
        None,
    )


def vhacd(vertices, faces, threshold: float) -> Run:
    """V-HACD 4.1 at its defaults: at most 64 hulls, no tolerance in metres."""
    import vhacdx

    quads = np.column_stack([np.full(len(faces), 3), faces]).astype(np.uint32)
    cpu, wall = time.process_time(), time.perf_counter()
    parts = vhacdx.compute_vhacd(vertices, quads.ravel())
    return Run(
        [np.asarray(p[0]) for p in parts],
        time.process_time() - cpu,
        time.perf_counter() - wall,
        None,
    )


ENGINES: dict[str, Callable[..., Run]] = {
    **{
        f"{effort}-{metric}": ours(effort, metric)
        for effort in ("fast", "balanced", "best")
        for metric in ("thickening", "concavity")
    },
    "balanced-thickening-2threads": ours("balanced", "thickening", threads=2),
    "coacd": coacd,
    "vhacd": vhacd,
}


def load(path: Path) -> tuple[np.ndarray, np.ndarray, bool]:
    """Vertices and faces as stored, exactly welded; and whether the mesh is closed."""
    import trimesh

    mesh = trimesh.load(path, process=False, force="mesh")
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    return (
        np.ascontiguousarray(mesh.vertices, dtype=np.float64),
        np.ascontiguousarray(mesh.faces, dtype=np.int64),
        bool(mesh.is_watertight),
    )


def versions() -> dict[str, str]:
    """Versions of everything that is compared."""
    from importlib.metadata import PackageNotFoundError, version

    out = {"python": sys.version.split()[0]}
    for name in ("assetpipe", "coacd", "vhacdx", "libigl", "manifold3d", "numpy"):
        try:
            out[name] = version(name)
        except PackageNotFoundError:
            out[name] = "absent"
    return out
