"""Proof: contact truth (FCL), self-collision, engine profiles, scenes and physics engines."""

from __future__ import annotations

from typing import TYPE_CHECKING

from assetpipe.lazy import lazily

if TYPE_CHECKING:
    from assetpipe.validation.contact.pairs import LinkBody
    from assetpipe.validation.contact.truth import ContactTruth, contact_truth
    from assetpipe.validation.dynamics.load import EngineLoad, load_in_engine
    from assetpipe.validation.dynamics.settle import Settling, settle_in_engine
    from assetpipe.validation.profiles import EngineProfile, check_hulls, load_profile
    from assetpipe.validation.runners.scene import (
        SceneOptions,
        SceneResult,
        explain_scene,
        run_scene,
    )
    from assetpipe.validation.self_collision import (
        SelfCollisions,
        adjacent_pairs,
        self_collisions,
    )
    from assetpipe.validation.statistics import Distribution, Rate
else:
    # An engine's worker imports one module of this room, not the collision libraries.
    __getattr__ = lazily(
        __name__,
        {
            "ContactTruth": "assetpipe.validation.contact.truth",
            "Distribution": "assetpipe.validation.statistics",
            "EngineLoad": "assetpipe.validation.dynamics.load",
            "EngineProfile": "assetpipe.validation.profiles",
            "LinkBody": "assetpipe.validation.contact.pairs",
            "Rate": "assetpipe.validation.statistics",
            "SceneOptions": "assetpipe.validation.runners.scene",
            "SceneResult": "assetpipe.validation.runners.scene",
            "SelfCollisions": "assetpipe.validation.self_collision",
            "Settling": "assetpipe.validation.dynamics.settle",
            "adjacent_pairs": "assetpipe.validation.self_collision",
            "check_hulls": "assetpipe.validation.profiles",
            "contact_truth": "assetpipe.validation.contact.truth",
            "explain_scene": "assetpipe.validation.runners.scene",
            "load_in_engine": "assetpipe.validation.dynamics.load",
            "load_profile": "assetpipe.validation.profiles",
            "run_scene": "assetpipe.validation.runners.scene",
            "self_collisions": "assetpipe.validation.self_collision",
            "settle_in_engine": "assetpipe.validation.dynamics.settle",
        },
    )

__all__ = [
    "ContactTruth",
    "Distribution",
    "EngineLoad",
    "EngineProfile",
    "LinkBody",
    "Rate",
    "SceneOptions",
    "SceneResult",
    "SelfCollisions",
    "Settling",
    "adjacent_pairs",
    "check_hulls",
    "contact_truth",
    "explain_scene",
    "load_in_engine",
    "load_profile",
    "run_scene",
    "self_collisions",
    "settle_in_engine",
]
