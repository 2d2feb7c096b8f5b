"""What a decomposition is: hulls, what is proved about them, and coarser levels."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

from assetpipe.decomposition.certificate import Certificate, Interval
from assetpipe.decomposition.hull import Hull
from assetpipe.decomposition.inner import InnerHull, inner_hulls
from assetpipe.decomposition.tolerance import Tolerance
from assetpipe.errors import UsageError
from assetpipe.geometry.mesh import Mesh

if TYPE_CHECKING:
    import os

    from assetpipe.decomposition.reach import Closing
    from assetpipe.decomposition.seams import Seams
    from assetpipe.geometry import Repaired

EngineName = Literal["assetpipe", "coacd", "vhacd", "hull"]


@dataclass(frozen=True)
class Coverage:
    """Whether every point of the solid is in some hull.

    Attributes:
        proof: ``"construction"``: the parts fill the solid and each hull encloses its
            part, so everything is covered; ``"sample"``: surface points were tested.
        uncovered: largest distance in metres from a surface point to the hulls that was
            found; 0 by construction.
        samples: how many points were tested; 0 by construction.
    """

    proof: Literal["construction", "sample"]
    uncovered: float = 0.0
    samples: int = 0

    @property
    def complete(self) -> bool:
        """Whether nothing was found, or can be found, outside all hulls."""
        return self.uncovered == 0.0

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {
            "proof": self.proof,
            "complete": self.complete,
            "uncovered": self.uncovered,
            "samples": self.samples,
        }


@dataclass(frozen=True, eq=False)
class Node:
    """A hull of the hierarchy; an inner one replaces its two children."""

    hull: Hull
    children: tuple[int, int] | None


@dataclass(frozen=True)
class RepairRecord:
    """What a stored decomposition tells of the repair: its numbers, not its solid.

    Attributes:
        record: as :meth:`assetpipe.geometry.Repaired.as_dict` wrote it.
    """

    record: Mapping[str, Any]

    @property
    def moved(self) -> float:
        """Upper bound in metres on how far the surface moved, as far as it was told."""
        return float(self.record.get("moved", 0.0))

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready, as it was stored."""
        return dict(self.record)


