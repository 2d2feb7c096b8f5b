from types import SimpleNamespace

import numpy as np
import pytest
import trimesh

from assetpipe.errors import ConfigError
from assetpipe.validation.profiles import (
    check_hulls,
    insphere_radius,
    load_profile,
    measure_hull,
)

SHIPPED = ["bullet", "mujoco", "physx_cpu", "physx_gpu"]


def shape(mesh):
    return SimpleNamespace(vertices=np.asarray(mesh.vertices), faces=np.asarray(mesh.faces))


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_profiles_pass_a_box(name):
    profile = load_profile(name)
    assert profile.name == name
    assert check_hulls([shape(trimesh.creation.box((0.1, 0.2, 0.3)))], profile) == ()


def test_measures_of_a_box():
    m = measure_hull(shape(trimesh.creation.box((1.0, 2.0, 4.0))))
    assert (m.vertices, m.triangles, m.polygons, m.faces_at_vertex) == (8, 12, 6, 3)
    assert m.insphere_radius == pytest.approx(0.5)
    assert m.insphere_ratio == pytest.approx(0.125)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e5])
def test_insphere_does_not_depend_on_unit_or_place(scale):
    cone = trimesh.creation.cone(radius=1.0, height=2.0, sections=64)
    reference = insphere_radius(shape(cone))
    assert reference == pytest.approx(2.0 / (1.0 + np.sqrt(5.0)), rel=2e-3)
    cone.apply_scale(scale)
    cone.apply_translation(np.full(3, 100.0 * scale))
    assert insphere_radius(shape(cone)) == pytest.approx(reference * scale, rel=1e-6)


def test_polygons_of_a_prism_and_faces_at_its_apex():
    cylinder = trimesh.creation.cylinder(1.0, 1.0, sections=40)
    hull = trimesh.convex.convex_hull(cylinder.vertices)
    assert measure_hull(shape(hull)).polygons == 42
    cone = trimesh.convex.convex_hull(trimesh.creation.cone(1.0, 1.0, sections=40).vertices)
    assert measure_hull(shape(cone)).faces_at_vertex == 40


def test_physx_gpu_says_what_is_wrong():
    ball = trimesh.creation.icosphere(2)
    plate = trimesh.creation.box((1.0, 1.0, 0.01))
    cone = trimesh.convex.convex_hull(trimesh.creation.cone(1.0, 1.0, sections=40).vertices)
    hulls = [shape(m) for m in (ball, plate, cone)]
    found = check_hulls(hulls, load_profile("physx_gpu"), link="arm")
    codes = {f.code: f for f in found}
    assert set(codes) == {"AP501", "AP502", "AP503", "AP504"}
    assert "hull 0 has 162, at most 64" in codes["AP501"].message
    assert "hull 1 has 0.005, at least 0.01" in codes["AP503"].message
    assert "hull 2 has 40, at most 32" in codes["AP504"].message
    assert all(f.link == "arm" for f in found)


def test_vertex_budget_of_a_profile():
    assert load_profile("physx_gpu").max_vertices == 64
    assert load_profile("physx_cpu").max_vertices == 255


def test_flat_hulls_have_no_insphere():
    flat = SimpleNamespace(
        vertices=np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), faces=np.array([[0, 1, 2]])
    )
    assert insphere_radius(flat) == 0.0


def test_unknown_profile_names_the_shipped_ones():
    with pytest.raises(ConfigError, match=r"'physx_gpo' not found; did you mean 'physx_gpu'\?"):
        load_profile("physx_gpo")


@pytest.mark.parametrize(
    ("rule", "told"),
    [
        ("{measure: vertices, reason: x}", "needs either at_most or at_least"),
        ("{measure: vertices, at_most: 1, at_least: 1, reason: x}", "needs either"),
        ("{measure: vertexes, at_most: 1, reason: x}", "vertexes.*allowed.*vertices"),
        ("{measure: vertices, at_mots: 1, reason: x}", "at_mots.*did you mean.*at_most"),
    ],
)
def test_wrong_profiles_are_refused_with_line_and_neighbours(tmp_path, rule, told):
    path = tmp_path / "mine.yaml"
    path.write_text(f"name: mine\ntitle: Mine\nrules:\n  - {rule}\n", encoding="utf-8")
    with pytest.raises(ConfigError, match=told) as caught:
        load_profile(path)
    assert caught.value.location.line == 4
