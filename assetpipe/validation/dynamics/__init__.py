"""Physics engines behind one small interface, each in a process of its own."""

from assetpipe.validation.dynamics.load import EngineLoad, EngineProbe, load_in_engine
from assetpipe.validation.dynamics.process import EngineName, available_engines, default_engine

__all__ = [
    "EngineLoad",
    "EngineName",
    "EngineProbe",
    "available_engines",
    "default_engine",
    "load_in_engine",
]
