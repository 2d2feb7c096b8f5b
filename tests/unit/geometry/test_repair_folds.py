"""Folds without thickness, and what is left of a surface without them."""

import numpy as np
import pytest
import trimesh
from jobs import job_on

from assetpipe import decompose
from assetpipe.geometry import Mesh, RepairPolicy, is_solid, repair
from assetpipe.geometry.repair.unfold import folds, unfolded, without_folds
from assetpipe.geometry.repair.unite import Shell
from assetpipe.geometry.repair.work import Work
from assetpipe.validation.contact import contact_truth


def with_flap(reach, rise=0.0):
    """A unit box whose upper side reaches beyond its edge and comes back."""
    box = trimesh.creation.box()
    vertices, faces = np.asarray(box.vertices), box.faces.tolist()
    upper = [f for f in faces if all(vertices[v, 2] > 0 for v in f)]
    rest = [f for f in faces if f not in upper]
    ends = set(upper[0]) & set(upper[1])
    tip = len(vertices)
    for face in upper:
        apex = next(v for v in face if v not in ends)
        at = face.index(apex)
        first, second = face[(at + 1) % 3], face[(at + 2) % 3]
        rest += [[apex, first, tip], [apex, tip, second]]
    return Mesh(np.vstack([vertices, [0.5 + reach, 0.1, 0.5 + rise]]), np.array(rest))


def crumpled(seed):
    """A box with a fine upper side whose inner vertices lie anywhere near their place."""
    random = np.random.default_rng(seed)
    box = trimesh.creation.box().subdivide().subdivide().subdivide()
    vertices = np.array(box.vertices)
    inner = (vertices[:, 2] > 0.499) & (np.abs(vertices[:, :2]).max(axis=1) < 0.499)
    vertices[inner, :2] += random.uniform(-0.12, 0.12, (int(inner.sum()), 2))
    return Mesh(vertices, np.asarray(box.faces))


def shell(mesh):
    return Shell.of(mesh.vertices, mesh.faces)


def area(mesh):
    return trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).area


def test_a_flap_is_taken_out_and_its_reach_is_told():
    mesh = with_flap(0.01)
    assert folds(mesh.vertices, mesh.faces)
    result = repair(mesh)
    assert is_solid(result.solid)
    assert "folds without thickness" in result.steps[-1].what
    assert not folds(result.solid.vertices, result.solid.faces)
    np.testing.assert_allclose(result.solid.vertices.max(axis=0), 0.5, atol=1e-15)
    assert result.solid.volume == pytest.approx(1.0, rel=1e-12)
    assert 0.01 - 1e-12 <= result.deviation.removed <= 0.0106
    assert result.deviation.added < 1e-9
    assert result.steps[-1].moved == pytest.approx(result.moved)


def with_slit():
    """A unit box into which a slit of no width goes from the diagonal of its upper side."""
    box = trimesh.creation.box()
    vertices, faces = np.asarray(box.vertices), box.faces.tolist()
    upper = [f for f in faces if all(vertices[v, 2] > 0 for v in f)]
    rest = [f for f in faces if f not in upper]
    ends = set(upper[0]) & set(upper[1])
    tip, middles = len(vertices), (len(vertices) + 1, len(vertices) + 2)
    for face, middle in zip(upper, middles, strict=True):
        apex = next(v for v in face if v not in ends)
        at = face.index(apex)
        first, second = face[(at + 1) % 3], face[(at + 2) % 3]
        rest += [[apex, first, middle], [apex, middle, second]]
        rest += [[middle, first, tip], [second, middle, tip]]
    return Mesh(np.vstack([vertices, np.zeros(3), [[0, 0, 0.5]] * 2]), np.array(rest))


@pytest.mark.parametrize("beside", ["a void", "a body"])
def test_layers_taken_out_inside_are_measured_again_where_voids_are(beside):
    """What lies inside a piece may be in a void that is taken from it later."""
    slit = shell(with_slit())
    inside = without_folds(slit).inside
    assert inside[:, :, 2].min() == 0.0
    small = shell(Mesh.of(trimesh.creation.box((0.5, 0.5, 0.5))))
    pieces = (slit, small.reversed() if beside == "a void" else small)
    work = Work(slit.vertices, slit.faces[:0], shells=pieces)
    after = unfolded(work, job_on(with_slit()))
    assert "folds" in after.steps[-1].what
    np.testing.assert_array_equal(after.lost, inside if beside == "a void" else inside[:0])


def test_layers_beside_a_piece_are_not_measured_twice():
    folded = without_folds(shell(with_flap(0.004)))
    assert folded.folds
    assert not len(folded.inside)


def test_strict_repair_keeps_what_is_a_solid_with_its_folds():
    mesh = with_flap(0.01)
    result = repair(mesh, policy=RepairPolicy(mode="strict"))
    assert result.solid is not None
    assert result.moved == 0.0
    np.testing.assert_array_equal(result.solid.vertices, mesh.vertices)


def test_a_flap_that_reaches_beyond_the_budget_stays():
    mesh = with_flap(0.3)
    result = repair(mesh)
    np.testing.assert_array_equal(result.solid.vertices, mesh.vertices)
    assert result.moved == 0.0
    assert any("reach too far" in note for note in result.notes)


@pytest.mark.parametrize("rise", [1e-3, -1e-3])
def test_what_has_material_or_air_between_is_no_fold(rise):
    mesh = with_flap(0.01, rise)
    assert not folds(mesh.vertices, mesh.faces)
    assert repair(mesh).moved == 0.0


@pytest.mark.parametrize("seed", range(12))
def test_the_solid_stays_and_little_of_it_lies_double(seed):
    mesh = crumpled(seed)
    found = folds(mesh.vertices, mesh.faces)
    assert found
    result = without_folds(shell(mesh))
    assert result.folds == len(found)
    parts = [Mesh(s.vertices, s.faces) for s in result.shells]
    whole = trimesh.util.concatenate(
        [trimesh.Trimesh(p.vertices, p.faces, process=False) for p in parts]
    )
    # Where layers wind around a point more than once, no step makes them less.
    assert 6.0 - 1e-12 <= whole.area <= 6.0 + 0.2 * (area(mesh) - 6.0)
    assert whole.is_watertight
    assert whole.volume == pytest.approx(1.0, rel=1e-12)
    assert max(result.removed, result.added) < 1e-4


def test_the_same_comes_out_whatever_the_place_and_size():
    mesh = with_flap(0.01)
    plain = repair(mesh).solid
    moved = repair(Mesh(mesh.vertices * 2.0**-20 + [4.0, -2.0, 8.0], mesh.faces)).solid
    assert len(moved.faces) == len(plain.faces)


def test_hulls_of_a_folded_solid_hold_all_of_it():
    mesh = crumpled(3)
    made = decompose(mesh, 0.02)
    assert made.repair is not None
    assert len(made.hulls) == 1
    low, high = made.hulls[0].vertices.min(axis=0), made.hulls[0].vertices.max(axis=0)
    assert (mesh.vertices >= low).all()
    assert (mesh.vertices <= high).all()


def test_nothing_has_to_cover_a_flap_without_thickness():
    box = trimesh.creation.box()
    truth = contact_truth(with_flap(0.3), [Mesh.of(box)], 1e-9, samples=100)
    assert truth.coverage.complete
    thin = contact_truth(with_flap(0.3, 1e-5), [Mesh.of(box)], 1e-9, samples=100)
    assert not thin.coverage.complete
    assert thin.coverage.gap == pytest.approx(0.3, rel=1e-3)
