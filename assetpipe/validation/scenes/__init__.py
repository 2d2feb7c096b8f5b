"""Scenes: a question about assets in a situation."""

from assetpipe.validation.scenes.assets import SceneAsset, SceneJoint, SceneLink
from assetpipe.validation.scenes.build import AssetProvider, Convexes, DirectProvider, build_assets
from assetpipe.validation.scenes.schema import Scene, load_scene, parse_scene

__all__ = [
    "AssetProvider",
    "Convexes",
    "DirectProvider",
    "Scene",
    "SceneAsset",
    "SceneJoint",
    "SceneLink",
    "build_assets",
    "load_scene",
    "parse_scene",
]
