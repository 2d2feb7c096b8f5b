"""What decompositions of the golden solids hash to.

    python tests/golden/golden_hashes.py > tests/golden/hashes.json

records the hashes anew, after a change that is meant to change results. With names of solids
behind it only these are printed.
"""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from golden_solids import SOLIDS

from assetpipe import decompose
from assetpipe.decomposition import Decomposition, Params

_OPTIONS: dict[str, dict[str, Any]] = {
    f"{metric}, {effort}": {"metric": metric, "effort": effort}
    for metric in ("thickening", "concavity")
    for effort in ("fast", "balanced", "best")
} | {
    "tree search": {"params": Params({"policy": "mcts", "iterations": 20}), "seed": 3},
    "at most 8 vertices": {"max_hull_vertices": 8},
    "at most 5 hulls": {"max_hulls": 5},
    "overlap of a thousandth of the diagonal": {"overlap": 1e-3},
    "shapes": {"shapes": "primitives_and_capsules"},
}


def digest(d: Decomposition) -> str:
    """Hulls and SHA-256 over every bit of them, their certificates and the coarser levels."""
    state = hashlib.sha256()
    for hull, children in [
        *((hull, None) for hull in d.hulls),
        *((node.hull, node.children) for node in d.nodes),
    ]:
        certificate = hull.certificate
        for array in (
            np.asarray(hull.vertices, dtype="<f8"),
            np.asarray(hull.faces, dtype="<i8"),
        ):
            state.update(np.ascontiguousarray(array).tobytes())
        bounds = [certificate.thickening, certificate.concavity]
        numbers = [hull.volume, *(x for b in bounds if b for x in (b.lower, b.upper))]
        shape = hull.primitive.as_dict() if hull.primitive else None
        state.update(repr(([float(x).hex() for x in numbers], children, shape)).encode())
    return f"{len(d.hulls)} hulls, {state.hexdigest()[:32]}"


def found(solids: Sequence[str], threads: int) -> Iterator[tuple[str, str]]:
    """Names of decompositions and their digests."""
    for name in solids:
        mesh = SOLIDS[name]
        for options, given in _OPTIONS.items():
            overlap = given.get("overlap", 0.0) * mesh.diagonal
            d = decompose(mesh, "2%", threads=threads, **{**given, "overlap": overlap})
            yield f"{name}: {options}", digest(d)


if __name__ == "__main__":
    print(json.dumps(dict(found(sys.argv[1:] or list(SOLIDS), threads=1)), indent=1))
