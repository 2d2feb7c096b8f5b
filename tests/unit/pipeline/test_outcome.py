import numpy as np
import pytest

from assetpipe.errors import InputError
from assetpipe.findings import Finding, Severity
from assetpipe.geometry.mesh import Mesh
from assetpipe.pipeline.outcome import HullOutcome, MeshOutcome

TETRAHEDRON = Mesh(
    np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0.1]]),
    np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]),
)
OUTCOME = MeshOutcome(
    "decomposed",
    (HullOutcome(TETRAHEDRON, (0.0, 1e-3), (0.1, 0.2)), HullOutcome(TETRAHEDRON, (0.0, 2e-3))),
    (Finding("AP201", Severity.NOTE, "welded", hint="none"),),
    {"faces": 4, "repair": {"moved": 0.1}},
    solid=TETRAHEDRON,
    inner=(TETRAHEDRON.scaled(np.full(3, 0.5)), TETRAHEDRON),
)


def test_survives_its_bytes() -> None:
    back = MeshOutcome.decode(OUTCOME.encode())
    assert back.encode() == OUTCOME.encode()
    assert back.findings == OUTCOME.findings
    assert back.facts == OUTCOME.facts
    assert [h.thickening for h in back.hulls] == [(0.0, 1e-3), (0.0, 2e-3)]
    assert back.hulls[0].concavity == (0.1, 0.2)
    assert back.hulls[1].concavity is None
    np.testing.assert_array_equal(back.hulls[0].mesh.vertices, TETRAHEDRON.vertices)
    for old, new in zip(OUTCOME.inner, back.inner, strict=True):
        np.testing.assert_array_equal(new.vertices, old.vertices)
        np.testing.assert_array_equal(new.faces, old.faces)


def test_any_flipped_byte_is_noticed() -> None:
    data = OUTCOME.encode()
    for position in range(0, len(data), 7):
        broken = bytearray(data)
        broken[position] ^= 1
        with pytest.raises(InputError):
            MeshOutcome.decode(bytes(broken))


def test_not_an_outcome() -> None:
    for data in (b"", b"assetpipe-outcome 1\n", OUTCOME.encode()[:-1]):
        with pytest.raises(InputError):
            MeshOutcome.decode(data)
