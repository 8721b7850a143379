"""Measurements into Parquet files, block by block: however many there are, few are in memory."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import suppress
from itertools import chain
from pathlib import Path

import polars as pl
from polars.io.plugins import register_io_source

from elastocal.errors import InputError
from elastocal.io.files import require_writable
from elastocal.io.tidy import tidy_columns
from elastocal.measurements import Measurements
from elastocal.robot import Robot

PARQUET = (".parquet", ".pq")

ROW_GROUP = 2**18
"""Rows that are written, and read and unpacked, together: as many as polars makes them."""


def is_parquet(path: Path) -> bool:
    """Whether a file is called a Parquet file."""
    return path.suffix.lower() in PARQUET


def write_parquet(path: Path, blocks: Iterable[Measurements], robot: Robot, inputs: Iterable[Path] = ()) -> None:
    """Write measurements as one tidy Parquet table, in degrees and millimetres, whole or not at all.

    Args:
        path: of the file.
        blocks: of the same columns; the next one is asked for when the last one is written.
        robot: whose measurements they are.
        inputs: files that are not overwritten.

    Raises:
        InputError: the file would overwrite an input or cannot be written, or some rows lack what others have.
    """
    require_writable(path.parent, [path.name], inputs)
    frames = (pl.DataFrame(tidy_columns(block, robot)) for block in blocks)
    first = next(frames)
    failed: list[BaseException] = []

    def source(*_: object) -> Iterator[pl.DataFrame]:
        """The frames; what goes wrong is kept, since polars would make another error of it."""
        try:
            yield from chain([first], frames)
        except BaseException as error:
            failed.append(error)
            raise

    path.parent.mkdir(parents=True, exist_ok=True)
    beside = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        register_io_source(source, schema=first.schema).sink_parquet(beside, row_group_size=ROW_GROUP)
        beside.replace(path)
    except (pl.exceptions.PolarsError, OSError) as error:
        raise failed[0] if failed else InputError(f"{path}: cannot be written: {str(error).splitlines()[0]}") from None
    finally:
        with suppress(OSError):
            beside.unlink(missing_ok=True)
