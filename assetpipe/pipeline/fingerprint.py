"""What decides a build of one source: itself, its references, and what is asked."""

from __future__ import annotations

from assetpipe.pipeline.config import Config
from assetpipe.pipeline.identity import code_stamp, digest_of, versions
from assetpipe.pipeline.inputs import Source
from assetpipe.pipeline.references import references


def fingerprint(source: Source, config: Config, expanded: bytes | None = None) -> str | None:
    """A digest; ``None`` if the source cannot be judged (see :func:`references`)."""
    found = references(source, expanded)
    if found is None:
        return None
    return digest_of(
        {
            "code": code_stamp(),
            "versions": versions(config.engine),
            "config": config.as_dict(),
            "references": found,
        }
    )
