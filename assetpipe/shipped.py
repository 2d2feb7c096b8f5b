"""The configurations that come with assetpipe, found by name."""

from __future__ import annotations

from pathlib import Path

from assetpipe.errors import ConfigError, unknown_name

# A link to the repository's configs/; in an installed package, a folder.
CONFIGS = Path(__file__).resolve().parent / "configs"


def find_config(name: str | Path, *, kind: str = "") -> Path:
    """The file meant by ``name``: a path, or a shipped configuration's name.

    Args:
        name: ``planning``, or a path to a YAML file.
        kind: subfolder of the shipped configurations, for example ``engines``.

    Raises:
        ConfigError: neither; names the shipped ones.
    """
    path = Path(name)
    if path.is_file():
        return path
    folder = CONFIGS / kind
    shipped = {found.stem: found for found in sorted(folder.glob("*.yaml"))}
    if str(name) in shipped:
        return shipped[str(name)]
    if path.suffix in {".yaml", ".yml"} or len(path.parts) > 1:
        raise ConfigError(
            f"configuration file '{name}' does not exist; shipped: {', '.join(shipped) or 'none'}"
        )
    raise ConfigError(unknown_name("configuration", str(name), shipped))
