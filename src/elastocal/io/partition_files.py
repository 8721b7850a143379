"""Parquet data sets: files and folders of files, read in parts where they are too large to hold at once."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import polars as pl

from elastocal.errors import InputError
from elastocal.io.files import require_file
from elastocal.io.measurement_files import (
    checked,
    load_measurements,
    placed,
    require_different,
    source_names,
    with_default_target,
)
from elastocal.io.parquet_files import ROW_GROUP, is_parquet
from elastocal.io.tables import MOST_FAULTS, Table
from elastocal.io.tidy import read_tidy
from elastocal.measurements import Measurements, concatenate
from elastocal.parallel import in_order
from elastocal.partitions import SAMPLE, Partitions, drawn
from elastocal.robot import Robot

PART_ROWS = ROW_GROUP
"""Rows of a part: a row group, since that is read as a whole; one takes 100 MB while it is worked through."""

HELD_ROWS = 2_000_000
"""Data sets of up to so many rows are held in memory, where they take 1 GB with all that a fit makes of them."""


def data_files(paths: Iterable[str | Path]) -> list[Path]:
    """The files of measurements: those given, and the Parquet files in the folders given, by name.

    Raises:
        InputError: a folder has no Parquet files.
    """
    files: list[Path] = []
    for path in map(Path, paths):
        if not path.is_dir():
            files.append(path)
            continue
        found = sorted(each for each in path.rglob("*") if is_parquet(each) and not each.name.startswith((".", "_")))
        if not found:
            raise InputError(f"{path}: expected a file, or a folder with Parquet files, found a folder without any")
        files += found
    return files


def too_large(files: Sequence[Path]) -> bool:
    """Whether files are Parquet of more than HELD_ROWS rows together, which are not held in memory at once.

    Raises:
        InputError: one is no Parquet file though it is called so.
    """
    return all(map(is_parquet, files)) and sum(map(_height, files)) > HELD_ROWS


def open_measurements(
    paths: Sequence[str | Path],
    robot: Robot,
    *,
    executor: Executor | None = None,
    on_part: Callable[[int, int], None] | None = None,
) -> Measurements | Partitions:
    """Measurements in memory, or in parts if they are too large.

    Args:
        paths: files, as `load_measurements` reads them, and folders of Parquet files.
        robot: whose joints, targets, payloads and stations they name.
        executor: where parts are checked; None: here.
        on_part: called with the number of parts checked, and of all.

    Raises:
        InputError: with every fault found.
    """
    files = data_files(paths)
    if too_large(files):
        return scan_measurements(files, robot, executor=executor, on_part=on_part)
    return load_measurements(files, robot)


def scan_measurements(
    paths: str | Path | Sequence[str | Path],
    robot: Robot,
    *,
    part_rows: int = PART_ROWS,
    executor: Executor | None = None,
    on_part: Callable[[int, int], None] | None = None,
) -> Partitions:
    """Open a Parquet data set of any size for `calibrate`: every row is checked now, and read again when it is needed.

    Args:
        paths: files, and folders of files.
        robot: whose joints, targets, payloads and stations they name.
        part_rows: so many rows are held at a time; best a whole number of the files' row groups.
        executor: where parts are checked; None: here.
        on_part: called with the number of parts checked, and of all.

    Raises:
        InputError: with every fault found: its place, what was expected and what was found.
    """
    if part_rows < 1:
        raise InputError(f"part_rows is {part_rows}: expected at least 1")
    files = data_files([paths] if isinstance(paths, (str, Path)) else paths)
    require_different(files)
    others = [path for path in files if not is_parquet(path)]
    if others:
        raise InputError(*(f"{path}: expected a Parquet file, found {path.suffix or 'no suffix'}" for path in others))
    named = zip(files, source_names(files), strict=True)
    parts = [part for path, source in named for part in _parts_of(path, source, robot, part_rows)]
    share = SAMPLE / sum(part.rows for part in parts)
    looks = in_order(partial(_looked_at, share if share < 1.0 else 1.0), list(enumerate(parts)), executor, chunk=1)
    return Partitions(tuple(parts), concatenate(list(_sound(_told(looks, len(parts), on_part)))))


@dataclass(frozen=True)
class FilePart:
    """Some rows of a Parquet file, read when they are asked for.

    Attributes:
        path: of the file, the same wherever it is read.
        source: what it is called.
        above: how many of its rows come before these.
        rows: how many these are.
        columns: of the file, that are read.
        robot: whose measurements they are.
    """

    path: Path
    source: str
    above: int
    rows: int
    columns: tuple[str, ...]
    robot: Robot

    def read(self) -> Measurements:
        """The rows, which have been checked."""
        table = self._table()
        data = with_default_target(self.robot, read_tidy(table, self.robot), table)
        table.raise_faults()
        return placed(data, self.source, self.above)

    def checked(self) -> Measurements:
        """The rows, if nothing is wrong with them.

        Raises:
            InputError: with every fault of them.
        """
        table = self._table()
        table.no_blank_rows()
        data = checked(read_tidy(table, self.robot), self.robot, table)
        return placed(data, self.source, self.above)

    def _table(self) -> Table:
        frame = _scan(self.path).slice(self.above, self.rows).select(self.columns)
        return _table_of(self.path, _collected(self.path, frame), self.above)


def _parts_of(path: Path, source: str, robot: Robot, part_rows: int) -> Iterator[FilePart]:
    """The parts of a file, as equal as they can be in whole row groups."""
    height = _height(path)
    if not height:
        raise InputError(f"{path}: expected at least one row of measurements, found none")
    columns = _known_columns(path, robot)
    for above in range(0, height, part_rows):
        yield FilePart(path.absolute(), source, above, min(part_rows, height - above), columns, robot)


def _known_columns(path: Path, robot: Robot) -> tuple[str, ...]:
    """The columns of a file that measurements have.

    Raises:
        InputError: they are not those of the robot's measurements.
    """
    frame = _collected(path, _scan(path).head(1))
    table = _table_of(path, frame, 0)
    read_tidy(table, robot)
    if not table.sound:
        table.raise_faults()
    known = {header.text for header in table.headers.values()}
    return tuple(name for name in frame.columns if name.strip() in known)


def _table_of(path: Path, frame: pl.DataFrame, above: int) -> Table:
    blank = frame.select(pl.all_horizontal(pl.all().is_null())).to_series().to_numpy()
    stripped = frame.rename({name: name.strip() for name in frame.columns})
    return Table(path, stripped, blank=blank, above=above)


def _scan(path: Path) -> pl.LazyFrame:
    return pl.scan_parquet(path, glob=False, hive_partitioning=False)


def _height(path: Path) -> int:
    """The number of a Parquet file's rows, from its footer."""
    require_file(path)
    return int(_collected(path, _scan(path).select(pl.len())).item())


