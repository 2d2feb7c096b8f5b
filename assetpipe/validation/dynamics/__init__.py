"""Physics engines behind one small interface, each in a process of its own."""

from __future__ import annotations

from typing import TYPE_CHECKING

from assetpipe.lazy import lazily

if TYPE_CHECKING:
    from assetpipe.validation.dynamics.load import EngineLoad, EngineProbe, load_in_engine
    from assetpipe.validation.dynamics.process import (
        EngineName,
        available_engines,
        default_engine,
    )
else:
    # The workers import their own module only.
    __getattr__ = lazily(
        __name__,
        {
            "EngineLoad": "assetpipe.validation.dynamics.load",
            "EngineName": "assetpipe.validation.dynamics.process",
            "EngineProbe": "assetpipe.validation.dynamics.load",
            "available_engines": "assetpipe.validation.dynamics.process",
            "default_engine": "assetpipe.validation.dynamics.process",
            "load_in_engine": "assetpipe.validation.dynamics.load",
        },
    )

__all__ = [
    "EngineLoad",
    "EngineName",
    "EngineProbe",
    "available_engines",
    "default_engine",
    "load_in_engine",
]
