"""Inner hulls cost no hull: what fails while they are sought is a finding."""

from typing import Any

import numpy as np
import pytest

from assetpipe.findings import Finding, Severity
from assetpipe.geometry.mesh import Mesh
from assetpipe.pipeline.executors import Fault, Reply
from assetpipe.pipeline.faults import outcome_of
from assetpipe.pipeline.mesh_task import _inner
from assetpipe.pipeline.outcome import HullOutcome, MeshOutcome
from assetpipe.pipeline.stages import Silent

TETRAHEDRON = Mesh(
    np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]]),
    np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]),
)


@pytest.mark.parametrize("kind", ["time", "memory", "crash", "exception"])
def test_the_end_of_the_process_keeps_the_hulls(kind: Any) -> None:
    partial = MeshOutcome(
        "decomposed", (HullOutcome(TETRAHEDRON, (0.0, 0.1)),), (), {"hulls": 1}, TETRAHEDRON
    )
    outcome = outcome_of(Reply(partial.encode(), Fault(kind, "inner", "it ended"), 1.0))
    assert outcome.state == "decomposed"
    assert len(outcome.hulls) == 1
    assert outcome.inner == ()
    (finding,) = outcome.findings
    assert (finding.code, finding.severity) == ("AP305", Severity.WARNING)
    assert "it ended" in finding.message


def test_a_convex_solid_is_filled() -> None:
    facts: dict[str, Any] = {"tolerance": 0.01}
    findings: list[Finding] = []
    (found,) = _inner(TETRAHEDRON, facts, findings, Silent())
    assert found.volume == pytest.approx(1 / 6, rel=1e-4)
    assert facts["inner"]["hulls"] == 1
    assert facts["inner"]["vertices"] == 4
    assert facts["inner"]["share"] == pytest.approx(1.0, abs=1e-4)
    assert not findings


def test_what_is_no_solid_has_none() -> None:
    facts: dict[str, Any] = {"tolerance": 0.01}
    findings: list[Finding] = []
    open_mesh = Mesh(TETRAHEDRON.vertices, TETRAHEDRON.faces[:3])
    assert _inner(open_mesh, facts, findings, Silent()) == ()
    assert [finding.code for finding in findings] == ["AP305"]
    assert findings[0].severity is Severity.WARNING
    assert "inner" not in facts
