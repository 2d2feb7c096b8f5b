"""What there is to do: robots in, distinct meshes and who uses them out. Pure."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from assetpipe.pipeline.config import Config, LinkSettings
from assetpipe.pipeline.identity import code_stamp, digest_of, versions
from assetpipe.robot import Collision, MeshShape, Robot, Visual


@dataclass(frozen=True)
class Use:
    """Where a mesh is used: one collision element of one robot.

    Attributes:
        robot: index of the robot in the plan.
        link: the link's name.
        index: the element's place among the link's elements of its kind.
        uri: the reference as written.
        line: of the element in its file, if known.
    """

    robot: int
    link: str
    index: int
    uri: str
    line: int | None


@dataclass(frozen=True)
class MeshJob:
    """One distinct mesh with what is asked of it.

    Attributes:
        path: a file that holds it.
        digest: SHA-256 of its bytes.
        scale: (x, y, z) of ``<mesh scale>``.
        params: everything else that decides the outcome, JSON-ready.
        contact: settings of the contact check, or ``None``.
        uses: in the order of the robots' files; never empty.
        until: ``repair`` stops once it is known what repair would do.
    """

    path: Path
    digest: str
    scale: tuple[float, float, float]
    params: Mapping[str, Any]
    contact: Mapping[str, int] | None
    uses: tuple[Use, ...]
    until: Literal["repair", "end"] = "end"

    @property
    def key(self) -> str:
        """Content address of the outcome: equal keys, equal outcomes."""
        return digest_of(
            {
                "code": code_stamp(),
                "versions": versions(self.params["engine"]),
                "mesh": self.digest,
                "type": self.path.suffix.lower(),
                "scale": self.scale,
                "params": dict(self.params),
                "contact": self.contact,
                "until": self.until,
            }
        )

    def request(self) -> dict[str, Any]:
        """For a worker, JSON-ready."""
        return {
            "kind": "mesh",
            "path": str(self.path),
            "scale": list(self.scale),
            "params": dict(self.params),
            "contact": self.contact,
            "until": self.until,
        }

    @property
    def name(self) -> str:
        """For people: the links that use it."""
        links = list(dict.fromkeys(use.link for use in self.uses))
        return ", ".join(links[:3]) + (f" and {len(links) - 3} more" if len(links) > 3 else "")


@dataclass(frozen=True)
class Plan:
    """All distinct meshes of all robots, in the order of their first use."""

    robots: tuple[Robot, ...]
    jobs: tuple[MeshJob, ...]


def make_plan(robots: Sequence[Robot], config: Config, digest: Callable[[Path], str]) -> Plan:
    """List the distinct meshes.

    Args:
        robots: as read.
        config: what is asked.
        digest: SHA-256 of a file's bytes.
    """
    uses: dict[str, list[Use]] = {}
    first: dict[str, MeshJob] = {}
    for number, robot in enumerate(robots):
        for link in robot.links:
            settings = config.links.get(link.name, LinkSettings())
            if settings.treatment == "keep":
                continue
            elements = link.collisions if config.source == "collision" else link.visuals
            for element in elements:
                if not isinstance(element.shape, MeshShape) or element.shape.path is None:
                    continue
                job = _job(element, element.shape, config, settings, digest)
                identity = digest_of([job.digest, job.path.suffix.lower(), job.scale, job.params])
                first.setdefault(identity, job)
                uses.setdefault(identity, []).append(
                    Use(number, link.name, element.index, element.shape.uri, element.line)
                )
    jobs = tuple(
        MeshJob(j.path, j.digest, j.scale, j.params, j.contact, tuple(uses[identity]))
        for identity, j in first.items()
    )
    return Plan(tuple(robots), jobs)


def _job(
    element: Collision | Visual,
    shape: MeshShape,
    config: Config,
    settings: LinkSettings,
    digest: Callable[[Path], str],
) -> MeshJob:
    assert shape.path is not None  # noqa: S101 - the caller looked
    tolerance = settings.tolerance or config.tolerance
    budget = config.repair.budget
    contact = "contact" in config.validation.checks
    x, y, z = (float(f) for f in shape.scale)
    return MeshJob(
        path=shape.path,
        digest=digest(shape.path),
        scale=(x, y, z),
        params={
            "tolerance": [tolerance.value, tolerance.unit],
            "metric": config.metric,
            "effort": config.effort,
            "engine": config.engine,
            "seed": config.seed,
            "max_hulls": settings.max_hulls or config.max_hulls,
            "max_hull_vertices": settings.max_hull_vertices or config.max_hull_vertices,
            "cavities": config.cavities,
            "reach": config.reach,
            "shapes": config.shapes,
            "overlap": config.overlap,
            "inner": config.inner,
            "repair": config.repair.mode,
            "repair_budget": [
                budget.value,
                {"relative": "share", "metres": "metres", "coacd": "share"}[budget.unit],
            ],
            "openings": settings.openings or config.repair.openings,
            "faces": config.limits.faces,
            "file_size": config.limits.file_size,
        },
        contact={"samples": config.validation.samples, "seed": config.validation.seed}
        if contact
        else None,
        uses=(),
    )
