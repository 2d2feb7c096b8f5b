"""The process that expands one xacro file: a request on stdin, a reply on stdout, as JSON.

See :mod:`assetpipe.robot.xacro` for what is kept from the file and why.
"""

from __future__ import annotations

import ast
import json
import os
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from xml.dom import minidom
from xml.parsers import expat

from assetpipe import secure_xml
from assetpipe.errors import AssetpipeError, InputError, Location
from assetpipe.robot.lookup import Lookup
from assetpipe.robot.resources import Resolver

_INNER = re.compile(r"_|(gi|cr|ag|f|tb|co|func)_|(format|format_map|mro)$")
"""Attributes that lead from a value into the interpreter; ``format`` reads attributes too."""
_REFUSED_BUILTINS = ("vars", "type")


class _Refused(Exception):  # noqa: N818 - told as an error of the file
    """Something that a description may not do."""


def main() -> None:
    """Answer one request."""
    out = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # xacro prints; the reply must stay clean
    reply = _answer(json.loads(sys.stdin.buffer.read()))
    out.write(json.dumps(reply).encode("utf-8"))
    out.close()


def _answer(request: Mapping[str, Any]) -> dict[str, Any]:
    import xacro

    path = Path(request["path"])
    lookup = Resolver.from_settings(request["resolver"]).beside(path)
    guard = _Guard(lookup)
    try:
        guard.install()
        _limit(request["memory"], request["seconds"])
        text = guard.expand(path, dict(request["arguments"]))
    except (MemoryError, RecursionError) as error:
        return {"error": f"xacro expansion grows without end ({type(error).__name__})", "limit": 1}
    except Exception as error:  # noqa: BLE001 - whatever a stranger's expressions raise
        return _told(error, xacro.filestack)
    if len(text) > request["max_bytes"]:
        return {"error": f"xacro expands to {len(text):,} characters", "limit": 1}
    # the first entry is the file itself
    return {"text": text, "files": list(dict.fromkeys(guard.read))[1:]}


def _told(error: Exception, files: list[str | None] | None) -> dict[str, Any]:
    """The error, in the file that xacro was in."""
    # xacro wraps what went wrong inside of it, several times and each time with the message
    cause: object = error
    while cause is not None and not isinstance(cause, _Refused | AssetpipeError):
        cause = getattr(cause, "exc", None)
    if isinstance(cause, AssetpipeError) and cause.location is not None:
        at = cause.location
        return {"error": cause.message, "file": str(at.file), "line": at.line}
    message = " ".join(str(cause or error).split()) or type(error).__name__
    where = files[-1] if files else None
    return {"error": message[:500], "file": str(where) if where else None}


def _limit(memory: int, seconds: float) -> None:
    try:
        import resource
    except ImportError:  # not on Windows; the time limit holds there too
        return
    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    resource.setrlimit(resource.RLIMIT_CPU, (int(seconds) + 1, int(seconds) + 1))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    if not sys.stderr.isatty():
        # pipes are not files: what is refused is writing to disk
        resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))


class _Guard:
    """Stands between xacro and the machine."""

    def __init__(self, lookup: Lookup) -> None:
        self._lookup = lookup
        self._found: dict[str, Path] = {}
        self.read: list[str] = []

    def install(self) -> None:
        """Replace what xacro reads files and evaluates expressions with."""
        import xacro
        import xacrodoc
        from xacro import substitution_args

        evaluate, load_yaml = xacro.safe_eval, xacro.load_yaml

        def safe_eval(expression: str, names: dict[str, Any], local: Any = None) -> Any:
            check_expression(expression)
            return evaluate(expression, names, local)

        def guarded_yaml(filename: str) -> Any:
            self._may_read(xacro.abs_filename_spec(filename))
            return load_yaml(filename)

        def refuse_eval(text: str, _context: object) -> str:
            raise _Refused(f"$(eval {text[:80]}) is refused: it may run anything; write ${{…}}")

        xacro.safe_eval = safe_eval
        xacro.load_yaml = guarded_yaml
        xacro.parse = self._parse
        substitution_args._eval = refuse_eval
        # xacrodoc hands $(find …) to this function
        xacrodoc.packages.get_path = self._find
        xacro._global_symbols = xacro.create_global_symbols()
        for name in _REFUSED_BUILTINS:
            dict.pop(xacro._global_symbols["python"], name, None)

    def expand(self, path: Path, arguments: dict[str, str]) -> str:
        """The URDF as text."""
        import xacro

        xacro.init_stacks(str(path))
        document = self._parse(None, str(path))
        xacro.process_doc(document, mappings=arguments)
        for element in document.getElementsByTagName("*"):
            if element.hasAttribute("filename"):
                element.setAttribute("filename", self._portable(element.getAttribute("filename")))
        text: str = document.toprettyxml(indent="  ")
        return text

    def _portable(self, uri: str) -> str:
        plain = uri.removeprefix("file://")
        for name, root in self._found.items():
            if plain.startswith(f"{root}/"):
                return f"package://{name}{plain[len(str(root)) :]}"
        return uri

    def _find(self, name: str) -> str:
        root = self._lookup.package_root(name)
        if root is None:
            raise _Refused(
                f"package '{name}' not found; add the folder that holds it to ROS_PACKAGE_PATH"
            )
        self._found[name] = root
        return str(root)

    def _may_read(self, filename: str) -> Path:
        path = Path(os.path.abspath(filename))
        real = path.resolve()
        found = any(real.is_relative_to(root.resolve()) for root in self._found.values())
        if not (found or self._lookup.allows(path)):
            raise _Refused(f"'{filename}' lies outside of the package: refused")
        self.read.append(str(path))
        return path

    def _parse(self, text: str | None, filename: str | None = None) -> minidom.Document:
        """xacro.parse for files, with checks; text and documents pass as they are there."""
        if text is not None or filename is None:
            raise _Refused("xacro without a file")
        path = self._may_read(filename)
        try:
            data = path.read_bytes()
        except OSError as error:
            import xacro

            xacro.filestack.pop()
            # xacro looks for an OSError inside when an include is optional
            raise xacro.XacroException(f"{error.strerror}: {filename}", exc=error) from error
        data = secure_xml.as_utf8(data, path)
        secure_xml.refuse_declarations(data, path)
        try:
            return minidom.parseString(_without_encoding(data))  # noqa: S318 - checked above
        except expat.ExpatError as error:
            raise InputError(
                f"not well-formed XML: {expat.ErrorString(error.code)}",
                location=Location(path, error.lineno),
            ) from error


def _without_encoding(data: bytes) -> bytes:
    """UTF-8 whose declaration no longer claims another encoding."""
    return re.sub(rb"^(<\?xml[^>]*?)\s+encoding\s*=\s*[\"'][^\"']*[\"']", rb"\1", data, count=1)


def check_expression(expression: str) -> None:
    """Refuse an expression that reaches into the interpreter.

    Looks at the whole syntax tree: functions and comprehensions inside too.
    """
    tree = ast.parse(expression.strip(), mode="eval")
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute):
            if _INNER.match(node.attr):
                raise _Refused(f"'.{node.attr}' is refused in '{expression.strip()[:80]}'")
        elif isinstance(node, ast.Name) and node.id.startswith("__"):
            raise _Refused(f"'{node.id}' is refused in '{expression.strip()[:80]}'")
