"""Scenes: a question about assets in a situation."""

from assetpipe.validation.scenes.build import AssetProvider, Convexes, build_assets
from assetpipe.validation.scenes.run import (
    SceneOptions,
    SceneResult,
    answer_scene,
    explain_scene,
    run_scene,
)
from assetpipe.validation.scenes.schema import Scene, load_scene, parse_scene

__all__ = [
    "AssetProvider",
    "Convexes",
    "Scene",
    "SceneOptions",
    "SceneResult",
    "answer_scene",
    "build_assets",
    "explain_scene",
    "load_scene",
    "parse_scene",
    "run_scene",
]
