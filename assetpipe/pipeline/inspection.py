"""The health of every mesh: read, examined, and repaired on trial."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from assetpipe.findings import Finding
from assetpipe.pipeline.cache import Cache
from assetpipe.pipeline.config import Config
from assetpipe.pipeline.executors import Executor
from assetpipe.pipeline.executors.task import Cancelled
from assetpipe.pipeline.identity import digest_mesh
from assetpipe.pipeline.inputs import find_sources
from assetpipe.pipeline.locate import located
from assetpipe.pipeline.plan import MeshJob, make_plan
from assetpipe.pipeline.progress import Listener, Token, cancelled_by, silent
from assetpipe.pipeline.reading import read_sources
from assetpipe.pipeline.result import exit_code
from assetpipe.pipeline.run import Done, run_jobs


@dataclass(frozen=True)
class Inspection:
    """What is known about every distinct mesh.

    Attributes:
        meshes: a job and what it found, in order of first use.
        findings: about robots and meshes.
    """

    meshes: tuple[tuple[MeshJob, Done], ...]
    findings: tuple[Finding, ...]

    @property
    def exit_code(self) -> int:
        """0 fine, 1 findings, 3 a fault of ours."""
        return exit_code(self.findings)

    def as_dict(self) -> dict[str, Any]:
        """JSON-ready."""
        return {
            "meshes": [
                {
                    "name": job.uses[0].uri,
                    "file": str(job.path),
                    "scale": list(job.scale),
                    "links": list(dict.fromkeys(use.link for use in job.uses)),
                    **done.outcome.facts,
                }
                for job, done in self.meshes
            ],
            "findings": [finding.as_dict() for finding in self.findings],
        }


def inspect(
    inputs: Sequence[Path],
    *,
    config: Config,
    cache: Cache,
    executor: Executor,
    on_progress: Listener = silent,
    cancel: Token | Cancelled | None = None,
) -> Inspection:
    """Examine every distinct mesh of the inputs.

    Args:
        inputs: files and folders.
        config: ``source``, ``repair``, ``cavities`` and ``limits`` matter.
        cache: of outcomes.
        executor: where the meshes are worked on.
        on_progress: hears of it.
        cancel: stops it.

    Raises:
        InputError: a named input cannot be read.
        CancelledError: ``cancel`` said so.
    """
    read, lost = read_sources(find_sources(inputs))
    plan = make_plan([item.robot for item in read], config, digest_mesh)
    jobs = tuple(replace(job, until="repair", contact=None) for job in plan.jobs)
    done = run_jobs(
        jobs,
        executor=executor,
        cache=cache,
        limits=config.limits,
        on_progress=on_progress,
        cancelled=cancelled_by(cancel),
    )
    findings = list(lost)
    for number, item in enumerate(read):
        findings += item.findings
        findings += located(item.robot, number, jobs, [d.outcome for d in done])
    return Inspection(tuple(zip(jobs, done, strict=True)), tuple(findings))
