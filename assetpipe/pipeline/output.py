"""Writing OUT all at once: the old output or the new one, never a mixture.

Everything is written into a hidden sibling of OUT, which then takes OUT's place by
one rename. What others put into OUT is carried over; an OUT that is not ours is
never touched.
"""

from __future__ import annotations

import contextlib
import ctypes
import filecmp
import json
import os
import secrets
import shutil
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from assetpipe.errors import UsageError

PROVENANCE = "assetpipe.json"
"""Marks a folder as written by us, and says which files in it are ours."""

_STAGE = ".assetpipe-stage-"


@dataclass(frozen=True)
class Stage:
    """A folder that will become OUT.

    Attributes:
        out: absolute, resolved.
        folder: where files are written meanwhile.
    """

    out: Path
    folder: Path

    def path(self, relative: str) -> Path:
        """Where a file of OUT is written; makes its folder.

        Raises:
            UsageError: the path leads out of OUT.
        """
        parts = Path(relative).parts
        if Path(relative).is_absolute() or ".." in parts or not parts:
            raise UsageError(f"'{relative}' is no path inside the output")
        target = self.folder.joinpath(*parts)
        target.parent.mkdir(parents=True, exist_ok=True)
        return target

    def files(self) -> tuple[str, ...]:
        """All files written so far, relative, sorted."""
        return tuple(sorted(list_files(self.folder)))

    def differences(self) -> tuple[str, ...]:
        """Files that OUT lacks, has otherwise, or has from a former build, sorted."""
        ours = set(self.files())
        changed = {name for name in ours if not _same(self.folder / name, self.out / name)}
        return tuple(sorted(changed | (set(owned_files(self.out)) - ours)))

    def commit(self) -> tuple[str, ...]:
        """Let the folder take OUT's place; what changed, as :meth:`differences` tells.

        Raises:
            UsageError: a file that is not ours stands where one of ours must go.
        """
        changed = self.differences()
        if not changed and self.out.is_dir():
            return ()
        self._carry_over()
        _swap(self.folder, self.out)
        return changed

    def _carry_over(self) -> None:
        owned = set(owned_files(self.out)) | {PROVENANCE}
        for name in sorted(set(list_files(self.out)) - owned):
            target = self.folder / name
            if os.path.lexists(target):
                raise UsageError(f"'{self.out / name}' is not ours and would be overwritten")
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(self.out / name, target, follow_symlinks=False)


@contextlib.contextmanager
def staged(out: Path) -> Iterator[Stage]:
    """A stage beside OUT, removed at the end whatever happens.

    Raises:
        UsageError: OUT is a file, or holds what we have not written.
    """
    out = Path(os.path.abspath(out)).resolve()
    refuse_foreign(out)
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
        _remove_leftovers(out)
        folder = out.parent / f".{out.name}{_STAGE}{os.getpid()}-{secrets.token_hex(4)}"
        folder.mkdir()
    except OSError as error:
        raise UsageError(f"cannot write beside '{out}': {error.strerror}") from error
    try:
        yield Stage(out, folder)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


@contextlib.contextmanager
def scratch(out: Path) -> Iterator[Stage]:
    """A stage that is never committed, far from OUT."""
    with tempfile.TemporaryDirectory(prefix="assetpipe-check-") as folder:
        yield Stage(Path(os.path.abspath(out)).resolve(), Path(folder))


def refuse_foreign(out: Path) -> None:
    """Raise unless OUT is absent, empty or ours."""
    if not os.path.lexists(out):
        return
    if not out.is_dir():
        raise UsageError(f"output '{out}' is a file; name a folder")
    if any(out.iterdir()) and provenance_of(out) is None:
        raise UsageError(
            f"output '{out}' is not empty and was not written by assetpipe "
            f"(it has no {PROVENANCE}); choose another folder or remove it"
        )


def provenance_of(folder: Path) -> dict[str, Any] | None:
    """The provenance of a folder that we wrote, else ``None``."""
    try:
        data = json.loads((folder / PROVENANCE).read_bytes())
    except (OSError, ValueError, RecursionError):
        return None
    if not isinstance(data, dict) or not isinstance(data.get("assetpipe"), dict):
        return None
    return data


def owned_files(folder: Path) -> tuple[str, ...]:
    """Files that a former build wrote into the folder, as far as they still exist."""
    data = provenance_of(folder)
    outputs = data.get("outputs") if data else None
    if not isinstance(outputs, dict):
        return ()
    return tuple(
        name
        for name in sorted(str(key) for key in outputs)
        if ".." not in Path(name).parts
        and not Path(name).is_absolute()
        and (folder / name).is_file()
    )


def list_files(folder: Path) -> Iterator[str]:
    """Every file below a folder, relative, with forward slashes."""
    for parent, folders, names in os.walk(folder):
        folders.sort()
        here = Path(parent).relative_to(folder)
        links = [name for name in folders if Path(parent, name).is_symlink()]
        for name in sorted([*names, *links]):
            yield (here / name).as_posix()


def _same(a: Path, b: Path) -> bool:
    try:
        return filecmp.cmp(a, b, shallow=False)
    except OSError:
        return False


def _swap(folder: Path, out: Path) -> None:
    """Put ``folder`` in the place of ``out``; what stood there ends where ``folder`` was."""
    if not out.is_dir():
        os.rename(folder, out)
        return
    if _exchange(folder, out):
        return
    # No atomic exchange here: a moment without OUT, but never half an OUT.
    aside = folder.with_name(folder.name + "-old")
    os.rename(out, aside)
    try:
        os.rename(folder, out)
    except OSError:
        os.rename(aside, out)
        raise
    shutil.rmtree(aside, ignore_errors=True)


def _exchange(a: Path, b: Path) -> bool:
    """Exchange two folders in one step, where the system can (Linux: renameat2)."""
    if not sys.platform.startswith("linux"):
        return False
    try:
        renameat2 = ctypes.CDLL(None, use_errno=True).renameat2
    except (OSError, AttributeError):
        return False
    at_cwd, exchange = -100, 2
    done: int = renameat2(at_cwd, os.fsencode(a), at_cwd, os.fsencode(b), exchange)
    return done == 0


def _remove_leftovers(out: Path) -> None:
    """Remove stages of runs that were killed; bring back an OUT that one of them set aside."""
    prefix = f".{out.name}{_STAGE}"
    for path in sorted(out.parent.glob(f"{_escaped(prefix)}*")):
        number = path.name[len(prefix) :].split("-")[0]
        if not number.isdigit() or _alive(int(number)):
            continue
        if path.name.endswith("-old") and not out.exists():
            os.rename(path, out)
        else:
            shutil.rmtree(path, ignore_errors=True)


def _escaped(name: str) -> str:
    return "".join(f"[{c}]" if c in "*?[" else c for c in name)


def _alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (PermissionError, OverflowError):
        return True
    return True
