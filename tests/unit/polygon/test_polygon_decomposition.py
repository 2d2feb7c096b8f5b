"""Approximate convex decomposition of polygons, against shapely as an independent judge."""

import numpy as np
import pytest
import shapely
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from assetpipe import polygon
from assetpipe.errors import InputError, UsageError

MEASURES = ["sl", "sp", "h1", "h2"]
L_SHAPE = shapely.Polygon([(0, 0), (4, 0), (4, 1), (1, 1), (1, 4), (0, 4)])


def assert_is_decomposition(outline, parts, *, exact=False):
    """Parts are valid, their union has the outline's area to 1e-12, interiors are disjoint."""
    total = sum(part.area for part in parts)
    assert abs(total - outline.area) <= 1e-12 * outline.area
    assert all(part.is_valid for part in parts)
    # equal areas of sum and union: no overlap; union inside the outline: no surplus
    union = shapely.union_all(parts)
    assert abs(union.area - total) <= 1e-10 * outline.area
    assert union.difference(outline).area <= 1e-10 * outline.area
    if exact:
        assert all(part.convex_hull.area - part.area <= 1e-12 * outline.area for part in parts)


@st.composite
def outlines(draw):
    """Star-shaped and folded rings with holes, collinear runs and duplicate vertices."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    n = draw(st.integers(3, 50))
    kind = draw(st.sampled_from(["star", "spiral", "grid"]))
    if kind == "grid":
        cells = rng.random((rng.integers(2, 7), rng.integers(2, 7))) < 0.7
        boxes = [shapely.box(x, y, x + 1, y + 1) for y, x in np.argwhere(cells)]
        shape = shapely.union_all(boxes) if boxes else shapely.box(0, 0, 1, 1)
        shape = max(getattr(shape, "geoms", [shape]), key=lambda g: g.area)
    elif kind == "spiral":
        t = np.linspace(0, rng.uniform(1, 12), n)
        r = 2 + t + rng.uniform(0, 0.6, n)
        outer = np.c_[(r + 1) * np.cos(t), (r + 1) * np.sin(t)]
        inner = np.c_[r * np.cos(t), r * np.sin(t)]
        shape = shapely.Polygon(np.vstack([outer, inner[::-1]]))
    else:
        t = np.sort(rng.uniform(0, 2 * np.pi, n))
        r = rng.uniform(0.4, 1, n) * 10
        shape = shapely.Polygon(np.c_[r * np.cos(t), r * np.sin(t)])
        if not shape.is_valid:
            return L_SHAPE
        for _ in range(draw(st.integers(0, 4))):
            centre = shapely.Point(*rng.uniform(-4, 4, 2))
            hole = centre.buffer(rng.uniform(0.2, 1.5), quad_segs=int(rng.integers(1, 4)))
            shape = shape.difference(hole)
            shape = max(getattr(shape, "geoms", [shape]), key=lambda g: g.area, default=shape)
    if not shape.is_valid or shape.geom_type != "Polygon" or shape.area < 1e-3:
        return L_SHAPE
    return shape


@settings(max_examples=120, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(outlines(), st.sampled_from(MEASURES))
def test_every_level_is_a_decomposition_within_its_tolerance(outline, measure):
    finest = polygon.decompose(outline, 0.0, concavity=measure)
    assert_is_decomposition(outline, finest.parts, exact=True)  # Theorem 6.4
    assert finest.concavity == 0
    assert finest.convexity == pytest.approx(1.0, abs=1e-12)
    for tolerance in (0.05, 0.5, 5.0, 1e9):
        level = finest.at(tolerance)
        assert_is_decomposition(outline, level.parts)
        assert level.concavity <= tolerance
        assert len(level.parts) <= len(finest.parts)
        if measure != "h2":
            again = polygon.decompose(outline, tolerance, concavity=measure)
            assert len(again.parts) == len(level.parts)
            assert again.concavity == level.concavity


@settings(max_examples=80, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(outlines(), st.sampled_from(["sp", "h1"]))
def test_lemma_5_3_concavity_decreases_monotonically(outline, measure):
    finest = polygon.decompose(outline, 0.0, concavity=measure)
    for after, before in finest._levels.descents():
        assert after <= before * (1 + 1e-9)


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(outlines(), st.floats(0, 2 * np.pi))
def test_straight_lines_never_measure_more_than_shortest_paths(outline, angle):
    turned = shapely.affinity.rotate(outline, angle, use_radians=True)
    if turned.interiors:
        turned = shapely.Polygon(turned.exterior)
    straight = polygon.decompose(turned, 1e9, concavity="sl").concavity
    shortest = polygon.decompose(turned, 1e9, concavity="sp").concavity
    hybrid = polygon.decompose(turned, 1e9, concavity="h1").concavity
    assert straight <= shortest * (1 + 1e-9)
    assert straight * (1 - 1e-9) <= hybrid <= shortest * (1 + 1e-9)


def test_arrays_and_shapely_give_the_same_parts():
    hole = [(0.2, 0.2), (0.6, 0.2), (0.4, 0.6)]
    shape = shapely.Polygon(L_SHAPE.exterior.coords, [hole])
    arrays = (np.array(L_SHAPE.exterior.coords), [np.array(hole)])
    one = polygon.decompose(shape, 0.1)
    assert one.parts == polygon.decompose(arrays, 0.1).parts
    assert one.concavities == polygon.decompose(arrays, 0.1).concavities


def test_a_coarse_tolerance_leaves_the_outline_whole():
    frame = L_SHAPE.buffer(1).difference(L_SHAPE.buffer(-0.2))
    whole = polygon.decompose(frame, 1e9)
    assert len(whole.parts) == 1
    assert whole.parts[0].equals(frame)


def test_redundant_vertices_change_nothing():
    ring = np.array(L_SHAPE.exterior.coords)
    dense = np.repeat(shapely.segmentize(L_SHAPE, 0.25).exterior.coords[:-1], 2, axis=0)
    assert polygon.decompose(dense, 0.0).parts == polygon.decompose(ring, 0.0).parts


@pytest.mark.parametrize("axis", ["principal", "medial"])
def test_hole_axes_of_a_winding_hole(axis):
    """Fig. 12a: along its principal axis a winding hole looks short."""
    t = np.linspace(0.5, 9, 60)
    line = shapely.LineString(np.c_[t * np.cos(t), t * np.sin(t)])
    outline = shapely.box(-12, -12, 12, 12).difference(line.buffer(0.3))
    found = polygon.decompose(outline, 0.0, hole_axis=axis)
    assert_is_decomposition(outline, found.parts, exact=True)
    depth = polygon.decompose(outline, 1e9, hole_axis=axis).concavity
    assert depth > line.length * 0.9 if axis == "medial" else depth < line.length * 0.9


@pytest.mark.parametrize("scale", [1e-9, 1e-3, 1e6])
def test_far_small_and_large(scale):
    big = shapely.affinity.scale(L_SHAPE.buffer(0.3), scale, scale, origin=(0, 0))
    moved = shapely.affinity.translate(big, 3e5 * scale, -2e5 * scale)
    assert_is_decomposition(moved, polygon.decompose(moved, 0.0).parts)


@pytest.mark.parametrize("measure", MEASURES)
def test_a_hundred_thousand_vertices(measure):
    n = 100_000
    t = np.linspace(0, 2 * np.pi, n, endpoint=False)
    noise = np.random.default_rng(1).normal(size=n)
    r = 10 + 2 * np.sin(5 * t) + 0.001 * noise
    outline = np.c_[r * np.cos(t), r * np.sin(t)]
    found = polygon.decompose(outline, 0.1, concavity=measure)
    area = shapely.Polygon(outline).area
    assert abs(sum(part.area for part in found.parts) - area) <= 1e-12 * area
    assert found.concavity <= 0.1
    assert len(found.parts) < 100  # of 50,000 notches


def test_a_long_spiral_of_a_hundred_thousand_vertices():
    t = np.linspace(0.3, 50, 50_000)
    arm = [np.c_[(1 + t + s) * np.cos(t), (1 + t + s) * np.sin(t)] for s in (2.5, 0)]
    outline = shapely.Polygon(np.vstack([arm[0], arm[1][::-1]]))
    found = polygon.decompose(outline, 0.1)
    assert abs(sum(part.area for part in found.parts) - outline.area) <= 1e-12 * outline.area
    assert found.concavity <= 0.1


def test_refusals_say_what_is_wrong():
    with pytest.raises(InputError, match="crosses the edge"):
        polygon.decompose([(0, 0), (2, 2), (2, 0), (0, 2)], 0.1)
    with pytest.raises(InputError, match="no area"):
        polygon.decompose([(0, 0), (1, 1), (2, 2)], 0.1)
    with pytest.raises(InputError, match="vertex 1"):
        polygon.decompose([(0, 0), (np.inf, 1), (2, 2)], 0.1)
    with pytest.raises(UsageError, match="did you mean"):
        polygon.decompose(L_SHAPE, 0.1, concavity="spp")
    with pytest.raises(UsageError, match="tolerance"):
        polygon.decompose(L_SHAPE, -1.0)
    with pytest.raises(UsageError, match="finer"):
        polygon.decompose(L_SHAPE, 0.5).at(0.1)