@dataclass(frozen=True, eq=False)
class Decomposition:
    """Hulls that cover a solid, with their certificate.

    Attributes:
        hulls: the hulls of this level.
        coverage: that every point of the solid is in some hull, and how it is known.
        engine: which engine made them.
        tolerance: what was asked for.
        epsilon: the tolerance on this mesh, metres; on a coarser level, what bounds it.
        metric: what was held below it.
        repair: what was done to make the mesh a solid; ``None`` if it was one.
        nodes: the hierarchy: leaves first, children before parents.
        solid: what the hulls cover, after repair and before anything was closed; metres.
        closed: what was closed because nothing can reach it; the certificate is towards the
            solid so closed. ``None`` if that was not asked.
        seams: what became of the seams of this level; ``None`` if no overlap was asked.
        closed_solid: the solid with what was closed, towards which certificates are; ``None``
            if that is ``solid`` itself.
    """

    hulls: tuple[Hull, ...]
    coverage: Coverage
    engine: EngineName
    tolerance: Tolerance
    epsilon: float
    metric: Literal["thickening", "concavity"] = "thickening"
    repair: Repaired | RepairRecord | None = None
    nodes: tuple[Node, ...] = ()
    solid: Mesh | None = None
    closed: Closing | None = None
    seams: Seams | None = None
    closed_solid: Mesh | None = None

    @cached_property
    def inner(self) -> tuple[InnerHull, ...]:
        """Convex polytopes inside the solid, largest first: computed when first asked for.

        They come as near to the surface as half of ``epsilon`` where that is found;
        see :func:`assetpipe.decomposition.inner_hulls`.

        Raises:
            UsageError: the solid was not kept.
        """
        if self.solid is None:
            raise UsageError("inner hulls need the solid, which this decomposition has not kept")
        return inner_hulls(self.solid, 0.5 * self.epsilon)

    @cached_property
    def certificate(self) -> Certificate:
        """Bounds over all hulls: the largest lower and the largest upper bound."""
        thickening = [hull.certificate.thickening for hull in self.hulls]
        concavity = [hull.certificate.concavity for hull in self.hulls]
        known = [interval for interval in concavity if interval is not None]
        return Certificate(
            _largest(thickening), _largest(known) if len(known) == len(concavity) else None
        )

    def at(
        self, *, tolerance: Tolerance | float | str | None = None, max_hulls: int | None = None
    ) -> Decomposition:
        """A coarser level, read from the hierarchy.

        Args:
            tolerance: the fewest hulls of the hierarchy whose thickening is at most this
                (metres, or a :class:`Tolerance` in metres).
            max_hulls: the finest level with at most so many hulls.

        Raises:
            UsageError: neither or both given, a number below one, or a tolerance that is
                finer than this level's.
        """
        if (tolerance is None) == (max_hulls is None):
            raise UsageError("at() takes either tolerance= or max_hulls=")
        if not self.nodes:
            raise UsageError(f"hulls of engine '{self.engine}' have no hierarchy")
        if max_hulls is not None:
            if max_hulls < 1:
                raise UsageError(f"max_hulls must be at least 1, not {max_hulls}")
            return self._level(self._finest(max_hulls), self.epsilon)
        wanted = Tolerance.parse(tolerance if tolerance is not None else 0.0)
        if wanted.unit != "metres":
            raise UsageError(f"a level is chosen by metres, not by '{wanted}'")
        return self._level(self._within(wanted.value), wanted.value)

    @cached_property
    def _own(self) -> tuple[int, ...]:
        """This level's hulls as indices of nodes."""
        position = {id(node.hull): index for index, node in enumerate(self.nodes)}
        return tuple(position[id(hull)] for hull in self.hulls)

    def _merges(self) -> list[int]:
        """Inner nodes above this level, in the order in which they were merged."""
        own = set(self._own)
        below: set[int] = set()
        stack = list(own)
        while stack:
            children = self.nodes[stack.pop()].children
            if children:
                below.update(children)
                stack.extend(children)
        return [
            index
            for index, node in enumerate(self.nodes)
            if node.children and index not in own and index not in below
        ]

    def _finest(self, max_hulls: int) -> list[int]:
        level = list(self._own)
        for index in self._merges():
            if len(level) <= max_hulls:
                break
            level = [k for k in level if k not in (self.nodes[index].children or ())] + [index]
        if len(level) > max_hulls:
            raise UsageError(f"the hierarchy has no level of {max_hulls} hulls, only {len(level)}")
        return level

    def _within(self, metres: float) -> list[int]:
        if metres < self.certificate.thickening.lower:
            raise UsageError(
                f"the hierarchy starts at {self.epsilon:g} m: decompose again for {metres:g} m"
            )
        level = list(self._own)
        for index in self._merges():
            node = self.nodes[index]
            children = node.children or ()
            if node.hull.certificate.upper <= metres and all(k in level for k in children):
                level = [k for k in level if k not in children] + [index]
        return level

    def _level(self, indices: list[int], epsilon: float) -> Decomposition:
        hulls = tuple(self.nodes[index].hull for index in sorted(indices))
        return replace(self, hulls=hulls, epsilon=epsilon, seams=None)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write all levels to a file; see ``docs/decomposition_file.md``.

        Raises:
            InputError: the place cannot be written to.
        """
        from assetpipe.decomposition.storage import save

        save(self, path)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Decomposition:
        """Read what :meth:`save` wrote; nothing is computed again.

        Raises:
            InputError: unreadable, not such a file, of another version, damaged or
                inconsistent; says where.
            LimitError: larger than 256 MiB.
        """
        from assetpipe.decomposition.storage import load

        return load(path)

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready: numbers only, no arrays."""
        return {
            "engine": self.engine,
            "tolerance": str(self.tolerance),
            "epsilon": self.epsilon,
            "metric": self.metric,
            "certificate": self.certificate.as_dict(),
            "coverage": self.coverage.as_dict(),
            "hulls": [hull.as_dict() for hull in self.hulls],
            "hull_vertices": sum(len(hull.vertices) for hull in self.hulls),
            "repair": self.repair.as_dict() if self.repair else None,
            "closed": self.closed.as_dict() if self.closed else None,
            "seams": self.seams.as_dict() if self.seams else None,
        }


def _largest(intervals: list[Interval]) -> Interval:
    return Interval(
        max((i.lower for i in intervals), default=0.0),
        max((i.upper for i in intervals), default=0.0),
    )
