"""Targets that are not remembered: read, decompose, write, prove."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence

from assetpipe.findings import Finding
from assetpipe.pipeline.batch import Batch, Built
from assetpipe.pipeline.conclude import conclude
from assetpipe.pipeline.executors.choose import cores, executor_for
from assetpipe.pipeline.fingerprint import fingerprint
from assetpipe.pipeline.identity import digest_mesh
from assetpipe.pipeline.memory import remember
from assetpipe.pipeline.package import Draft, Worked, draft
from assetpipe.pipeline.plan import make_plan
from assetpipe.pipeline.progress import Progress
from assetpipe.pipeline.proof import prove
from assetpipe.pipeline.reading import Read, read_sources
from assetpipe.pipeline.run import run_jobs
from assetpipe.pipeline.targets import Target


def compute(
    batch: Batch, targets: Sequence[Target], prints: Mapping[Target, str | None]
) -> tuple[dict[Target, Built], tuple[Finding, ...]]:
    """One result a target that could be read, and findings about those that could not.

    All meshes of all targets are worked on side by side; then the targets are written
    and proved, a few at a time, each complete before it takes its place.
    """
    batch.on_progress(Progress("read", targets[0].source.path.name, 0, 0))
    by_source = {target.source: target for target in targets}
    found, lost = read_sources([target.source for target in targets])
    results: dict[Target, Built] = {}
    keys = dict(prints)
    read: list[Read] = []
    for item in found:
        target = by_source[item.source]
        if keys[target] is None and item.source.kind == "robot":
            # A xacro file can be judged now that it is expanded.
            keys[target] = fingerprint(item.source, batch.config, item.robot.source)
            known = batch.recall(target, keys[target])
            if known is not None:
                results[target] = known
                continue
        read.append(item)
    plan = make_plan([item.robot for item in read], batch.config, digest_mesh)
    with executor_for(batch.config.jobs, batch.cluster) as executor:
        done = run_jobs(
            plan.jobs,
            executor=executor,
            cache=batch.cache,
            limits=batch.config.limits,
            on_progress=batch.on_progress,
            cancelled=batch.cancelled,
        )
    worked = Worked(plan.jobs, done)
    width = batch.config.jobs or cores()
    for start in range(0, len(read), width):
        group = range(start, min(start + width, len(read)))
        with contextlib.ExitStack() as stack:
            drafts: list[Draft] = []
            for number in group:
                batch.stop_if_cancelled()
                item = read[number]
                target = by_source[item.source]
                batch.on_progress(
                    Progress("write", item.robot.name, len(plan.jobs), len(plan.jobs))
                )
                stage = stack.enter_context(batch.stage(target))
                drafts.append(draft(stage, item, number, worked, batch.config))
            proofs = prove(
                drafts,
                batch.config,
                jobs=width,
                on_progress=batch.on_progress,
                cancelled=batch.cancelled,
            )
            for finished, proof in zip(drafts, proofs, strict=True):
                target = by_source[finished.read.source]
                robot, outputs, inputs = conclude(finished, proof, batch.config)
                key = keys[target] if remembered(finished) else None
                if key is not None:
                    stage = finished.stage
                    remember(batch.cache, key, robot, stage, outputs=outputs, inputs=inputs)
                changed = batch.settle(finished.stage)
                results[target] = Built(target, robot, changed, key)
    return results, lost


def remembered(finished: Draft) -> bool:
    """Whether the result would be the same next time: not if a limit of time or memory,
    or a crash, has shaped it."""
    return all(done.fault is None for _, done in finished.meshes)
