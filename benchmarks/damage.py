"""Damaged meshes through ``repair`` and ``decompose``, held to what both say.

    python benchmarks/damage.py FROM TO [--meshes FOLDER] [--seconds 240] [--memory 4]

Cases are numbered and always the same: a number decides solid and damage (``damaged_meshes.py``).
Solids are random ones, or the meshes below a folder. Judged is from outside: the solid is closed,
no point of either surface is farther from the other than the deviation says, no more of it than
allowed is beyond the budget, and where damage leaves no doubt which solid was meant, repair made
that one or told of a doubt; hulls are convex, cover the solid and keep their certificates.
Prints every failure with its number and check, and what became of the others; ends with exit
code 1 if one failed. A refusal is no failure; its codes are counted.
"""

from __future__ import annotations

import sys
import time
from functools import partial
from pathlib import Path

import igl
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "corpus"))

import guarantees
from damaged_meshes import Damaged, damaged
from exact import contains, is_convex, volume
from numbered import parser, run
from random_solids import Random, solid_of

from assetpipe import decompose
from assetpipe.decomposition import Decomposition
from assetpipe.errors import AssetpipeError, EngineError
from assetpipe.geometry import Mesh, Repaired, RepairPolicy, read_mesh, repair

_STREAM = 78
"""First word of every case's seed; another number would be other cases."""

_SAMPLE = 4000
_ROUNDING = 1e-7
"""Of the diagonal: what a root of a squared distance may be off by."""
_BEYOND = 0.01
"""The share of either surface that may move farther than the budget."""

_LINE = 1e-15
"""Of the squared diagonal: the area of a face that is one in rounding only."""

_MOST_FACES = 6000
_DOUBTS = {"AP207", "AP208", "AP209"}
"""Findings that say that the solid may be another one than meant."""


def solid_for(r: Random, meshes: tuple[Path, ...]) -> Mesh | None:
    """A random solid, or one of the files made a solid; none where there is none."""
    if not meshes:
        made = repair(solid) if (solid := solid_of(r)) else None
    else:
        try:
            mesh = read_mesh(meshes[r.integers(len(meshes))]).mesh
        except AssetpipeError:
            return None
        made = repair(mesh) if 0 < len(mesh.faces) <= _MOST_FACES else None
    return made.solid if made else None


def sampled(r: Random, mesh: Mesh) -> np.ndarray:
    """Points of the surface, uniformly over the area."""
    corners = mesh.vertices[mesh.faces]
    area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    if not area.sum():
        return mesh.vertices[np.unique(mesh.faces)]
    chosen = corners[r.choice(len(area), _SAMPLE, p=area / area.sum())]
    return np.einsum("ij,ijk->ik", r.dirichlet((1, 1, 1), _SAMPLE), chosen)


def distances(mesh: Mesh, points: np.ndarray) -> np.ndarray:
    """From the surface, by libigl, about the mesh's middle for precision."""
    centre = mesh.bounds.mean(axis=0)
    squared = igl.point_mesh_squared_distance(
        np.ascontiguousarray(points - centre),
        np.ascontiguousarray(mesh.vertices - centre),
        np.ascontiguousarray(mesh.faces),
    )[0]
    return np.sqrt(np.asarray(squared))


def inside(mesh: Mesh, points: np.ndarray) -> np.ndarray:
    return guarantees.windings((mesh.vertices, mesh.faces), points) > 0.5


