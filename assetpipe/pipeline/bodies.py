"""Links as bodies of meshes, before and after: what robot-level checks compare."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from assetpipe.errors import AssetpipeError
from assetpipe.geometry.mesh import Mesh
from assetpipe.pipeline.outcome import HullOutcome, MeshOutcome
from assetpipe.robot import Box, Capsule, Cylinder, MeshShape, OtherShape, Robot, Shape, Sphere
from assetpipe.validation import LinkBody

Outcomes = Mapping[tuple[str, int], MeshOutcome]
"""By link name and element index."""


@dataclass(frozen=True)
class Bodies:
    """A robot's links before and after.

    Attributes:
        before: solids, and shapes that were kept.
        after: hulls, and shapes that were kept.
        convex: hulls in the link's frame, of links that consist of hulls alone.
        ours: links without a mesh that was kept, which an engine may read otherwise.
    """

    before: tuple[LinkBody, ...]
    after: tuple[LinkBody, ...]
    convex: Mapping[str, tuple[Mesh, ...]]
    ours: frozenset[str]


def bodies_of(robot: Robot, outcomes: Outcomes, visual_links: Collection[str]) -> Bodies:
    """The bodies of all links; shapes that cannot be read are left out on both sides.

    Args:
        robot: as read.
        outcomes: of its meshes.
        visual_links: links whose visual elements stand in for their collision elements.
    """
    before: list[LinkBody] = []
    after: list[LinkBody] = []
    convex: dict[str, tuple[Mesh, ...]] = {}
    ours: set[str] = set()
    for link in robot.links:
        old: list[Mesh] = []
        new: list[Mesh] = []
        bound, kinds = 0.0, set()
        for element in link.visuals if link.name in visual_links else link.collisions:
            outcome = outcomes.get((link.name, element.index))
            place = element.link_from_shape
            if outcome is None or outcome.solid is None:
                kept = kept_mesh(element.shape)
                primitive = not isinstance(element.shape, MeshShape | OtherShape)
                kinds.add("primitive" if primitive else "kept")
                if kept is not None:
                    old.append(kept.transformed(place))
                    new.append(kept.transformed(place))
                continue
            # Engines see round shapes themselves, not the polytopes around them.
            kinds |= {_seen_as(hull) for hull in outcome.hulls}
            old.append(outcome.solid.transformed(place))
            new += [hull.mesh.transformed(place) for hull in outcome.hulls]
            bound = max([bound, *(hull.thickening[1] for hull in outcome.hulls)])
        before.append(LinkBody(link.name, tuple(old)))
        after.append(LinkBody(link.name, tuple(new), bound))
        if kinds == {"hulls"}:
            convex[link.name] = tuple(new)
        if "kept" not in kinds:
            ours.add(link.name)
    return Bodies(tuple(before), tuple(after), convex, frozenset(ours))


def _seen_as(hull: HullOutcome) -> str:
    return "hulls" if hull.primitive is None or hull.primitive.kind == "box" else "round"


def bodies_of_links(
    robot: Robot, outcomes: Mapping[str, MeshOutcome], kept: Mapping[str, Collection[int]]
) -> Bodies:
    """The bodies of a robot's links after a comparison.

    Args:
        robot: the original.
        outcomes: of compared links, in the links' frames.
        kept: by link, indices of the elements that both robots have: they are there on
            both sides, since what has changed may touch them.
    """
    before: list[LinkBody] = []
    after: list[LinkBody] = []
    for link in robot.links:
        same = [
            mesh.transformed(element.link_from_shape)
            for element in link.collisions
            if element.index in kept.get(link.name, ())
            and (mesh := kept_mesh(element.shape)) is not None
        ]
        old, new, bound = list(same), list(same), 0.0
        outcome = outcomes.get(link.name)
        if outcome is not None and outcome.solid is not None:
            old.append(outcome.solid)
            new += [hull.mesh for hull in outcome.hulls]
            bound = max(hull.thickening[1] for hull in outcome.hulls)
        if old:
            before.append(LinkBody(link.name, tuple(old)))
            after.append(LinkBody(link.name, tuple(new), bound))
    return Bodies(tuple(before), tuple(after), {}, frozenset())


def kept_mesh(shape: Shape) -> Mesh | None:
    """A shape that stays as it is, as a mesh; ``None`` if there is nothing to see."""
    import trimesh

    if isinstance(shape, MeshShape):
        return _file(shape)
    if isinstance(shape, Box):
        made = trimesh.creation.box(shape.size)
    elif isinstance(shape, Cylinder):
        made = trimesh.creation.cylinder(shape.radius, shape.length, sections=48)
    elif isinstance(shape, Sphere):
        made = trimesh.creation.icosphere(3, shape.radius)
    elif isinstance(shape, Capsule):
        made = trimesh.creation.capsule(shape.length, shape.radius, count=[24, 24])
        made.apply_translation([0.0, 0.0, -float(np.mean(made.bounds[:, 2]))])
    else:
        return None
    mesh = Mesh.of(made)
    return mesh if len(mesh.faces) and mesh.volume > 0 else None


def _file(shape: MeshShape) -> Mesh | None:
    from assetpipe.geometry.files import read_mesh

    if shape.path is None:
        return None
    try:
        return read_mesh(shape.path).mesh.scaled(np.asarray(shape.scale))
    except AssetpipeError:
        return None  # a finding elsewhere already
