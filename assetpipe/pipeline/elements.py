"""What becomes of every collision element: decided before anything is written."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from assetpipe.geometry.mesh import FloatArray
from assetpipe.pipeline.config import Config, Source
from assetpipe.pipeline.outcome import MeshOutcome
from assetpipe.pipeline.plan import MeshJob
from assetpipe.pipeline.result import Treatment
from assetpipe.robot import Link, MeshShape, OtherShape, Robot, Shape


@dataclass(frozen=True, eq=False)
class Element:
    """One element whose shape is looked at: a collision, or a visual in its stead.

    Attributes:
        link: name of its link.
        index: among the link's elements of its kind.
        kind: ``visual`` if it stands in for the link's collision elements.
        shape: as in the input.
        treatment: what becomes of it.
        job: index of its mesh in the plan, if it has one there.
        link_from_shape: (4, 4).
    """

    link: str
    index: int
    kind: Source
    shape: Shape
    treatment: Treatment
    job: int | None
    link_from_shape: FloatArray

    @property
    def name(self) -> str:
        """The mesh reference as written, or the primitive's name."""
        if isinstance(self.shape, MeshShape):
            return self.shape.uri
        if isinstance(self.shape, OtherShape):
            return self.shape.tag
        return type(self.shape).__name__.lower()


def elements_of(
    robot: Robot,
    number: int,
    jobs: Sequence[MeshJob],
    outcomes: Sequence[MeshOutcome],
    config: Config,
) -> tuple[Element, ...]:
    """All elements of a robot, in document order.

    With ``source="visual"`` the visual elements of a link stand in for its collision
    elements, but only if every one of them became hulls: else the link stays as it was.
    """
    users = {
        (use.link, use.index): place
        for place, job in enumerate(jobs)
        for use in job.uses
        if use.robot == number
    }
    found: list[Element] = []
    for link in robot.links:
        if config.source == "collision":
            found += _elements(link, "collision", users, outcomes)
        elif _all_replaceable(link, users, outcomes):
            found += _elements(link, "visual", users, outcomes)
        else:
            found += _elements(link, "collision", {}, outcomes)
    return tuple(found)


def _all_replaceable(
    link: Link, users: Mapping[tuple[str, int], int], outcomes: Sequence[MeshOutcome]
) -> bool:
    if not link.visuals:
        return False
    for visual in link.visuals:
        if isinstance(visual.shape, OtherShape):
            return False
        if isinstance(visual.shape, MeshShape):
            job = users.get((link.name, visual.index))
            if job is None or outcomes[job].state != "decomposed":
                return False
    return True


def _elements(
    link: Link,
    kind: Source,
    users: Mapping[tuple[str, int], int],
    outcomes: Sequence[MeshOutcome],
) -> list[Element]:
    found = []
    for item in link.collisions if kind == "collision" else link.visuals:
        job = users.get((link.name, item.index))
        treatment: Treatment = "kept"
        if not isinstance(item.shape, MeshShape | OtherShape):
            treatment = "primitive"
        elif job is not None:
            treatment = outcomes[job].state
        found.append(
            Element(link.name, item.index, kind, item.shape, treatment, job, item.link_from_shape)
        )
    return found
