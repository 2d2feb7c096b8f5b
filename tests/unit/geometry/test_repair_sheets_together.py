"""Bodies of many sheets whose borders nearly meet, and how long a repair may take."""

from time import process_time

import numpy as np
import pytest
import trimesh

from assetpipe.geometry import Mesh, RepairLimits, RepairPolicy, Rung, is_solid, repair

GAP = 0.02


def in_sheets(shape: trimesh.Trimesh, gap: float) -> Mesh:
    """The six sides of a shape, each drawn together about its middle: open on all sides."""
    centres = shape.triangles_center - shape.centroid
    side = 2 * np.argmax(np.abs(centres), axis=1)
    side += centres[np.arange(len(centres)), side // 2] > 0
    vertices, faces = [], []
    for k in range(6):
        own = shape.triangles[side == k]
        middle = own.reshape(-1, 3).mean(axis=0)
        faces.append(np.arange(3 * len(own)).reshape(-1, 3) + 3 * sum(map(len, faces)))
        vertices.append((middle + (1.0 - gap) * (own - middle)).reshape(-1, 3))
    return Mesh(np.concatenate(vertices), np.concatenate(faces))


def test_sheets_that_nearly_meet_are_the_solid_that_they_enclose() -> None:
    shape = trimesh.creation.icosphere(subdivisions=3)
    result = repair(in_sheets(shape, GAP))
    assert result.solid is not None
    assert is_solid(result.solid)
    assert result.rung is Rung.WINDING
    assert result.solid.volume == pytest.approx(shape.volume, rel=0.03)
    assert result.deviation.p99 <= 0.01 * shape.scale


def test_sheets_far_apart_stay_sheets_and_are_told() -> None:
    shape = trimesh.creation.icosphere(subdivisions=3)
    result = repair(in_sheets(shape, 0.3))
    assert result.solid is not None
    assert result.rung is Rung.SHEET
    assert result.solid.volume < 0.1 * shape.volume
    assert any(finding.code == "AP208" for finding in result.findings)


def test_plane_sheets_far_apart_are_told_together() -> None:
    """None of them has an opening that its own cap would not lie on."""
    shape = trimesh.creation.box()
    result = repair(in_sheets(shape, 0.1))
    assert result.solid is not None
    assert result.rung is Rung.SHEET
    assert result.solid.volume < 0.2 * shape.volume
    (told,) = [finding for finding in result.findings if finding.code == "AP208"]
    assert told.message.startswith("6 open pieces")
    filled = repair(in_sheets(shape, 0.1), policy=RepairPolicy(openings="fill"))
    assert filled.solid is not None
    assert filled.solid.volume == pytest.approx(shape.volume, rel=0.05)


def test_plane_sheets_that_enclose_nothing_are_not_called_openings() -> None:
    square = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    beside = square.copy().apply_translation((1.01, 0, 0))
    both = trimesh.util.concatenate([square, beside])
    result = repair(Mesh(both.vertices, both.faces))
    assert result.rung is Rung.SHEET
    assert not any(finding.code == "AP208" for finding in result.findings)


def test_loose_faces_drawn_from_both_sides_are_the_solid_that_they_enclose() -> None:
    shape = trimesh.creation.icosphere(subdivisions=2)
    corners = shape.triangles + 1e-3 * (shape.triangles_center[:, None] - shape.triangles)
    faces = np.arange(3 * len(corners)).reshape(-1, 3)
    result = repair(Mesh(corners.reshape(-1, 3), np.vstack([faces, faces[:, ::-1]])))
    assert result.solid is not None
    assert result.solid.volume == pytest.approx(shape.volume, rel=0.01)


def test_sheets_stay_sheets_where_that_is_asked() -> None:
    shape = trimesh.creation.icosphere(subdivisions=3)
    result = repair(in_sheets(shape, GAP), policy=RepairPolicy(openings="sheet"))
    assert result.solid is not None
    assert result.rung is Rung.SHEET


@pytest.mark.parametrize("seconds", [0.02, 0.1, 0.4])
def test_the_time_limit_holds_within_steps(seconds: float) -> None:
    ball = trimesh.creation.icosphere(subdivisions=3)
    places = np.random.default_rng(5).random((60, 3)) * 4.0
    parts = [
        in_sheets(ball, GAP).transformed(trimesh.transformations.translation_matrix(at))
        for at in places
    ]
    offsets = np.cumsum([0, *(len(part.vertices) for part in parts)])
    mesh = Mesh(
        np.concatenate([part.vertices for part in parts]),
        np.concatenate([part.faces + at for part, at in zip(parts, offsets, strict=False)]),
    )
    clock = process_time()
    result = repair(mesh, limits=RepairLimits(seconds=seconds))
    assert result.solid is None
    assert [finding.code for finding in result.findings] == ["AP206"]
    assert process_time() - clock < seconds + 1.5
