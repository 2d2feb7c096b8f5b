import importlib.util

import pytest

from assetpipe.errors import UsageError
from assetpipe.pipeline import build
from assetpipe.pipeline.identity import code_stamp, digest_of, versions


def test_engine_that_is_not_installed_is_refused_before_anything_else(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(build, "find_spec", lambda name: None)
    with pytest.raises(UsageError, match=r"assetpipe\[engines\]"):
        build.require_engine("coacd")
    build.require_engine("hull")


def test_identity_names_what_shapes_a_result() -> None:
    assert {"assetpipe", "manifold3d"} <= set(versions("assetpipe"))
    if importlib.util.find_spec("coacd"):
        assert versions("coacd")["coacd"] != "absent"
    assert code_stamp() == code_stamp()
    assert digest_of({"a": 1, "b": 2}) == digest_of({"b": 2, "a": 1})
    assert digest_of([1]) != digest_of(["1"])
