"""Every defect of the corpus, as it is and changed in ways that must not matter."""

import numpy as np
import pytest
import trimesh
from mesh_defects import CASES, Case

from assetpipe.findings import Severity
from assetpipe.geometry import Mesh, is_solid, repair

_ROTATION = trimesh.transformations.rotation_matrix(1.1, [0.3, -0.7, 0.2])[:3, :3]


def as_is(mesh: Mesh) -> tuple[Mesh, float]:
    return mesh, 1.0


def rotated(mesh: Mesh) -> tuple[Mesh, float]:
    return Mesh(mesh.vertices @ _ROTATION.T, mesh.faces), 1.0


def mirrored(mesh: Mesh) -> tuple[Mesh, float]:
    return Mesh(mesh.vertices * [-1, 1, 1], mesh.faces), 1.0


def permuted(mesh: Mesh) -> tuple[Mesh, float]:
    random = np.random.default_rng(3)
    order = random.permutation(len(mesh.vertices))
    place = np.argsort(order)
    faces = place[mesh.faces][random.permutation(len(mesh.faces))]
    turns = random.integers(0, 3, len(faces))
    return Mesh(
        mesh.vertices[order], np.stack([np.roll(f, t) for f, t in zip(faces, turns, strict=True)])
    ), 1.0


def tiny(mesh: Mesh) -> tuple[Mesh, float]:
    return Mesh(mesh.vertices * 1e-6, mesh.faces), 1e-6


def huge(mesh: Mesh) -> tuple[Mesh, float]:
    return Mesh(mesh.vertices * 1e3, mesh.faces), 1e3


def far(mesh: Mesh) -> tuple[Mesh, float]:
    return Mesh(mesh.vertices + np.array([1e4, -2e4, 1.5e4]), mesh.faces), 1.0


def outcome(case: Case, mesh: Mesh, scale: float, blur: float = 0.0) -> None:
    result = repair(mesh)
    codes = {finding.code for finding in result.findings}
    assert set(case.codes) <= codes
    if case.outcome == "refused":
        assert result.solid is None
        assert any(finding.severity is Severity.ERROR for finding in result.findings)
        return
    assert result.solid is not None, [str(finding) for finding in result.findings]
    assert is_solid(result.solid)
    if case.outcome == "exact":
        assert result.moved <= blur
    elif case.outcome == "opened":
        assert result.moved > 0.001 * mesh.diagonal
    else:
        assert result.moved <= 0.0101 * mesh.diagonal + blur
    if case.volume is not None:
        expected = case.volume(mesh) if callable(case.volume) else case.volume * scale**3
        assert result.solid.volume == pytest.approx(
            expected, rel=case.accuracy + 100 * blur / mesh.diagonal
        )


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
@pytest.mark.parametrize("change", [as_is, rotated, mirrored, permuted, tiny, huge])
def test_a_defect_has_its_outcome(case: Case, change):
    mesh, scale = change(case.make())
    outcome(case, mesh, scale)


@pytest.mark.parametrize(
    "case",
    [case for case in CASES if "millionth" not in case.name and case.name != "needle"],
    ids=lambda case: case.name,
)
def test_a_defect_has_its_outcome_far_away(case: Case):
    """Rounding of the coordinates there is all that may change."""
    mesh, scale = far(case.make())
    outcome(case, mesh, scale, blur=1e-8)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_the_same_mesh_gives_the_same_bytes(case: Case):
    first, second = repair(case.make()), repair(case.make())
    assert first.as_dict() == second.as_dict()
    if first.solid is not None:
        assert first.solid.digest == second.solid.digest