def bounding(mesh: Mesh, points: np.ndarray) -> np.ndarray:
    """Whether the winding number changes at points of the surface: others bound nothing."""
    if not len(points):
        return np.zeros(0, dtype=bool)
    v = np.ascontiguousarray(mesh.vertices)
    face = igl.point_mesh_squared_distance(points, v, np.ascontiguousarray(mesh.faces))[1]
    a, b, c = (v[mesh.faces[face, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.maximum(np.linalg.norm(normal, axis=1), np.finfo(float).tiny)[:, None]
    aside = 1e-6 * mesh.diagonal * normal
    part = (mesh.vertices, mesh.faces)
    jump = guarantees.windings(part, points + aside) - guarantees.windings(part, points - aside)
    return np.asarray(np.abs(jump) > 0.5)


def check_closed(solid: Mesh) -> None:
    """Every edge has two faces that use it in opposite directions; what it encloses is positive."""
    edges = np.vstack([solid.faces[:, [0, 1]], solid.faces[:, [1, 2]], solid.faces[:, [2, 0]]])
    assert (edges[:, 0] != edges[:, 1]).all()
    forth, count = np.unique(edges, axis=0, return_counts=True)
    assert (count == 1).all()
    assert np.array_equal(forth, np.unique(edges[:, ::-1], axis=0))
    assert volume(solid.vertices, solid.faces) > 0


def check_deviation(r: Random, mesh: Mesh, made: Repaired, solid: Mesh) -> None:
    """No sampled point is beyond what is said, and few beyond the budget."""
    slack = _ROUNDING * mesh.diagonal + guarantees.rounding(mesh)
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    # A face on one line is no surface.
    used = mesh.vertices[np.unique(mesh.faces[area > _LINE * mesh.diagonal**2])]
    corners = used[r.permutation(len(used))[:_SAMPLE]]
    old, new = sampled(r, mesh), sampled(r, solid)
    away = guarantees.distance_outside(solid, old)
    gone = guarantees.distance_outside(solid, corners)
    worst = max(float(away.max()), float(gone.max()))
    told = made.deviation
    assert worst <= told.removed + slack, f"{worst / mesh.diagonal:.3g} removed"
    fresh = distances(mesh, new)
    assert fresh.max() <= told.added + slack, f"{fresh.max() / mesh.diagonal:.3g} added"
    budget = RepairPolicy().budget_on(mesh)
    far = old[away > budget]
    for count in (bounding(mesh, far).sum(), (fresh > budget).sum()):
        assert count <= 2 * _BEYOND * _SAMPLE, f"{count} of {_SAMPLE} are beyond the budget"


def check_meaning(r: Random, case: Damaged, made: Repaired, solid: Mesh) -> None:
    """Far from both surfaces, inside is inside and outside is outside.

    Enclosed voids may have been filled: where their lining is torn, it is a sheet in a solid.
    """
    meant = case.meant
    if meant is None or _DOUBTS & {finding.code for finding in made.findings}:
        return
    points = r.uniform(*meant.bounds, (_SAMPLE, 3))
    reach = max(0.015 * meant.diagonal, made.deviation.largest)
    points = points[np.minimum(distances(meant, points), distances(case.mesh, points)) > reach]
    expected, found = inside(meant, points), inside(solid, points)
    hollow = expected & ~found
    assert not hollow.any(), f"hollow: {hollow.sum()} of {len(points)}"
    parts = meant.to_trimesh().split(only_watertight=False)
    bodies = [Mesh(part.vertices, part.faces) for part in parts if part.volume > 0]
    enclosed = np.any([inside(body, points) for body in bodies], axis=0)
    filled = found & ~expected & ~enclosed
    assert not filled.any(), f"filled: {filled.sum()} of {len(points)}"


def check_hulls(d: Decomposition) -> None:
    """Convex and outward, exactly, and no larger than allowed."""
    for hull in d.hulls:
        assert is_convex(hull.vertices, hull.faces)
        assert volume(hull.vertices, hull.faces) > 0
        assert hull.certificate.thickening.upper <= d.epsilon * (1 + 1e-9)


def check_corners(r: Random, solid: Mesh, d: Decomposition) -> None:
    """Every vertex is in a hull, but for those of flaps that bound nothing."""
    bare = solid.vertices[np.unique(solid.faces)]
    for hull in d.hulls:
        bare = bare[~contains(hull.vertices, hull.faces, bare)]
    around = r.normal(size=(200, 3))
    for point in bare:
        near = point + 1e-7 * solid.diagonal * around
        assert not inside(solid, near).any(), point


def judged(meshes: tuple[Path, ...], number: int) -> str:
    """What became of a case; raises what a check raises."""
    r = np.random.default_rng([_STREAM, number])
    intact = solid_for(r, meshes)
    if intact is None:
        return "no solid to damage"
    case = damaged(r, intact)
    name = "+".join(case.kinds)
    if not len(case.mesh.faces):
        return f"nothing left: {name}"
    clock = time.process_time()
    made = repair(case.mesh)
    seconds = time.process_time() - clock
    if made.solid is None:
        codes = sorted({f.code for f in made.findings if f.severity.value == "error"})
        return f"refused {' '.join(codes)}: {name}, {len(case.mesh.faces)} faces, {seconds:.2f} s"
    check_closed(made.solid)
    check_deviation(r, case.mesh, made, made.solid)
    check_meaning(r, case, made, made.solid)
    try:
        d = decompose(made, 10.0 ** r.uniform(-2, -0.7) * case.mesh.diagonal, threads=1)
    except EngineError:  # A fault of ours, typed as it is.
        raise
    except AssetpipeError as error:
        return f"not decomposed ({type(error).__name__}): {name}: {error!s:.90}"
    solid = d.solid or made.solid
    check_hulls(d)
    check_corners(r, solid, d)
    guarantees.check_cover(solid, d, 200)
    guarantees.check_certificate(solid, d)
    told = " ".join(sorted(_DOUBTS & {f.code for f in made.findings}))
    kind = "as meant" if case.meant and not told else f"solid {told}".strip()
    return f"{kind}: {name}, {len(case.mesh.faces)} faces, {len(d.hulls)} hulls, {seconds:.2f} s"


def main() -> int:
    arguments = parser("Damaged meshes, held to what repair and decompose say.", 240)
    arguments.add_argument("--meshes", type=Path, help="folder of the meshes to damage")
    asked = arguments.parse_args()
    endings = {".stl", ".obj", ".off", ".ply"}
    found = sorted(asked.meshes.rglob("*")) if asked.meshes else []
    meshes = tuple(path for path in found if path.suffix.lower() in endings)
    return run(partial(judged, meshes), asked)


if __name__ == "__main__":
    sys.exit(main())
