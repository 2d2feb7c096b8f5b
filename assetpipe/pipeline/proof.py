"""Whole robots proved: self-collision and a physics engine, each in a process of its own."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from assetpipe.errors import Location
from assetpipe.findings import Finding, Severity
from assetpipe.pipeline.config import Config
from assetpipe.pipeline.executors import Reply, Task
from assetpipe.pipeline.executors.local import LocalExecutor
from assetpipe.pipeline.executors.task import Cancelled
from assetpipe.pipeline.package import Draft
from assetpipe.pipeline.progress import Listener, Progress
from assetpipe.pipeline.result import finding_of
from assetpipe.robot import Robot


@dataclass(frozen=True)
class Proof:
    """What the checks of one robot said: JSON-ready results, and findings."""

    validation: Mapping[str, Any]
    findings: tuple[Finding, ...]


def prove(
    drafts: Sequence[Draft],
    config: Config,
    *,
    jobs: int,
    on_progress: Listener,
    cancelled: Cancelled,
) -> tuple[Proof, ...]:
    """Check staged robots, in order; bare meshes have nothing to check."""
    checks = [check for check in config.validation.checks if check != "contact"]
    proofs = [Proof(contact_summary(draft), ()) for draft in drafts]
    places = [n for n, draft in enumerate(drafts) if draft.urdf is not None and checks]
    if not places:
        return tuple(proofs)

    def listen(place: int, stage: str, fraction: float) -> None:
        name = drafts[places[place]].robot.name
        on_progress(Progress(stage, name, 0, 0, fraction))

    with tempfile.TemporaryDirectory(prefix="assetpipe-proof-") as folder:
        tasks = [_task(drafts[n], config, checks, Path(folder, str(n))) for n in places]
        replies = LocalExecutor(jobs).run(tasks, listener=listen, cancelled=cancelled)
        for place, reply in replies:
            n = places[place]
            proof = said(reply, drafts[n].robot)
            proofs[n] = Proof(
                {**proofs[n].validation, **proof.validation},
                tuple(_settled(finding, drafts[n]) for finding in proof.findings),
            )
    return tuple(proofs)


def contact_summary(draft: Draft) -> dict[str, Any]:
    """Contact truth over all meshes of a robot; empty if it was not asked."""
    told = [d.outcome.facts["contact"] for _, d in draft.meshes if "contact" in d.outcome.facts]
    if not told:
        return {}
    return {
        "contact": {
            "meshes": len(told),
            "samples": sum(item["samples"] for item in told),
            "clearance_error_worst": max(item["clearance_error"]["worst"] for item in told),
            "allowed": max(item["allowed"] for item in told),
            "holds": all(item["holds"] for item in told),
        }
    }


def _task(draft: Draft, config: Config, checks: Sequence[str], folder: Path) -> Task:
    """The request for one robot; its outcomes go into files for the other process."""
    assert draft.urdf is not None  # noqa: S101 - the caller looked
    folder.mkdir()
    files: dict[int, str] = {}
    outcomes: list[tuple[str, int, str]] = []
    for element in draft.elements:
        if element.job is None or element.treatment != "decomposed":
            continue
        if element.job not in files:
            path = folder / f"{element.job}.outcome"
            path.write_bytes(draft.outcomes[element.job].encode())
            files[element.job] = str(path)
        outcomes.append((element.link, element.index, files[element.job]))
    request = {
        "kind": "robot",
        "robot": str(draft.robot.path),
        "built": str(draft.stage.folder / draft.urdf),
        "outcomes": outcomes,
        "visual_links": sorted({e.link for e in draft.elements if e.kind == "visual"}),
        "checks": list(checks),
        "poses": config.validation.poses,
        "seed": config.validation.seed,
    }
    return Task(draft.robot.name, request, config.limits.seconds, config.limits.memory)


def said(reply: Reply, robot: Robot) -> Proof:
    """What the process that checked a robot answered, faults among the findings."""
    data = json.loads(reply.payload) if reply.payload else {"validation": {}, "findings": []}
    findings = [_at_link(finding_of(item), robot) for item in data["findings"]]
    if reply.fault is not None:
        ours = reply.fault.kind == "exception"
        findings.append(
            Finding(
                "AP901" if ours else "AP411",
                Severity.ERROR if ours else Severity.WARNING,
                f"check '{reply.fault.stage}' did not end: {reply.fault.message}",
                Location(robot.path),
            )
        )
    return Proof(data["validation"], tuple(findings))


def _at_link(finding: Finding, robot: Robot) -> Finding:
    """A finding about a link alone, told where the link is in the input."""
    if finding.location is not None:
        return finding
    link = robot.link_map.get(finding.link or "")
    return replace(finding, location=Location(robot.path, link.line if link else None))


def _settled(finding: Finding, draft: Draft) -> Finding:
    """A finding about a staged file, told of the file that it becomes."""
    place = finding.location
    if place is None or not place.file.is_relative_to(draft.stage.folder):
        return finding
    file = draft.stage.out / place.file.relative_to(draft.stage.folder)
    return replace(finding, location=Location(file, place.line))
