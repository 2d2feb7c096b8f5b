"""The same solid elsewhere, in a mirror and in another unit: the same number of hulls, as tight.

Rounding moves the vertices then, by up to a tenth of a billionth of the size here; a search that
let it decide between equal cuts would end with other parts.
"""

from functools import cache

import numpy as np
import pytest
from changes import far, huge, mirrored
from hard_solids import SOLIDS, Solid

from assetpipe import decompose
from assetpipe.decomposition import Decomposition
from assetpipe.geometry import Mesh

NAMES = (
    "grate of genus 16",
    "grate as an STL holds it",
    "cavity",
    "hollow body in a cavity",
    "interlocked rings",
    "deep hole wider, by concavity",
    "trefoil",
    "tube wall 10^-3",
    "tube wall 10^-5",
    "tubes in tubes",
)
"""Rows with ties, whose numbers of hulls changed with place or mirror once."""

ROWS = [row for row in SOLIDS if row.name in NAMES]


def upside_down(mesh: Mesh) -> Mesh:
    return mesh.scaled((1, 1, -1))


def beside(mesh: Mesh) -> Mesh:
    return Mesh(mesh.vertices + np.array([0.37, -1.21, 2.05]), mesh.faces)


def smaller(mesh: Mesh) -> Mesh:
    return mesh.scaled(0.37)


@cache
def as_it_is(row: Solid) -> Decomposition:
    return decompose(row.mesh, row.epsilon(row.mesh), metric=row.metric, threads=1)


def test_the_rows_are_there():
    assert len(ROWS) == len(NAMES)


@pytest.mark.parametrize("change", [mirrored, upside_down, beside, far, huge, smaller])
@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.name)
def test_place_mirror_and_unit_change_neither_count_nor_bound(row: Solid, change):
    mesh = change(row.mesh)
    d = decompose(mesh, row.epsilon(mesh), metric=row.metric, threads=1)
    plain = as_it_is(row)
    assert len(d.hulls) == len(plain.hulls)
    here, there = (x.certificate.upper / x.epsilon for x in (plain, d))
    assert here == pytest.approx(there, rel=0.02, abs=1e-3)
