"""Files that the user gives: their names made harmless, written as they come, whole or not at all."""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import AsyncIterator
from pathlib import Path

from elastocal.errors import InputError

MOST_FILES = 100
"""Files of one run, at most."""

MOST_NAME = 120
"""Characters of a file's name, at most."""

_OTHERS = re.compile(r"[^\w .,()+=@-]")


def safe_name(name: str) -> str:
    """The last part of a name as it was sent, with letters, digits and a few marks only, as a plain file's name.

    Raises:
        InputError: nothing is left of it, or it is too long.
    """
    last = re.split(r"[/\\]", name)[-1]
    plain = _OTHERS.sub("_", last).strip()
    plain = re.sub(r"^[.-]+", "_", plain)
    if not plain.strip("._ "):
        raise InputError(f"a file's name: expected letters or digits, found {name[:MOST_NAME]!r}")
    if len(plain.encode()) > MOST_NAME:
        raise InputError(f"{plain[:40]}…: expected a name of at most {MOST_NAME} characters")
    return plain


async def save_upload(folder: Path, name: str, chunks: AsyncIterator[bytes]) -> str:
    """Write a file piece by piece beside its place, then put it there; nothing is left of one that breaks off.

    Args:
        folder: of the run's inputs.
        name: as it was sent.
        chunks: its content, of which no more than a piece is in memory; the middleware bounds them.

    Returns:
        The name that it got.

    Raises:
        InputError: the name is no good, or there are too many files already.
    """
    plain = safe_name(name)
    folder.mkdir(parents=True, exist_ok=True)
    there = {path.name for path in folder.iterdir()}
    if plain not in there and len(there) >= MOST_FILES:
        raise InputError(f"{plain}: a run has {MOST_FILES} files at most")
    handle, temporary = tempfile.mkstemp(dir=folder.parent, prefix=".upload-")
    try:
        with os.fdopen(handle, "wb") as file:
            async for chunk in chunks:
                file.write(chunk)
        Path(temporary).replace(folder / plain)
    finally:
        Path(temporary).unlink(missing_ok=True)
    return plain
