"""Expand xacro files in a process of their own.

xacro evaluates Python expressions out of the file. Its own protection does not hold (``$(eval
…)`` reaches every builtin, and names are checked in the outermost code only), so the expansion
runs in a subprocess (:mod:`assetpipe.robot.xacro_worker`) with limits on time, memory and
output, without the environment's secrets, and there

* ``$(eval …)`` is refused,
* ``${…}`` may not touch attributes that lead into the interpreter,
* ``<xacro:include>`` and ``load_yaml`` read files of known packages and allowed roots only,
* no document type declarations are read and no file is written.

This keeps a stranger's description from doing harm by any way known to us; it is no sandbox of
the operating system.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

from assetpipe.errors import InputError, LimitError, Location
from assetpipe.robot.lookup import Lookup
from assetpipe.robot.markup import MAX_BYTES

SECONDS = 60.0
"""How long an expansion may take."""
MEMORY = 4 * 1024**3
"""How much address space an expansion may use, bytes."""

_KEPT = ("PATH", "LANG", "LC_ALL", "SYSTEMROOT", "TEMP", "TMP", "ROS_DISTRO", "ROS_VERSION")
_START = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from assetpipe.robot.xacro_worker import main; main()"
)


class XacroError(InputError):
    """A xacro file cannot be expanded."""

    code = "AP108"


def expand(
    path: Path, lookup: Lookup, arguments: Mapping[str, str]
) -> tuple[bytes, tuple[Path, ...]]:
    """Expand a xacro file.

    Where the file spells out a package's folder through ``$(find name)`` in a mesh reference,
    the result says ``package://name`` instead: the same on every machine.

    Args:
        path: the file.
        lookup: finds packages and says what may be read.
        arguments: values of ``<xacro:arg>``.

    Returns:
        The URDF in UTF-8, and the other files that were read.

    Raises:
        XacroError: with the file in which it went wrong.
        LimitError: it took too long or grew too large.
    """
    if not path.is_file():
        raise XacroError("cannot be read: no such file", location=Location(path))
    request = {
        "path": os.path.abspath(path),
        "arguments": {str(k): str(v) for k, v in arguments.items()},
        "resolver": lookup.settings(),
        "memory": MEMORY,
        "seconds": SECONDS,
        "max_bytes": MAX_BYTES,
    }
    search = json.dumps([os.path.abspath(entry) for entry in sys.path])
    environment = {name: os.environ[name] for name in _KEPT if name in os.environ}
    # one thread's worth of address space for the linear algebra that numpy brings along
    environment |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    try:
        done = subprocess.run(
            [sys.executable, "-I", "-c", _START, search],
            input=json.dumps(request).encode("utf-8"),
            capture_output=True,
            timeout=SECONDS,
            env=environment,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise LimitError(
            f"xacro expansion takes longer than {SECONDS:g} s", location=Location(path)
        ) from error
    try:
        reply = json.loads(done.stdout)
    except ValueError:
        last = done.stderr.decode("utf-8", "replace").strip().splitlines()[-1:]
        raise XacroError(
            f"expansion ended with code {done.returncode}: {''.join(last) or 'no message'}",
            location=Location(path),
        ) from None
    if "error" in reply:
        location = Location(Path(reply["file"]) if reply.get("file") else path, reply.get("line"))
        kind = LimitError if reply.get("limit") else XacroError
        raise kind(reply["error"], location=location)
    return reply["text"].encode("utf-8"), tuple(Path(name) for name in reply["files"])
