"""Proof: contact truth (FCL), self-collision, and physics engines."""

from assetpipe.validation.contact import ContactTruth, contact_truth
from assetpipe.validation.contact.pairs import LinkBody
from assetpipe.validation.dynamics import EngineLoad, load_in_engine
from assetpipe.validation.self_collision import (
    SelfCollisions,
    adjacent_pairs,
    self_collisions,
)
from assetpipe.validation.statistics import Distribution, Rate

__all__ = [
    "ContactTruth",
    "Distribution",
    "EngineLoad",
    "LinkBody",
    "Rate",
    "SelfCollisions",
    "adjacent_pairs",
    "contact_truth",
    "load_in_engine",
    "self_collisions",
]
