"""The numbers in a glTF file: chunks, buffers, views and accessors (glTF 2.0 §3.6, §4.4)."""

from __future__ import annotations

import base64
import binascii
import json
import stat
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast
from urllib.parse import unquote, urlsplit

import numpy as np
import numpy.typing as npt

from assetpipe.errors import InputError, LimitError, Location
from assetpipe.geometry.formats.raw import FileLimits

_KINDS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
_JSON, _BIN = 0x4E4F534A, 0x004E4942


def chunks(data: bytes, path: Path) -> tuple[bytes, bytes | None]:
    """The JSON and binary chunk of a GLB (§4.4).

    Raises:
        InputError: a version other than 2, or lengths that lie.
    """
    version = int.from_bytes(data[4:8], "little")
    if len(data) < 12 or version != 2:
        raise InputError(f"GLB version {version} is unsupported", location=Location(path))
    if int.from_bytes(data[8:12], "little") > len(data):
        raise InputError(
            f"truncated GLB: {int.from_bytes(data[8:12], 'little'):,} bytes promised, "
            f"{len(data):,} there",
            location=Location(path),
        )
    header: bytes | None = None
    binary: bytes | None = None
    position = 12
    while position + 8 <= len(data):
        length = int.from_bytes(data[position : position + 4], "little")
        kind = int.from_bytes(data[position + 4 : position + 8], "little")
        body = data[position + 8 : position + 8 + length]
        if len(body) < length:
            raise InputError("truncated GLB chunk", location=Location(path))
        if kind == _JSON and header is None:
            header = body
        elif kind == _BIN and binary is None:
            binary = body
        position += 8 + length
    if header is None:
        raise InputError("GLB without a JSON chunk", location=Location(path))
    return header, binary


