"""Outlines from files."""

import json
from time import process_time

import numpy as np
import pytest
import shapely

from assetpipe import polygon
from assetpipe.errors import InputError, UsageError
from assetpipe.polygon.files import read_outlines

SQUARE = [[0, 0], [4, 0], [4, 4], [0, 4], [0, 0]]
HOLE = [[1, 1], [1, 2], [2, 2], [1, 1]]


def area(outline):
    return sum(p.area for p in polygon.decompose(list(outline.rings), 0.0).parts)


def test_geojson(tmp_path):
    path = tmp_path / "a.geojson"
    features = [
        {
            "type": "Feature",
            "properties": {"name": "plate"},
            "geometry": {"type": "Polygon", "coordinates": [SQUARE, HOLE]},
        },
        {"type": "Feature", "geometry": {"type": "Point", "coordinates": [0, 0]}},
    ]
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    (found,) = read_outlines(path)
    assert found.name == "plate"
    assert area(found) == pytest.approx(15.5)


@pytest.mark.parametrize(
    "text",
    [
        "x,y\n0,0\n4,0\n4,4\n0,4\n\n1,1\n1,2\n2,2\n",
        "x,y,ring\n0,0,a\n4,0,a\n1,1,b\n4,4,a\n0,4,a\n1,2,b\n2,2,b\n",
    ],
)
def test_csv(tmp_path, text):
    path = tmp_path / "a.csv"
    path.write_text(text)
    (found,) = read_outlines(path)
    assert area(found) == pytest.approx(15.5)


def test_svg_lines_and_curves(tmp_path):
    path = tmp_path / "a.svg"
    path.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg">'
        '<path id="plate" d="M0 0 H4 V4 H0 Z M1 1 V2 H2 Z"/>'
        '<path d="M 1 0 A 1 1 0 0 1 -1 0 A 1 1 0 0 1 1 0 Z"/></svg>'
    )
    plate, disc = read_outlines(path)
    assert plate.name == "plate"
    assert area(plate) == pytest.approx(15.5)
    assert area(disc) == pytest.approx(np.pi, rel=5e-3)
    assert shapely.Polygon(disc.rings[0]).is_valid


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.geojson", "{"),
        ("a.geojson", '{"type": "Polygon", "coordinates": [[[0, "x"], [1, 1], [2, 2]]]}'),
        ("a.geojson", '{"type": "Polygon", "coordinates": 3}'),
        ("a.geojson", '{"type": "Point"}'),
        ("a.csv", "0,0\n1\n"),
        ("a.csv", ""),
        ("a.svg", "<svg"),
        ("a.svg", '<svg xmlns="http://www.w3.org/2000/svg"><path d="M 0 0 L"/></svg>'),
        ("a.svg", '<svg xmlns="http://www.w3.org/2000/svg"/>'),
        ("a.geojson", '{"type": "FeatureCollection", "features": 5}'),
        ("a.geojson", '{"type": "GeometryCollection", "geometries": {"a": 1}}'),
        ("a.geojson", '{"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [NaN, 1]]]}'),
        (
            "a.geojson",
            f'{{"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [{10**400}, 1]]]}}',
        ),
        ("a.csv", "1" * 200_000 + ",2\n"),
        ("a.csv", "0,0\n1,0\ninf,1\n"),
        ("a.svg", '<svg><path d="z"/></svg>'),
        ("a.svg", '<svg><path d="M 0 0 A 1 1 0 7 1 1 1 z"/></svg>'),
    ],
)
def test_damaged_files_are_told_with_their_place(tmp_path, name, text):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        read_outlines(path)
    assert caught.value.location.file == path


def test_many_features_and_far_control_points_take_no_time(tmp_path):
    features = [{}] * 300_000 + [{"geometry": {"type": "Polygon", "coordinates": [SQUARE]}}]
    for feature in features[-1:]:
        feature["type"] = "Feature"
    many = tmp_path / "a.geojson"
    many.write_text(json.dumps({"type": "FeatureCollection", "features": features}))
    far = tmp_path / "a.svg"
    far.write_text('<svg><path d="M 0 0 C 1e200 1e200 -1e200 3 1 1 z"/></svg>')
    clock = process_time()
    assert len(read_outlines(many)) == len(read_outlines(far)) == 1
    assert process_time() - clock < 3.0


def test_entities_of_an_svg_are_not_expanded(tmp_path):
    secret = tmp_path / "secret"
    secret.write_text("M0 0 H4 V4 Z")
    path = tmp_path / "a.svg"
    path.write_text(
        f'<!DOCTYPE svg [<!ENTITY e SYSTEM "{secret.as_uri()}">]>'
        '<svg xmlns="http://www.w3.org/2000/svg"><path>&e;</path></svg>'
    )
    with pytest.raises(InputError, match="no polygon"):
        read_outlines(path)


def test_unknown_suffix(tmp_path):
    with pytest.raises(UsageError, match="known are"):
        read_outlines(tmp_path / "a.dxf")
