"""What is done with an engine's hulls before they are handed out: seams, then simple shapes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Literal, get_args

from assetpipe.decomposition.decomposition import Decomposition, Node
from assetpipe.decomposition.primitives import KINDS, Kind, slimmed, with_primitives
from assetpipe.decomposition.seams import with_overlap
from assetpipe.errors import UsageError, unknown_name
from assetpipe.geometry.mesh import Mesh

Shapes = Literal["hulls", "primitives", "primitives_and_capsules"]
SHAPES: tuple[Shapes, ...] = get_args(Shapes)

_KINDS: dict[Shapes, tuple[Kind, ...]] = {
    "hulls": (),
    "primitives": ("box", "cylinder", "sphere"),
    "primitives_and_capsules": KINDS,
}


def check_shaping(shapes: str, overlap: float, metric: str) -> None:
    """Refuse what cannot be done.

    Raises:
        UsageError: an unknown name, an overlap that is no length, or either with a metric
            that bounds the distance to a part, which a shape or an extended hull leaves.
    """
    if shapes not in SHAPES:
        raise UsageError(unknown_name("shapes", shapes, SHAPES))
    if not 0.0 <= overlap < float("inf"):
        raise UsageError(f"overlap must be a length of 0 or more metres, not {overlap}")
    if metric != "thickening" and (shapes != "hulls" or overlap > 0.0):
        asked = "overlap" if overlap > 0.0 else f"shapes '{shapes}'"
        raise UsageError(f"{asked} needs metric 'thickening', not '{metric}'")


def shaped(
    found: Decomposition,
    solid: Mesh,
    *,
    shapes: Shapes,
    overlap: float,
    max_hull_vertices: int | None,
    on_progress: Callable[[float], object] | None,
) -> Decomposition:
    """A decomposition whose seams overlap and whose hulls are simple shapes where that was
    asked and is proved. Coarser levels of its hierarchy stay as they are.

    Args:
        found: of any engine.
        solid: what its hulls stand for, metres.
        shapes: which simple shapes may be used.
        overlap: metres; 0 leaves the seams.
        max_hull_vertices: budget a hull.
        on_progress: as in :func:`assetpipe.decompose`.
    """
    hulls, seams = found.hulls, None
    if overlap > 0.0:
        hulls, seams = with_overlap(
            solid,
            hulls,
            overlap,
            found.epsilon,
            max_vertices=max_hull_vertices,
            on_progress=on_progress,
        )
    if _KINDS[shapes]:
        hulls = with_primitives(
            solid, hulls, found.epsilon, kinds=_KINDS[shapes], on_progress=on_progress
        )
        if found.engine == "assetpipe":
            hulls = tuple(
                hull if hull.primitive else slimmed(solid, hull, found.epsilon) for hull in hulls
            )
    instead = {id(old): new for old, new in zip(found.hulls, hulls, strict=True)}
    nodes = tuple(Node(instead.get(id(n.hull), n.hull), n.children) for n in found.nodes)
    return replace(found, hulls=hulls, nodes=nodes, seams=seams)
