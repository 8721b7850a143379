"""Reading and writing files: whole or not at all."""

from __future__ import annotations

import hashlib
import os
import tempfile
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from elastocal.errors import InputError


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
    try:
        return require_file(path).read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(
            f"{path}: expected UTF-8 text, found byte {error.object[error.start]:#x} at {error.start}"
        ) from None


def require_file(path: Path) -> Path:
    """The path, if it is a file that can be read.

    Raises:
        InputError: it is not; names what lies near.
    """
    if not path.is_file():
        folder = path.parent
        if path.is_dir():
            raise InputError(f"{path}: expected a file, found a folder")
        near = sorted(p.name for p in folder.glob(f"*{path.suffix}"))[:8] if folder.is_dir() else []
        listed = f" (there: {', '.join(near)})" if near else ""
        raise InputError(f"{path}: no such file{listed}")
    if not os.access(path, os.R_OK):
        raise InputError(f"{path}: cannot be read: permission denied")
    return path


def sha256(path: Path) -> str:
    """Hash of a file's bytes."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def write_files(folder: Path, contents: Mapping[str, str | bytes], never: tuple[Path, ...] = ()) -> None:
    """Write files into a folder, all or none: each beside its place first, then all renamed.

    Args:
        folder: made if it is not there.
        contents: by file name.
        never: inputs, which are not overwritten.

    Raises:
        InputError: a file would overwrite an input, or the folder cannot be written to.
    """
    inputs = {path.resolve() for path in never}
    clashes = [name for name in contents if (folder / name).resolve() in inputs]
    if clashes:
        raise InputError(f"{folder / clashes[0]} is an input: choose another folder for the results (-o DIR)")
    written: dict[Path, Path] = {}
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, content in contents.items():
            handle, name_there = tempfile.mkstemp(dir=folder, prefix=f".{name}.")
            written[Path(name_there)] = folder / name
            with os.fdopen(handle, "wb") as file:
                file.write(content.encode() if isinstance(content, str) else content)
        umask = os.umask(0)
        os.umask(umask)
        for temporary, final in written.items():
            temporary.chmod(0o666 & ~umask)
            temporary.replace(final)
    except OSError as error:
        raise InputError(f"{folder}: cannot write: {error.strerror}") from None
    finally:
        for temporary in written:
            temporary.unlink(missing_ok=True)