@dataclass(frozen=True)
class Gltf:
    """A glTF document with its buffers in memory.

    Attributes:
        path: for messages and for buffers beside it.
        tree: the JSON object.
        buffers: the bytes of each buffer.
    """

    path: Path
    tree: dict[str, Any]
    buffers: tuple[bytes, ...]

    @classmethod
    def load(cls, data: bytes, path: Path, limits: FileLimits) -> Gltf:
        """Parse a GLB or glTF and gather its buffers.

        Raises:
            InputError: no glTF 2, or buffers missing, too short or outside of its folder.
            LimitError: more bytes than allowed.
        """
        header, binary = chunks(data, path) if data[:4] == b"glTF" else (data, None)
        try:
            tree = json.loads(header.decode("utf-8-sig"))
        except (ValueError, RecursionError) as error:
            line = getattr(error, "lineno", None)
            raise InputError(f"glTF is not JSON: {error}", location=Location(path, line)) from error
        plain = cls(path, tree if isinstance(tree, dict) else {}, ())
        if not str(plain.mapping(plain.tree, "asset").get("version", "")).startswith("2"):
            raise InputError("not a glTF 2 document", location=Location(path))
        total = len(data)
        buffers = []
        for k, item in enumerate(plain.items("buffers")):
            body = _buffer(plain, item, k, binary, limits.max_bytes - total)
            total += len(body) if "uri" in item else 0
            limits.check("bytes", total, path)
            buffers.append(body)
        return cls(path, plain.tree, tuple(buffers))

    def wrong(self, message: str) -> InputError:
        """An error about this file."""
        return InputError(message, location=Location(self.path))

    def items(self, name: str) -> list[dict[str, Any]]:
        """A top-level list of objects."""
        value = self.tree.get(name, [])
        if not isinstance(value, list) or not all(isinstance(v, dict) for v in value):
            raise self.wrong(f"'{name}' is no list of objects")
        return cast("list[dict[str, Any]]", value)

    def mapping(self, owner: dict[str, Any], name: str) -> dict[str, Any]:
        """An object inside of an object; empty when absent."""
        value = owner.get(name, {})
        if not isinstance(value, dict):
            raise self.wrong(f"'{name}' is no object")
        return value

    def item(self, name: str, index: object) -> dict[str, Any]:
        """One object of a top-level list.

        Raises:
            InputError: no such index.
        """
        # Not all of the list is looked at: nodes are asked for one by one.
        found = self.tree.get(name, [])
        number = len(found) if isinstance(found, list) else 0
        if not isinstance(index, int) or isinstance(index, bool) or not 0 <= index < number:
            raise self.wrong(f"{name}[{str(index)[:40]}] does not exist; there are {number}")
        if not isinstance(found[index], dict):
            raise self.wrong(f"{name}[{index}] is no object")
        return cast("dict[str, Any]", found[index])

    def size(self, owner: dict[str, Any], name: str, default: int | None = None) -> int:
        """A whole number that is not negative.

        Raises:
            InputError: anything else.
        """
        value = owner.get(name, default)
        if not isinstance(value, int) or isinstance(value, bool) or value < 0:
            raise self.wrong(f"'{name}' is {str(value)[:40]}, no count")
        return value

    def accessor(self, index: object) -> npt.NDArray[np.float64] | npt.NDArray[np.int64]:
        """(count, width) numbers: float64 for floats and normalized integers, else int64.

        Raises:
            InputError: views or offsets beyond their buffers, unknown types.
            LimitError: a count without data behind it.
        """
        item = self.item("accessors", index)
        width, dtype = _WIDTHS.get(str(item.get("type"))), _component(item)
        if width is None or dtype is None:
            kind = f"{str(item.get('type'))[:40]}/{str(item.get('componentType'))[:40]}"
            raise self.wrong(f"accessor of type {kind}")
        count = self.size(item, "count")
        if "bufferView" in item:
            values = self._view(item, dtype, count, width)
        elif count * width * dtype.itemsize > sum(map(len, self.buffers)) + (1 << 20):
            raise LimitError(
                f"accessor of {count:,} zeros without data", location=Location(self.path)
            )
        else:
            values = np.zeros((count, width), dtype=dtype)
        if "sparse" in item:
            values = self._sparse(self.mapping(item, "sparse"), values)
        if dtype.kind == "f":
            return values.astype(np.float64)
        if item.get("normalized"):
            # §3.6.2.2: c / (2^b - 1), signed ones not below -1
            scaled = values.astype(np.float64) / float(np.iinfo(dtype).max)
            return np.maximum(scaled, -1.0)
        return values.astype(np.int64)

    def _view(
        self, item: dict[str, Any], dtype: np.dtype[Any], count: int, width: int
    ) -> npt.NDArray[Any]:
        view = self.item("bufferViews", item.get("bufferView"))
        number = view.get("buffer")
        if not isinstance(number, int) or not 0 <= number < len(self.buffers):
            raise self.wrong(f"buffer {str(number)[:40]} does not exist")
        start = self.size(view, "byteOffset", 0)
        length = self.size(view, "byteLength")
        body = self.buffers[number]
        if start + length > len(body):
            raise self.wrong(f"buffer view of {length:,} bytes reaches beyond its buffer")
        offset = self.size(item, "byteOffset", 0)
        row = width * dtype.itemsize
        stride = self.size(view, "byteStride", 0) or row
        if stride < row or (count and offset + (count - 1) * stride + row > length):
            raise self.wrong(f"accessor of {count:,} items reaches beyond its view")
        if count == 0:
            return np.zeros((0, width), dtype=dtype)
        bytes_ = np.frombuffer(body, dtype=np.uint8, count=length, offset=start)
        # The step from a single item to the next may be any number.
        strides = (stride if count > 1 else row, 1)
        rows = np.lib.stride_tricks.as_strided(
            bytes_[offset:], shape=(count, row), strides=strides, writeable=False
        )
        values: npt.NDArray[Any] = np.ascontiguousarray(rows).view(dtype)
        shaped: npt.NDArray[Any] = values.reshape(count, width)
        return shaped

    def _sparse(self, sparse: dict[str, Any], values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        count = self.size(sparse, "count")
        where = self.mapping(sparse, "indices")
        dtype = _component(where)
        if dtype is None or dtype.kind != "u":
            raise self.wrong("sparse indices are no unsigned integers")
        rows = self._view(where, dtype, count, 1)[:, 0].astype(np.int64)
        if count and rows.max() >= len(values):
            raise self.wrong("sparse index beyond its accessor")
        own = self._view(self.mapping(sparse, "values"), values.dtype, count, values.shape[1])
        result: npt.NDArray[Any] = values.copy()
        result[rows] = own
        return result


def _component(owner: dict[str, Any]) -> np.dtype[Any] | None:
    """The type of the numbers of an accessor, if there is one of that name."""
    name = owner.get("componentType")
    kind = _KINDS.get(name) if isinstance(name, int) else None
    return None if kind is None else np.dtype(kind)


def _buffer(document: Gltf, item: dict[str, Any], k: int, binary: bytes | None, room: int) -> bytes:
    uri = item.get("uri")
    if uri is None:
        if k != 0 or binary is None:
            raise document.wrong(f"buffer {k} has no data")
        body = binary
    elif not isinstance(uri, str):
        raise document.wrong(f"buffer {k} has an unreadable uri")
    elif uri.startswith("data:"):
        try:
            body = base64.b64decode(uri.partition("base64,")[2], validate=True)
        except (binascii.Error, ValueError) as error:
            raise document.wrong(f"buffer {k} is no base64: {error}") from error
    else:
        body = _beside(document, uri, room)
    if len(body) < document.size(item, "byteLength"):
        raise document.wrong(
            f"truncated: buffer {k} has {len(body):,} of {item['byteLength']:,} bytes"
        )
    return body


def beside(path: Path, uri: str) -> Path | None:
    """The file that a relative reference names, if it lies in the folder of ``path`` or below."""
    folder = path.parent.resolve()
    try:
        if urlsplit(uri).scheme or uri.startswith(("/", "\\")):
            return None
        found = (folder / unquote(uri)).resolve()
    except (ValueError, RuntimeError):
        # No URL, a NUL, half of a surrogate pair; links in a circle.
        return None
    return found if found.is_relative_to(folder) else None


def files_of(path: Path) -> tuple[Path, ...]:
    """The files that a document keeps its buffers in, each once; none where it cannot be read."""
    try:
        if path.stat().st_size > FileLimits().max_bytes:
            return ()
        data = path.read_bytes()
        header = chunks(data, path)[0] if data[:4] == b"glTF" else data
        buffers = json.loads(header.decode("utf-8-sig"))["buffers"]
        uris = dict.fromkeys(buffer["uri"] for buffer in buffers if "uri" in buffer)
    except (InputError, OSError, ValueError, LookupError, TypeError, RecursionError):
        return ()
    named = (uri for uri in uris if isinstance(uri, str) and not uri.startswith("data:"))
    found = dict.fromkeys(beside(path, uri) for uri in named)
    return tuple(file for file in found if file is not None and _is_file(file))


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # a name too long
        return False


def _beside(document: Gltf, uri: str, room: int) -> bytes:
    found = beside(document.path, uri)
    if found is None:
        shown = uri[:80].encode("utf-8", "replace").decode()
        raise document.wrong(f"buffer '{shown}' is no file in the glTF's folder or below: refused")
    try:
        mode, size = found.stat().st_mode, found.stat().st_size
        if not stat.S_ISREG(mode):
            # A pipe would keep its reader waiting.
            raise document.wrong(f"buffer '{uri[:80]}' is no regular file")
        if size > room:
            raise LimitError(
                f"buffer '{uri[:80]}' of {size:,} bytes exceeds what is left of the limit",
                location=Location(document.path),
            )
        return found.read_bytes()
    except OSError as error:
        raise document.wrong(f"buffer '{uri[:80]}' cannot be read: {error.strerror}") from error
