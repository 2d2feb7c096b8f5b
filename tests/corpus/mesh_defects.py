"""Meshes with one defect each, and what repair must make of them.

All are about one metre in size and centred near the origin; the tests rotate, mirror,
permute, scale and move them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from mesh_parts import (
    box,
    coil,
    divided_box,
    doubled,
    exploded,
    flat_square,
    hollow,
    inverted,
    join,
    klein_bottle,
    lid_off,
    loose,
    mesh,
    pinched,
    sheet,
    soup,
    sphere,
    sphere_volume,
    strip,
    tetrahedron,
    thick,
    turned,
    two_halves,
    welded,
    with_flap,
    with_junction,
    without,
)

from assetpipe.geometry import Mesh


@dataclass(frozen=True)
class Case:
    """A defect and its outcome.

    Attributes:
        name: of the row.
        make: the mesh.
        outcome: ``"exact"``: a solid, the surface nowhere moved; ``"near"``: a solid within
            the budget; ``"opened"``: a solid that lacks a wall without thickness, whose reach
            is told; ``"refused"``: no solid, and a finding says why.
        volume: of the solid, m³, or a function of the changed mesh; ``None`` if there is no
            simple number.
        accuracy: relative, of the volume.
        codes: finding codes that must be among the result's.
    """

    name: str
    make: Callable[[], Mesh]
    outcome: Literal["exact", "near", "opened", "refused"]
    volume: float | Callable[[Mesh], float] | None = None
    accuracy: float = 1e-9
    codes: tuple[str, ...] = ()


_SQUARE_OUT = flat_square([[0.5, -0.5, 0.5], [0.5, 0.5, 0.5], [0.9, 0.5, 0.9], [0.9, -0.5, 0.9]])
_SQUARE_IN = flat_square([[0.5, -0.5, 0.5], [0.5, 0.5, 0.5], [0.0, 0.5, 0.0], [0.0, -0.5, 0.0]])
_BALL = 4 / 3 * np.pi * 0.125

CASES: tuple[Case, ...] = (
    Case("box", lambda: mesh(box()), "exact", 1.0),
    Case("sphere", lambda: mesh(sphere()), "exact"),
    Case("triangle soup", lambda: mesh(soup(box())), "exact", 1.0),
    Case("soup of a sphere", lambda: mesh(soup(sphere())), "exact"),
    Case(
        "soup quantised to float32",
        lambda: mesh((soup(sphere(4))[0].astype(np.float32).astype(float), soup(sphere(4))[1])),
        "exact",
    ),
    Case("inside-out", lambda: mesh(inverted(box())), "exact", 1.0),
    Case(
        "one face turned",
        lambda: mesh((box()[0], np.vstack([box()[1][:1, ::-1], box()[1][1:]]))),
        "near",
        1.0,
    ),
    Case(
        "every other face turned",
        lambda: mesh(
            (
                sphere()[0],
                np.where(np.arange(1280)[:, None] % 2, sphere()[1], sphere()[1][:, ::-1]),
            )
        ),
        "near",
        sphere_volume(3, 0.5),
    ),
    Case(
        "two boxes overlap",
        lambda: mesh(join(box(), box(at=(0.5, 0.25, 0.125)))),
        "exact",
        2 - 0.5 * 0.75 * 0.875,
    ),
    Case("boxes share a face", lambda: mesh(soup(join(box(), box(at=(1, 0, 0))))), "exact", 2.0),
    Case(
        "boxes touch over half a face", lambda: mesh(join(box(), box(at=(1, 0.5, 0)))), "exact", 2.0
    ),
    Case("boxes share an edge", lambda: mesh(soup(join(box(), box(at=(1, 1, 0))))), "exact", 2.0),
    Case("boxes share a corner", lambda: mesh(soup(join(box(), box(at=(1, 1, 1))))), "exact", 2.0),
    Case("one edge touched all around", lambda: mesh(pinched()), "exact", 6.0),
    Case(
        "bow-tie of two tetrahedra at a vertex",
        lambda: mesh(
            welded(
                join(
                    tetrahedron([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]),
                    tetrahedron([[0, 0, 0], [-1, 0, 0], [0, -1, 0], [0, 0, -1]]),
                )
            )
        ),
        "exact",
        1 / 3,
    ),
    Case(
        "bow-tie of two tetrahedra at an edge",
        lambda: mesh(
            welded(
                join(
                    tetrahedron([[0, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0]]),
                    tetrahedron([[0, 0, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0]]),
                )
            )
        ),
        "exact",
        1 / 3,
    ),
    Case(
        "cavity",
        lambda: mesh(join(box(), inverted(box((0.5, 0.5, 0.5))))),
        "exact",
        0.875,
        codes=("AP207",),
    ),
    Case(
        "cavity, all inside-out",
        lambda: mesh(inverted(join(box(), inverted(box((0.5, 0.5, 0.5)))))),
        "exact",
        0.875,
        codes=("AP207",),
    ),
    Case(
        "cavity, every tenth face turned",
        lambda: mesh(join(sphere(), turned(inverted(sphere(2, 0.3)), 10))),
        "exact",
        sphere_volume(3, 0.5) - sphere_volume(2, 0.3),
        codes=("AP207",),
    ),
    Case(
        "cavity, all inside-out, every tenth face turned",
        lambda: mesh(turned(inverted(join(sphere(), inverted(sphere(2, 0.3)))), 10)),
        "exact",
        sphere_volume(3, 0.5) - sphere_volume(2, 0.3),
        codes=("AP207",),
    ),
    Case(
        "cavity, faces loose, some twice",
        lambda: mesh(loose(hollow(), slice(2, None, 5))),
        "near",
        0.875,
        accuracy=1e-7,
        codes=("AP207",),
    ),
    Case(
        "faces loose, some from both sides",
        lambda: mesh(loose(sphere(), slice(0, None, 5), -1)),
        "near",
        sphere_volume(3, 0.5),
        accuracy=1e-7,
    ),
    Case(
        "body in a cavity",
        lambda: mesh(join(box(), inverted(box((0.5, 0.5, 0.5))), box((0.25, 0.25, 0.25)))),
        "exact",
        0.875 + 1 / 64,
    ),
    Case("outward shell inside", lambda: mesh(join(box(), box((0.5, 0.5, 0.5)))), "exact", 1.0),
    Case(
        "cavity that touches the wall",
        lambda: mesh(join(box(), inverted(box((0.5, 0.5, 0.5), (0.0, 0.0, 0.25))))),
        "opened",
        0.875,
    ),
    Case("every face twice", lambda: mesh((box()[0], np.tile(box()[1], (2, 1)))), "exact", 1.0),
    Case(
        "every face of a box and its cavity twice",
        lambda: mesh(
            (hollow()[0], np.tile(hollow()[1], (2, 1))),
        ),
        "exact",
        0.875,
        codes=("AP207",),
    ),
    Case(
        "every face from both sides",
        lambda: mesh((box()[0], np.vstack([box()[1], box()[1][:, ::-1]]))),
        "exact",
        1.0,
    ),
    Case(
        "one face twice",
        lambda: mesh((box()[0], np.vstack([box()[1], box()[1][:1]]))),
        "exact",
        1.0,
    ),
    Case(
        "degenerate faces",
        lambda: mesh((box()[0], np.vstack([box()[1], [[0, 0, 1], [2, 2, 2]]]))),
        "exact",
        1.0,
    ),
    Case(
        "zero-area face over a T-junction",
        lambda: mesh(
            (
                with_junction()[0],
                np.vstack([with_junction()[1], [[box()[1][0][0], box()[1][0][1], 8]]]),
            )
        ),
        "exact",
        1.0,
    ),
    Case("flap folded over an edge", lambda: mesh(with_flap()), "near", 1.0),
    Case("T-junction", lambda: mesh(with_junction()), "near", 1.0),
    Case("fin outside", lambda: mesh(welded(join(box(), _SQUARE_OUT))), "near", 1.0, 0.02),
    Case(
        "fin outside, drawn along both diagonals",
        lambda: mesh(join(box(), doubled(_SQUARE_OUT))),
        "near",
        1.0,
        0.02,
    ),
    Case(
        "square drawn along both diagonals",
        lambda: mesh(doubled(flat_square([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]))),
        "near",
        lambda square: thick(square) / 2,
        1e-6,
    ),
    Case("fin inside", lambda: mesh(welded(join(box(), _SQUARE_IN))), "near", 1.0),
    Case("wall between rooms", lambda: mesh(divided_box()), "near", 1.0),
    Case("one small hole", lambda: mesh(without(sphere(4), [7])), "near"),
    Case("many small holes", lambda: mesh(without(sphere(4), slice(0, 5000, 97))), "near"),
    Case("halves nearly meet", lambda: mesh(two_halves(1e-4)), "near", 1.0, 1e-3),
    Case("every face apart from its neighbours", lambda: mesh(exploded()), "near", _BALL, 0.05),
    Case("lid off", lambda: mesh(lid_off()), "near", codes=("AP208",)),
    Case("square sheet", lambda: mesh(sheet()), "near", thick, 1e-6),
    Case("fine sheet", lambda: mesh(sheet(12)), "near", thick, 1e-6),
    Case(
        "one triangle",
        lambda: mesh(([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])),
        "near",
        thick,
        1e-6,
    ),
    Case("ring", lambda: mesh(strip(0)), "near"),
    Case("Möbius band", lambda: mesh(strip(1)), "near"),
    Case("band with a full twist", lambda: mesh(strip(2)), "near"),
    Case("Klein bottle", lambda: mesh(klein_bottle()), "near"),
    Case("tube that overlaps itself", lambda: mesh(coil()), "near"),
    Case("plate a thousandth thick", lambda: mesh(box((1, 1, 1e-3))), "exact", 1e-3),
    Case("plate a millionth thick", lambda: mesh(box((1, 1, 1e-6))), "exact", 1e-6),
    Case("needle", lambda: mesh(box((1, 1e-5, 1e-5))), "exact", 1e-10),
    Case(
        "only degenerate faces",
        lambda: mesh(([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2], [0, 0, 1]])),
        "refused",
        codes=("AP204",),
    ),
)
