"""Reading and writing files: whole or not at all."""

from __future__ import annotations

import codecs
import hashlib
import os
import shutil
import tempfile
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from elastocal.errors import InputError

MOST_LISTED = 8
"""Files that lie near one that does not exist: so many are listed."""


def read_toml(path: Path) -> dict[str, Any]:
    """A TOML file as a dictionary.

    Raises:
        InputError: it is missing, is not text, or is not TOML; names line and column.
    """
    try:
        return tomllib.loads(read_text(path))
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: not valid TOML: {error}") from None


def read_text(path: Path) -> str:
    """The text of a UTF-8 file, a byte order mark dropped.

    Raises:
        InputError: it is missing, cannot be read or is not UTF-8.
    """
    content = read_bytes(path)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        wide = content[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)
        found = "UTF-16" if wide else f"byte {content[error.start]:#x} in line {line}"
        raise InputError(f"{path}: expected UTF-8 text, found {found}: save it as UTF-8") from None


def read_bytes(path: Path) -> bytes:
    """The bytes of a file.

    Raises:
        InputError: it is missing or cannot be read.
    """
    try:
        return require_file(path).read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {_reason(error)}") from None


def require_file(path: Path) -> Path:
    """The path, if it is a file that can be read.

    Raises:
        InputError: it is not; names what lies near.
    """
    try:
        if path.is_dir():
            raise InputError(f"{path}: expected a file, found a folder")
        if not path.is_file():
            raise InputError(f"{path}: no such file{_near(path)}")
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {_reason(error)}") from None
    if not os.access(path, os.R_OK):
        raise InputError(f"{path}: cannot be read: permission denied")
    return path


def _near(path: Path) -> str:
    """What may have been meant by a file that does not exist."""
    folder = path.parent
    if not folder.is_dir():
        return f": there is no folder {folder}"
    there = sorted(p.name for p in folder.glob(f"*{path.suffix}") if p.is_file())
    near = get_close_matches(path.name, there, n=1)
    hint = f"; did you mean {near[0]}?" if near else ""
    listed = ", ".join(there[:MOST_LISTED]) + (", …" if len(there) > MOST_LISTED else "")
    return hint + (f" (there: {listed})" if there else "")


def _reason(error: OSError) -> str:
    return (error.strerror or str(error)).lower()


def sha256(path: Path) -> str:
    """Hash of a file's bytes."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def require_writable(folder: Path, names: Iterable[str], never: Iterable[Path] = ()) -> None:
    """Check that files can be written into a folder, before the work whose results they hold.

    Args:
        folder: which need not be there yet.
        names: of the files.
        never: inputs, which are not overwritten.

    Raises:
        InputError: one would overwrite an input, or the folder cannot be written to.
    """
    try:
        faults = [*_place_faults(folder, names, never), *_folder_faults(folder)]
    except OSError as error:
        raise InputError(f"{folder}: cannot be written to: {_reason(error)}") from None
    if faults:
        raise InputError(*faults)


def _place_faults(folder: Path, names: Iterable[str], never: Iterable[Path]) -> Iterator[str]:
    inputs = {path.resolve() for path in never}
    for name in names:
        path = folder / name
        if path.resolve() in inputs:
            yield f"{path} is an input, which a result never overwrites: choose another place (-o)"
        elif path.is_dir():
            yield f"{path}: expected a file to write, found a folder"


def _folder_faults(folder: Path) -> Iterator[str]:
    there = next(parent for parent in (folder, *folder.parents) if parent.exists())
    if not there.is_dir():
        yield f"{there}: expected a folder to write into, found a file"
    elif not os.access(there, os.W_OK | os.X_OK):
        yield f"{there}: cannot be written to: permission denied"


def write_files(folder: Path, contents: Mapping[str, str | bytes], never: Iterable[Path] = ()) -> None:
    """Write files into a folder, all or none: each beside its place first, then all renamed.

    Args:
        folder: made if it is not there.
        contents: by file name.
        never: inputs, which are not overwritten.

    Raises:
        InputError: a file would overwrite an input, or the folder cannot be written to.
    """
    require_writable(folder, contents, never)
    missing = [path for path in (folder, *folder.parents) if not path.exists()]
    spare: list[Path] = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        written = {folder / name: _written(folder, name, content, spare) for name, content in contents.items()}
        _put_in_place(written, spare)
    except BaseException as error:
        _remove(spare)
        for made in missing:
            with suppress(OSError):
                made.rmdir()
        if isinstance(error, OSError):
            raise InputError(f"{folder}: cannot be written to: {_reason(error)}") from None
        raise
    _remove(spare)


def _written(folder: Path, name: str, content: str | bytes, spare: list[Path]) -> Path:
    """A new file with some content beside its place, noted in `spare`."""
    handle, there = tempfile.mkstemp(dir=folder, prefix=f".{name}.")
    spare.append(Path(there))
    with os.fdopen(handle, "wb") as file:
        file.write(content.encode() if isinstance(content, str) else content)
    umask = os.umask(0)
    os.umask(umask)
    spare[-1].chmod(0o666 & ~umask)
    return spare[-1]


def _put_in_place(written: Mapping[Path, Path], spare: list[Path]) -> None:
    """Rename files to their places; should one fail, what stood there before is put back."""
    before: dict[Path, Path | None] = {}
    try:
        for final, temporary in written.items():
            old = temporary.with_name(f"{temporary.name}.old") if final.exists() else None
            if old is not None:
                spare.append(old)
                shutil.copy2(final, old)
            before[final] = old
            temporary.replace(final)
    except BaseException:
        for final, old in before.items():
            if old is None:
                final.unlink(missing_ok=True)
            else:
                old.replace(final)
        raise


def _remove(paths: Iterable[Path]) -> None:
    for path in paths:
        with suppress(OSError):
            path.unlink(missing_ok=True)
