"""Every hard solid, as it is and changed, keeps every promise.

Each row runs as it is and with one of the changes, which rotate over the rows;
``benchmarks/hard_cases.py`` runs the full product.
"""

import guarantees
import pytest
from changes import CHANGES, huge, mirrored, permuted, plain, rotated, stored, tiny
from hard_solids import LARGE, SOLIDS, Solid

from assetpipe import decompose
from assetpipe.decomposition import Decomposition
from assetpipe.geometry import Mesh


def of(row: Solid, mesh: Mesh) -> tuple[Mesh, Decomposition]:
    """The solid that was decomposed, and the result."""
    d = decompose(mesh, row.epsilon(mesh), metric=row.metric, threads=1)
    assert row.hulls[0] <= len(d.hulls) <= row.hulls[1]
    if d.repair is None:
        return mesh, d
    assert d.repair.solid is not None
    return d.repair.solid, d


def promises(row: Solid, mesh: Mesh) -> None:
    solid, d = of(row, mesh)
    guarantees.check_hulls(solid, d)
    guarantees.check_cover(solid, d)
    guarantees.check_certificate(solid, d)
    guarantees.check_levels(solid, d)


def name(row: Solid) -> str:
    return f"{row.family}: {row.name}"


MIRRORED = (
    "deep hole wider than the tolerance",
    "deep hole wider, by concavity",
    "deep hole narrower, by concavity",
    "vessel with a small opening, by concavity",
    "tunnels that touch",
    "trefoil",
    "hollow ball 10^-3",
)
"""Rows that are unlike themselves in a mirror, or whose triangles are."""

# Of these families single precision would make other solids.
THIN = ("feature", "large", "needle", "thin")
ROTATING = [
    pytest.param(row, change, id=f"{name(row)}-{change.__name__}")
    for k, row in enumerate(SOLIDS)
    for change in (plain, CHANGES[1 + (k + k // 7) % 7])
]


@pytest.mark.parametrize(("row", "change"), ROTATING)
def test_a_hard_solid_keeps_every_promise(row: Solid, change):
    promises(row, change(row.mesh))


def test_a_large_solid():
    """The first of the large; ``benchmarks/hard_cases.py large`` runs all."""
    solid, d = of(LARGE[0], LARGE[0].mesh)
    guarantees.check_hulls(solid, d)
    guarantees.check_cover(solid, d, 100)


@pytest.mark.parametrize("row", SOLIDS, ids=name)
def test_parts_fill_the_solid_and_their_hulls_hold_them(row: Solid):
    turned = rotated if row.family in THIN else stored
    changes = (plain, mirrored, turned, tiny, turned, permuted, turned, huge)
    solid, d = of(row, changes[SOLIDS.index(row) % len(changes)](row.mesh))
    guarantees.check_parts(solid, d, guarantees.parts_of(solid, d.epsilon, row.metric))


@pytest.mark.parametrize("row", SOLIDS[::3], ids=name)
def test_orders_of_vertices_and_faces_change_no_bit(row: Solid):
    first, second = (of(row, change(row.mesh))[1] for change in (plain, permuted))
    assert len(first.nodes) == len(second.nodes)
    for a, b in zip(first.nodes, second.nodes, strict=True):
        assert a.hull.mesh.digest == b.hull.mesh.digest
        assert a.hull.certificate == b.hull.certificate


@pytest.mark.parametrize("row", [row for row in SOLIDS if row.name in MIRRORED], ids=name)
def test_mirror_images_have_as_many_hulls(row: Solid):
    first, second = (of(row, change(row.mesh))[1] for change in (plain, mirrored))
    assert len(first.hulls) == len(second.hulls)
    volumes = [sorted(hull.volume for hull in d.hulls) for d in (first, second)]
    assert volumes[0] == pytest.approx(volumes[1], rel=1e-2)


@pytest.mark.parametrize("row", SOLIDS[1::3], ids=name)
@pytest.mark.parametrize("times", [2.0**-20, 2.0**10])
def test_scales_by_powers_of_two_change_no_digit(row: Solid, times: float):
    first = of(row, row.mesh)[1]
    second = of(row, row.mesh.scaled(times))[1]
    assert len(first.nodes) == len(second.nodes)
    for a, b in zip(first.nodes, second.nodes, strict=True):
        assert (a.hull.vertices * times == b.hull.vertices).all()
