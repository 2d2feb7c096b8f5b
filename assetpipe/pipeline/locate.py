"""Findings about meshes, told where the meshes are used."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from assetpipe.errors import Location
from assetpipe.findings import Finding
from assetpipe.pipeline.outcome import MeshOutcome
from assetpipe.pipeline.plan import MeshJob
from assetpipe.robot import Robot


def located(
    robot: Robot, number: int, jobs: Sequence[MeshJob], outcomes: Sequence[MeshOutcome]
) -> tuple[Finding, ...]:
    """Every mesh's findings at each place where this robot uses it, in order of links.

    Args:
        robot: the robot.
        number: its index in the plan.
        jobs: of the plan.
        outcomes: of the jobs.
    """
    order = {link.name: place for place, link in enumerate(robot.links)}
    found: list[tuple[int, int, Finding]] = []
    for job, outcome in zip(jobs, outcomes, strict=True):
        for use in job.uses:
            if use.robot != number:
                continue
            location = Location(robot.path, use.line or None)
            found += [
                (
                    order[use.link],
                    use.index,
                    replace(finding, location=location, link=use.link, mesh=use.uri),
                )
                for finding in outcome.findings
            ]
    return tuple(finding for _, _, finding in sorted(found, key=lambda item: item[:2]))
