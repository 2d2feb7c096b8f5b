"""YAML files against pydantic models, with errors that locate and name neighbours."""

from __future__ import annotations

from collections.abc import Hashable
from pathlib import Path
from typing import Any, TypeVar, get_args

import yaml
from pydantic import BaseModel, ValidationError

from assetpipe.errors import ConfigError, Location, unknown_name

MAX_BYTES = 2**20
"""A configuration larger than this is no configuration."""

Model = TypeVar("Model", bound=BaseModel)


def load_yaml(path: Path, model: type[Model]) -> Model:
    """Read a YAML file into a model.

    Raises:
        ConfigError: unreadable, not YAML, a key twice, an unknown key, or a value
            that does not fit; with file and line, and what would be allowed.
    """
    values, lines = read_yaml(path)
    try:
        return model.model_validate(values)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        line = _line(lines, tuple(first["loc"]))
        raise ConfigError(explain(error, model), location=Location(path, line)) from error


def read_yaml(path: Path) -> tuple[dict[str, Any], dict[tuple[Hashable, ...], int]]:
    """The mapping in a YAML file, and the line of every key in it."""
    try:
        if path.stat().st_size > MAX_BYTES:
            raise ConfigError(f"larger than {MAX_BYTES} bytes", location=Location(path))
        text = path.read_text("utf-8")
    except OSError as error:
        raise ConfigError(f"cannot be read: {error.strerror}", location=Location(path)) from error
    except UnicodeDecodeError as error:
        raise ConfigError("is not UTF-8 text", location=Location(path)) from error
    try:
        loader = yaml.SafeLoader(text)
        try:
            node = loader.get_single_node()
            lines: dict[tuple[Hashable, ...], int] = {}
            if node is not None:
                _index(node, (), lines, path)
            values = loader.construct_document(node) if node is not None else {}
        finally:
            loader.dispose()
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        problem = getattr(error, "problem", None) or "not YAML"
        line = mark.line + 1 if mark else None
        raise ConfigError(f"is not YAML: {problem}", location=Location(path, line)) from error
    except RecursionError as error:
        raise ConfigError("is nested too deeply", location=Location(path)) from error
    except (ValueError, KeyError, AttributeError) as error:
        # What PyYAML raises for dates and numbers that are none.
        raise ConfigError(f"has a value that is none: {error}", location=Location(path)) from error
    if values is None:
        values = {}
    if not isinstance(values, dict):
        raise ConfigError(
            f"must hold keys and values, not a {type(values).__name__}", location=Location(path, 1)
        )
    return values, lines


def _index(
    node: yaml.Node,
    where: tuple[Hashable, ...],
    lines: dict[tuple[Hashable, ...], int],
    path: Path,
) -> None:
    """Remember the line of every key; refuse a key that comes twice, and aliases."""
    line = node.start_mark.line + 1
    if where in lines and isinstance(node, yaml.MappingNode | yaml.SequenceNode):
        lines[where] = min(lines[where], line)
    if isinstance(node, yaml.SequenceNode):
        for index, child in enumerate(node.value):
            _enter(child, (*where, index), child.start_mark.line + 1, lines, path)
    elif isinstance(node, yaml.MappingNode):
        for key, child in node.value:
            name = str(key.value)
            here = key.start_mark.line + 1
            place = (*where, name)
            if place in lines:
                raise ConfigError(
                    f"key '{name}' comes twice (first on line {lines[place]})",
                    location=Location(path, here),
                )
            _enter(child, place, here, lines, path)


def _enter(
    node: yaml.Node,
    where: tuple[Hashable, ...],
    line: int,
    lines: dict[tuple[Hashable, ...], int],
    path: Path,
) -> None:
    if len(where) > 32 or len(lines) > 100_000:
        # Aliases can make a small file unfold without end.
        raise ConfigError("is nested too deeply or repeats itself", location=Location(path, line))
    lines[where] = line
    _index(node, where, lines, path)


def _line(lines: dict[tuple[Hashable, ...], int], loc: tuple[Hashable, ...]) -> int | None:
    """The line of the deepest known key on the way to ``loc``."""
    for end in range(len(loc), 0, -1):
        found = lines.get(loc[:end])
        if found is not None:
            return found
    return None


def explain(error: ValidationError, model: type[BaseModel]) -> str:
    """One sentence for the first fault, and how many more there are."""
    faults = error.errors(include_url=False)
    first = faults[0]
    loc = tuple(first["loc"])
    key = ".".join(str(part) for part in loc)
    kind = first["type"]
    if kind == "extra_forbidden":
        owner = _model_at(model, loc[:-1])
        parent = ".".join(str(part) for part in loc[:-1])
        known = [f"{parent}.{name}" if parent else name for name in owner.model_fields]
        said = unknown_name("key", key, known) if len(known) <= 12 else _all_keys(key, known)
    elif kind == "literal_error":
        allowed = first.get("ctx", {}).get("expected", "")
        said = f"{key}: {_shown(first['input'])} is not allowed; allowed: {allowed}"
    elif kind == "missing":
        said = f"key '{key}' is missing"
    else:
        message = first["msg"].removeprefix("Value error, ")
        said = f"{key}: {_shown(first['input'])} does not fit: {message}" if key else message
    more = f" ({len(faults) - 1} more)" if len(faults) > 1 else ""
    return said + more


def _all_keys(key: str, known: list[str]) -> str:
    """Like :func:`unknown_name`, but every allowed key is told, not the first twelve."""
    hint = unknown_name("key", key, known).split("; keys:")[0]
    return f"{hint}; keys: {', '.join(known)}"


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "…"


def _model_at(model: type[BaseModel], loc: tuple[Hashable, ...]) -> type[BaseModel]:
    """The model that owns the key at ``loc``."""
    owner = model
    for part in loc:
        field = owner.model_fields.get(str(part))
        if field is None:
            continue  # a key of a mapping: its values' model was found one step before
        for candidate in (field.annotation, *get_args(field.annotation)):
            if isinstance(candidate, type) and issubclass(candidate, BaseModel):
                owner = candidate
    return owner
