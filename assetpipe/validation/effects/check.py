"""Does a scene fit its assets? Links and joints that it names, and where joints shall go."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from assetpipe.errors import ConfigError, unknown_name
from assetpipe.validation.effects.motion import Motion
from assetpipe.validation.scenes.assets import SceneAsset
from assetpipe.validation.scenes.schema import Scene


def check_references(scene: Scene, assets: Mapping[str, SceneAsset]) -> None:
    """Look at every link and joint that a scene names.

    Raises:
        ConfigError: one that does not exist, cannot move as asked, or has no shape to ask.
    """
    motion = Motion(scene, assets)
    for reference in scene.between or ():
        if not any(assets[a].link[link].shapes for a, link in motion.parts(reference)):
            raise ConfigError(f"'{reference}' has no collision geometry{_solid(scene, assets)}")
    if scene.question == "hold" and "/" in (scene.subject or ""):
        motion.parts(scene.subject or "")
    if scene.question == "open" and scene.subject is not None:
        _opens(scene.subject, assets)
    for name, joint, positions in _driven(scene):
        asset = assets[name]
        if joint not in asset.joint:
            raise ConfigError(f"asset '{name}': " + unknown_name("joint", joint, asset.joint))
        leader = asset.joint[joint].mimic
        if leader is not None:
            raise ConfigError(f"joint '{joint}' of '{name}' follows '{leader[0]}': drive that one")
        for position in positions:
            asset.check_position(joint, position)
    if scene.question == "self_collision" and scene.subject is not None:
        linked = [item for item in assets[scene.subject].links if item.shapes]
        if len(linked) < 2:
            raise ConfigError(
                f"asset '{scene.subject}' has {len(linked)} link with collision geometry: "
                "self-collision needs two; for two assets ask 'contact'"
            )


def _opens(subject: str, assets: Mapping[str, SceneAsset]) -> None:
    name, _, joint = subject.partition("/")
    asset = assets[name]
    if joint not in asset.joint:
        raise ConfigError(f"asset '{name}': " + unknown_name("joint", joint, asset.joint))
    leader = asset.joint[joint].mimic
    if leader is not None:
        raise ConfigError(f"joint '{joint}' of '{name}' follows '{leader[0]}': ask that one")
    if joint not in asset.moving:
        raise ConfigError(f"joint '{joint}' of '{name}' cannot open: add it to 'moving'")


def _driven(scene: Scene) -> Iterator[tuple[str, str, tuple[float, ...]]]:
    """Asset, joint and the positions that it is driven to."""
    for name, motors in scene.drive.motors.items():
        for joint, target in motors.targets.items():
            yield name, joint, (target,)
    if scene.drive.trajectory is not None:
        for joint, positions in scene.drive.trajectory.joints.items():
            yield scene.drive.trajectory.asset, joint, positions


def _solid(scene: Scene, assets: Mapping[str, SceneAsset]) -> str:
    known = [f"{n}/{item.name}" for n, a in assets.items() for item in a.links if item.shapes]
    return f"; these have: {', '.join(known[:12])}" if known else ""
