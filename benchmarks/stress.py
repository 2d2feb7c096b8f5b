"""Random nasty solids through ``decompose`` with every option, held to every promise.

    python benchmarks/stress.py FROM TO [--seconds 240] [--memory 4]

Cases are numbered and always the same: a number alone decides solid, tolerance and options, so a
failure is run again by its number (``stress.py 151 152``). Each case has a process of its own with
a limit of processor time and memory. Judged is by ``tests/corpus/guarantees.py``, which shares no
code with the engine. Prints every failure with its number and check, and what became of the
others; ends with exit code 1 if one failed. A typed refusal is no failure, unless it tells of a
fault of the engine; its kind is counted.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "corpus"))

import guarantees
from exact import contains, is_convex, volume
from numbered import parser, run
from random_solids import Random, solid_of

from assetpipe import decompose
from assetpipe.decomposition import Decomposition, inner_hulls
from assetpipe.errors import AssetpipeError, EngineError
from assetpipe.geometry import Mesh

_STREAM = 77
"""First word of every case's seed; another number would be other cases."""


def options(r: Random, mesh: Mesh) -> tuple[float, dict[str, Any]]:
    """A tolerance of 0.5% to 32% of the diagonal, and at most one option beside the search's."""
    chosen: dict[str, Any] = {"metric": "concavity" if r.integers(3) == 0 else "thickening"}
    chosen["effort"] = ("fast", "balanced", "best")[r.choice(3, p=[0.6, 0.33, 0.07])]
    tolerance = 10.0 ** r.uniform(-2.3, -0.5) * mesh.diagonal
    option, thickening = r.integers(10), chosen["metric"] == "thickening"
    if option == 0:
        chosen["max_hulls"] = int(r.integers(1, 6))
    elif option == 1:
        chosen["max_hull_vertices"] = int(r.integers(4, 20))
    elif option == 2 and thickening:
        chosen["overlap"] = tolerance * r.uniform(0.05, 1)
    elif option == 3 and thickening:
        chosen["shapes"] = "primitives_and_capsules"
    elif option == 4:
        chosen["reach"] = tolerance * r.uniform(1, 5)
    elif option == 5:
        chosen["cavities"] = "fill"
    return tolerance, chosen


def check_budget(solid: Mesh, d: Decomposition, chosen: dict[str, Any]) -> None:
    """Under a budget hulls may exceed the tolerance, and still are convex and cover."""
    bare = np.unique(solid.faces)
    for hull in d.hulls:
        assert is_convex(hull.vertices, hull.faces)
        assert volume(hull.vertices, hull.faces) > 0
        bare = bare[~contains(hull.vertices, hull.faces, solid.vertices[bare])]
    assert not len(bare), f"{len(bare)} vertices of the solid are bare"
    assert len(d.hulls) <= chosen.get("max_hulls", len(d.hulls))
    most = max(len(hull.vertices) for hull in d.hulls)
    assert most <= chosen.get("max_hull_vertices", most)


def check_inner(r: Random, solid: Mesh, tolerance: float) -> None:
    """Inner polytopes are convex, and nothing sampled in them is outside the solid."""
    # Far away the points would be rounded across the surface; differences are exact.
    origin = solid.vertices[0]
    for hull in inner_hulls(solid, tolerance, most=20):
        assert is_convex(hull.vertices, hull.faces)
        corners = hull.vertices - origin
        points, centre = r.dirichlet(np.full(len(corners), 0.4), 40) @ corners, corners.mean(axis=0)
        points = centre + (points - centre) * (1 - 1e-9)
        windings = guarantees.windings((solid.vertices - origin, solid.faces), points)
        assert (windings > 0.5 - 1e-6).all()


def judged(number: int) -> str:
    """What became of a case; raises what a check raises."""
    r = np.random.default_rng([_STREAM, number])
    mesh = solid_of(r)
    if mesh is None:
        return "empty"
    tolerance, chosen = options(r, mesh)
    try:
        d = decompose(mesh, tolerance, threads=1, **chosen)
    except EngineError:  # A fault of ours, typed as it is.
        raise
    except AssetpipeError as error:
        return f"refused ({type(error).__name__}): {error!s:.90}"
    solid = d.solid if d.repair and d.solid else mesh
    budget = {"max_hulls", "max_hull_vertices"} & chosen.keys()
    reshaped = {"overlap", "shapes", "reach"} & chosen.keys()
    if budget:
        check_budget(solid, d, chosen)
    else:
        guarantees.check_hulls(solid, d)
    guarantees.check_cover(solid, d, 120)
    guarantees.check_certificate(solid if d.closed_solid is None else d.closed_solid, d)
    if not budget and not reshaped:
        guarantees.check_levels(solid, d)
    # Parts are asked of the engine again, as it searches by default.
    usual = chosen["effort"] == "balanced" and "max_hulls" not in chosen
    if usual and not reshaped and len(solid.faces) < 4000:
        parts = guarantees.parts_of(solid, d.epsilon, d.metric)
        guarantees.check_parts(solid, d, parts)
    if r.integers(6) == 0 and len(solid.faces) < 1500:
        check_inner(r, solid, 2 * tolerance)
    return f"decomposed: {len(d.hulls)} hulls"


if __name__ == "__main__":
    sys.exit(run(judged, parser("Random solids, held to every promise.", 240).parse_args()))
