"""The last step of a package: its result, its report and its provenance."""

from __future__ import annotations

from collections.abc import Mapping

from assetpipe.findings import Finding
from assetpipe.pipeline.config import Config
from assetpipe.pipeline.identity import digest_file
from assetpipe.pipeline.locate import located
from assetpipe.pipeline.output import PROVENANCE
from assetpipe.pipeline.package import Draft
from assetpipe.pipeline.proof import Proof
from assetpipe.pipeline.record import REPORT, provenance_bytes, report_bytes
from assetpipe.pipeline.result import CollisionResult, LinkResult, MeshResult, RobotResult


def conclude(
    draft: Draft, proof: Proof, config: Config
) -> tuple[RobotResult, Mapping[str, str], Mapping[str, str]]:
    """Write report and provenance into the stage.

    Returns:
        The result; SHA-256 of every staged file by its path; SHA-256 of every input by
        its absolute path.
    """
    robot = result_of(draft, proof)
    record = {"robots": [robot.as_dict()], "findings": [f.as_dict() for f in robot.findings]}
    roots = [draft.stage.folder, draft.stage.out, *draft.roots]
    draft.stage.path(REPORT).write_bytes(report_bytes(record, config, roots))
    outputs = {
        name: digest_file(draft.stage.folder / name)
        for name in draft.stage.files()
        if name != PROVENANCE
    }
    provenance = provenance_bytes(config, draft.named_inputs, outputs)
    draft.stage.path(PROVENANCE).write_bytes(provenance)
    outputs[PROVENANCE] = digest_file(draft.stage.folder / PROVENANCE)
    return robot, outputs, draft.inputs


def result_of(draft: Draft, proof: Proof) -> RobotResult:
    """Everything that is known about a robot, as a value."""
    places = {job: place for place, (job, _) in enumerate(draft.meshes)}
    links: dict[str, list[CollisionResult]] = {link.name: [] for link in draft.robot.links}
    for element in draft.elements:
        decomposed = element.treatment == "decomposed"
        links[element.link].append(
            CollisionResult(
                element.index,
                element.name,
                element.treatment,
                places.get(element.job) if element.job is not None else None,
                draft.files[element.kind, element.link, element.index] if decomposed else (),
                tuple(tuple(float(v) for v in row) for row in element.link_from_shape),
                draft.inner_files.get((element.kind, element.link, element.index), ()),
            )
        )
    outcomes = [draft.outcomes[job] for job, _ in draft.meshes]
    loaded = tuple(outcomes)
    # Where visual meshes were taken, collision elements are there now.
    given = any(kind == "visual" for kind, _, _ in draft.files)
    findings: list[Finding] = [
        finding for finding in draft.read.findings if not (given and finding.code == "AP107")
    ]
    findings += located(
        draft.robot, draft.number, [draft.jobs[job] for job, _ in draft.meshes], outcomes
    )
    findings += [*draft.findings, *proof.findings]
    return RobotResult(
        name=draft.robot.name,
        source=draft.robot.path,
        urdf=draft.urdf,
        links={
            name: LinkResult(name, tuple(elements), loaded.__getitem__)
            for name, elements in links.items()
        },
        meshes=tuple(
            MeshResult(
                name=next(u.uri for u in draft.jobs[job].uses if u.robot == draft.number),
                digest=draft.jobs[job].digest,
                scale=draft.jobs[job].scale,
                links=tuple(
                    dict.fromkeys(
                        use.link for use in draft.jobs[job].uses if use.robot == draft.number
                    )
                ),
                treatment=done.outcome.state,
                facts=done.outcome.facts,
                key=draft.jobs[job].key,
                seconds=done.seconds,
            )
            for job, done in draft.meshes
        ),
        findings=tuple(findings),
        validation=proof.validation,
    )