def _collected(path: Path, frame: pl.LazyFrame) -> pl.DataFrame:
    try:
        return frame.collect()
    except (pl.exceptions.PolarsError, OSError) as error:
        raise InputError(f"{path}: not a Parquet file: {str(error).splitlines()[0]}") from None


def _looked_at(share: float, item: tuple[int, FilePart]) -> Measurements | InputError:
    """What the sample has of a numbered part, or what is wrong with it."""
    number, part = item
    try:
        data = part.checked()
    except InputError as error:
        return error
    return data.take(drawn(data, share, number))


def _told(
    looks: Iterable[Measurements | InputError], count: int, on_part: Callable[[int, int], None] | None
) -> Iterator[Measurements | InputError]:
    """What was found, after telling how far this is."""
    for done, found in enumerate(looks, start=1):
        if on_part is not None:
            on_part(done, count)
        yield found


def _sound(found: Iterable[Measurements | InputError]) -> Iterator[Measurements]:
    """What was found, if all of it is sound.

    Raises:
        InputError: with every fault.
    """
    faults: list[str] = []
    for one in found:
        if isinstance(one, InputError):
            faults += one.faults
        elif not faults:
            yield one
    if faults:
        rest = len(faults) - MOST_FAULTS
        raise InputError(*faults[:MOST_FAULTS], *([f"and {rest} more faults"] if rest > 0 else []))
