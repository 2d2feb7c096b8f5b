"""Straight sweeps of convex shapes, exactly and in one query.

A convex shape that moves straight without turning sweeps the convex hull of where it
starts and where it ends. So the least separation over the whole motion is the separation
from that hull: no steps in time at all.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from assetpipe.geometry.mesh import FloatArray, Mesh
from assetpipe.validation.contact.pairs import LinkBody, PairQueries
from assetpipe.validation.runners.world import key
from assetpipe.validation.scenes.bodies import convex_hull

if TYPE_CHECKING:
    from assetpipe.validation.effects.motion import Motion
    from assetpipe.validation.effects.plan import Ref

Frames = Mapping[str, FloatArray]
"""World-from-link matrices (4, 4) by :func:`key`."""


def swept_gaps(
    motion: Motion, pairs: list[tuple[Ref, Ref]], stops: Sequence[Frames]
) -> dict[tuple[Ref, Ref], float]:
    """Least separation over a motion, metres, of the pairs that this way answers.

    Those are pairs of hulls of which one stands still and the other moves straight from
    stop to stop without turning.

    Args:
        motion: of the scene.
        pairs: to answer.
        stops: where the links are at the motion's corners.
    """
    bodies: dict[str, LinkBody] = {}
    frames: dict[str, FloatArray] = {}
    answered = []
    for pair in pairs:
        movers = [ref for ref in pair if motion.moves(ref)]
        links = [motion.assets[ref[0]].link[ref[1]] for ref in pair]
        hulls = all(link.kind == "hulls" for link in links)
        if len(movers) != 1 or not hulls or motion.turns(movers[0]):
            continue
        for ref, link in zip(pair, links, strict=True):
            name = key(ref)
            if name in bodies:
                continue
            shapes = link.shapes
            if ref in movers:
                shapes = tuple(s for m in link.shapes for s in _swept(m, stops, name))
            bodies[name] = LinkBody(name, shapes, kind="hulls")
            frames[name] = stops[0][name]
        answered.append(pair)
    if not answered:
        return {}
    queries = PairQueries(list(bodies.values()))
    queries.place(frames)
    return {(a, b): queries.gap((key(a), key(b))) for a, b in answered}


def _swept(shape: Mesh, stops: Sequence[Frames], name: str) -> list[Mesh]:
    """The volumes that a convex shape sweeps between stops, in its link's first frame."""
    start = stops[0][name]
    shifts = [(s[name][:3, 3] - start[:3, 3]) @ start[:3, :3] for s in stops]
    return [
        convex_hull(np.vstack([shape.vertices + before, shape.vertices + after]))
        for before, after in pairwise(shifts)
    ]
