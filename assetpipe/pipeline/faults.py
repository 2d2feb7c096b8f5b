"""What an executor's fault means for a mesh."""

from __future__ import annotations

from dataclasses import replace

from assetpipe.findings import Finding, Severity
from assetpipe.pipeline.executors import Fault, Reply
from assetpipe.pipeline.outcome import MeshOutcome

_CRASHES = {"start": "AP102", "read": "AP102", "repair": "AP202", "certify": "AP411"}
"""What the death of a process means, by what it was doing; else the engine has failed."""


def outcome_of(reply: Reply) -> MeshOutcome:
    """A reply as an outcome: a fault becomes a finding on its mesh."""
    if reply.fault is None and reply.payload is not None:
        return MeshOutcome.decode(reply.payload)
    fault = reply.fault or Fault("exception", "start", "no answer")
    finding = finding_of_fault(fault)
    if reply.payload is None:
        return MeshOutcome("kept", (), (finding,), {})
    partial = MeshOutcome.decode(reply.payload)
    return replace(partial, findings=(*partial.findings, finding))


def finding_of_fault(fault: Fault) -> Finding:
    """What a user should know about a fault."""
    doing = f"while at '{fault.stage}'"
    if fault.stage == "validate":
        return Finding(
            "AP411", Severity.WARNING, f"contact truth could not be told: {fault.message}"
        )
    if fault.stage == "inner":
        told = f"inner hulls could not be computed, and nothing was validated: {fault.message}"
        return Finding("AP305", Severity.WARNING, told)
    if fault.kind in ("time", "memory"):
        code = "AP301" if fault.stage == "decompose" else "AP206"
        limit = "seconds" if fault.kind == "time" else "memory"
        return Finding(
            code, Severity.ERROR, f"{fault.message} {doing}", hint=f"raise limits.{limit}"
        )
    if fault.kind == "crash":
        code = _CRASHES.get(fault.stage, "AP303")
        return Finding(code, Severity.ERROR, f"{fault.message} {doing}")
    return Finding("AP901", Severity.ERROR, f"{fault.message} {doing}")
