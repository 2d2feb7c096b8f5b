"""How a repair's finding is weighed."""

import pytest

from assetpipe.findings import Finding, Severity
from assetpipe.pipeline.mesh_task import graded

REPAIRED = Finding("AP201", Severity.WARNING, "closed 3 openings")


@pytest.mark.parametrize(
    ("moved", "severity"),
    [(1e-6, Severity.NOTE), (2e-5, Severity.NOTE), (2.1e-5, Severity.WARNING)],
)
def test_a_movement_below_a_hundredth_of_the_tolerance_is_a_note(moved, severity):
    finding = graded(REPAIRED, moved, 2e-3)
    assert finding.severity is severity
    assert finding.message.startswith("closed 3 openings; the surface moved by at most ")


def test_the_message_tells_millimetres_and_share():
    finding = graded(REPAIRED, 5e-6, 2e-3)
    assert finding.message.endswith("at most 0.005 mm, 0.25% of the tolerance")


def test_a_repair_that_moved_nothing_is_left_as_it_is():
    note = Finding("AP201", Severity.NOTE, "united 2 pieces")
    assert graded(note, 0.0, 2e-3) is note


def test_other_findings_keep_their_severity():
    opening = Finding("AP208", Severity.WARNING, "an opening")
    assert graded(opening, 1e-9, 2e-3) is opening
