"""One whole robot, before against after: self-collision, and a physics engine.

Runs in a worker process. The answer is JSON: ``{"validation": …, "findings": […]}``.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from assetpipe.errors import AssetpipeError
from assetpipe.findings import Finding, Severity
from assetpipe.pipeline.bodies import Bodies, bodies_of, bodies_of_links
from assetpipe.pipeline.outcome import MeshOutcome
from assetpipe.pipeline.poses import configurations
from assetpipe.pipeline.stages import Reporter
from assetpipe.robot import Robot, forward_kinematics, read_robot


def answer(request: Mapping[str, Any], reporter: Reporter) -> bytes:
    """Run the checks that are asked for.

    Request keys: ``robot`` and ``built`` (files), ``checks``, ``poses``, ``seed``; and
    either ``outcomes`` (link, index, file) with ``visual_links``, or ``links``, files of
    outcomes in their links' frames, with ``kept``, by link, indices of unchanged elements.
    """
    robot = read_robot(Path(request["robot"])).robot
    bodies = _bodies(robot, request)
    validation: dict[str, Any] = {}
    findings: list[Finding] = []

    def said() -> bytes:
        told = [finding.as_dict() for finding in findings]
        return json.dumps({"validation": validation, "findings": told}).encode()

    for check in request["checks"]:
        reporter.stage(check)
        try:
            if check == "self_collision":
                _self_collision(robot, bodies, request, validation, findings)
            elif check == "engine":
                _engine(robot, bodies, request, validation, findings)
        except AssetpipeError as error:
            findings.append(
                Finding("AP411", Severity.WARNING, f"{check} could not be checked: {error.message}")
            )
        reporter.partial(said())
    return said()


def _bodies(robot: Robot, request: Mapping[str, Any]) -> Bodies:
    def read(file: str) -> MeshOutcome:
        return MeshOutcome.decode(Path(file).read_bytes())

    if "links" in request:
        compared = {link: read(file) for link, file in request["links"].items()}
        return bodies_of_links(robot, compared, request["kept"])
    outcomes = {(str(link), int(index)): read(file) for link, index, file in request["outcomes"]}
    return bodies_of(robot, outcomes, set(request["visual_links"]))


def _self_collision(
    robot: Robot,
    bodies: Bodies,
    request: Mapping[str, Any],
    validation: dict[str, Any],
    findings: list[Finding],
) -> None:
    from assetpipe.validation import adjacent_pairs, self_collisions

    adjacent = adjacent_pairs((j.parent, j.child, j.type) for j in robot.joints)
    result = self_collisions(
        bodies.before,
        bodies.after,
        (
            forward_kinematics(robot, positions)
            for positions in configurations(robot, count=request["poses"], seed=request["seed"])
        ),
        excluded=adjacent,
    )
    validation["self_collision"] = result.as_dict()
    findings += result.findings()


def _engine(
    robot: Robot,
    bodies: Bodies,
    request: Mapping[str, Any],
    validation: dict[str, Any],
    findings: list[Finding],
) -> None:
    from assetpipe.validation import load_in_engine

    built = Path(request["built"])
    again = read_robot(built).robot
    result = load_in_engine(
        built,
        # Of a mesh that was kept it is not for us to say how many shapes an engine sees.
        {link.name: len(link.collisions) for link in again.links if link.name in bodies.ours},
        hulls=bodies.convex,
        resolved=_resolved(again),
        seed=request["seed"],
    )
    validation["engine"] = result.as_dict()
    told = result.findings()
    if result.outcome == "refused" and _refuses(robot):
        why = f"{result.engine} loads neither the original nor the result: {result.message}"
        told = tuple(replace(finding, severity=Severity.WARNING, message=why) for finding in told)
    findings += told


def _refuses(robot: Robot) -> bool:
    """Whether the engine does not load the original either; not known of a xacro."""
    from assetpipe.validation import load_in_engine

    if robot.path.read_bytes() != robot.source:
        return False
    return load_in_engine(robot.path, {}, resolved=_resolved(robot)).outcome == "refused"


def _resolved(robot: Robot) -> dict[str, Path]:
    """The file of every reference that was found."""
    return {
        reference.uri: reference.resolution.path
        for reference in robot.references
        if reference.resolution.path is not None
    }
