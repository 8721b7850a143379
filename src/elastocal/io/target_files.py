"""Tables of targets, in blocks: however long they are, memory holds a few thousand rows."""

from __future__ import annotations

import codecs
import csv
import re
from collections.abc import Iterator
from dataclasses import dataclass
from io import StringIO
from pathlib import Path

import numpy as np
import polars as pl
from numpy.typing import NDArray

from elastocal.compensation import BLOCK, NO_NOMINAL, Targets
from elastocal.errors import InputError, unknown_name
from elastocal.io.descriptor import read_described
from elastocal.io.files import require_file
from elastocal.io.measurement_files import check_joints, check_lengths
from elastocal.io.tables import SHEETS, Table, check_delimiter, more, uneven_rows
from elastocal.io.tidy import joint_names, read_tidy
from elastocal.measurements import Labels, Measurements
from elastocal.robot import Robot

PIECE = 1 << 20
"""Bytes of a text file that are read at once."""


@dataclass(frozen=True)
class TargetFile:
    """A table of targets: CSV, Parquet, or what a TOML descriptor describes.

    Attributes:
        path: the file.
        robot: whose joints, targets and payloads it names.
        load: payload of rows that name none.
        target: TCP of rows that name none; None: the tool's origin.
        nominal_known: whether joint positions alone will do.
    """

    path: Path
    robot: Robot
    load: str | None = None
    target: str | None = None
    nominal_known: bool = True

    def blocks(self, count: int = BLOCK) -> Iterator[tuple[Targets, float]]:
        """Blocks of `count` targets each, but the last, each with how much of the file has been read, 0 to 1.

        Raises:
            InputError: with the faults of the first block that has any.
        """
        if require_file(self.path).suffix.lower() == ".toml":
            yield from self._described(count)
            return
        rest, first = pl.DataFrame(), 0
        for frame, share in self._frames():
            rest = frame if rest.is_empty() else pl.concat([rest, frame])
            while rest.height > count:  # the last row is kept back, since what follows the rows may be empty
                yield self._targets(rest.head(count), first), share
                rest, first = rest.tail(-count), first + count
        blank = _blank(rest)
        height = len(blank) - int(np.argmin(blank[::-1])) if len(blank) and not blank.all() else 0
        if height:
            yield self._targets(rest.head(height), first), 1.0
        elif not first:
            raise InputError(f"{self.path}: expected at least one target, found none")

    def _frames(self) -> Iterator[tuple[pl.DataFrame, float]]:
        if self.path.suffix.lower() in (".parquet", ".pq"):
            return _parquet_frames(self.path)
        if self.path.suffix.lower() in SHEETS:
            raise InputError(f"{self.path}: expected CSV, Parquet or a TOML descriptor: save the sheet as CSV")
        return _text_frames(self.path)

    def _described(self, count: int) -> Iterator[tuple[Targets, float]]:
        """A file that a descriptor describes; it is read as a whole."""
        table, data = read_described(self.path, self.robot)
        whole = self._checked(table, data, program=True)
        for first in range(0, len(whole), count):
            yield whole.take(slice(first, first + count)), min(1.0, (first + count) / len(whole))

    def _targets(self, frame: pl.DataFrame, first: int) -> Targets:
        """The targets of some rows of the file, checked.

        Raises:
            InputError: with every fault.
        """
        repeated = frozenset(name for name in frame.columns if f"{name} of column " in " ".join(frame.columns))
        table = Table(self.path, frame, blank=_blank(frame), repeated=repeated, above=first)
        table.no_blank_rows()
        joints = joint_names(self.robot)
        program = any(re.match(r"\s*[qQ]\d+\b", name) for name in frame.columns)
        if not program:  # the reader of measurements wants joint positions: zeros, which are dropped again
            table.frame = frame.with_columns(*(pl.lit(0.0).alias(name) for name in joints))
        return self._checked(table, read_tidy(table, self.robot, measured=False), program)

    def _checked(self, table: Table, data: Measurements, program: bool) -> Targets:
        """Targets, if nothing is wrong with them.

        Raises:
            InputError: with every fault.
        """
        if table.sound:
            self._check(table, data, program)
        table.raise_faults()
        return Targets(
            position=data.position,
            orientation=data.orientation,
            q=data.q if program else None,
            target=_filled(data.target, self.target, len(data)),
            load=_filled(data.load, self.load, len(data)),
            wrench=data.wrench,
        )

    def _check(self, table: Table, data: Measurements, program: bool) -> None:
        if data.position is None and data.orientation is not None:
            table.fault("expected the columns x, y, z beside qw, qx, qy, qz, found none")
        elif data.position is None and not program:
            table.fault(
                "expected targets: columns x, y, z, or joint positions q1 … qn of the nominal robot, found none"
            )
        elif data.position is None and not self.nominal_known:
            table.fault(NO_NOMINAL)
        for kind, labels, valid in (("target", data.target, self.robot.targets), ("load", data.load, self.robot.loads)):
            for code, name in enumerate(labels.names if labels is not None else ()):
                if labels is not None and name not in valid:
                    rows = np.flatnonzero(labels.codes == code)
                    place = f"{self.path}: row {table.number(int(rows[0]))}, column {table.header(kind).text!r}"
                    table.faults.append(
                        f"{place}: {self.robot.name} has {unknown_name(kind, name, valid)}{more(len(rows) - 1)}"
                    )
        if program:
            check_joints(self.robot, data, table)
        check_lengths(data, table)


def _filled(labels: Labels | None, default: str | None, n: int) -> Labels | None:
    """Names of rows, those without one given the default."""
    if labels is None or default is None:
        return labels or Labels.same(default, n)
    names = labels.names if default in labels.names else (*labels.names, default)
    return Labels(names, np.where(labels.codes < 0, names.index(default), labels.codes).astype(np.int32))


def _blank(frame: pl.DataFrame) -> NDArray[np.bool_]:
    if not frame.width:
        return np.zeros(0, dtype=bool)
    return frame.select(pl.all_horizontal(pl.all().is_null())).to_series().to_numpy()


def _parquet_frames(path: Path) -> Iterator[tuple[pl.DataFrame, float]]:
    try:
        lazy = pl.scan_parquet(path)
        height = int(lazy.select(pl.len()).collect().item())
        for start in range(0, height, 16 * BLOCK):
            frame = lazy.slice(start, 16 * BLOCK).collect()
            yield frame.rename({name: name.strip() for name in frame.columns}), min(1.0, (start + 16 * BLOCK) / height)
    except pl.exceptions.PolarsError as error:
        raise InputError(f"{path}: not a Parquet file: {str(error).splitlines()[0]}") from None


def _text_frames(path: Path) -> Iterator[tuple[pl.DataFrame, float]]:
    """Pieces of a CSV file, cut between rows; all columns text."""
    size, read, above, rest, header = path.stat().st_size, 0, 0, "", ""
    decode = codecs.getincrementaldecoder("utf-8-sig")().decode
    with path.open("rb") as file:
        while True:
            piece = file.read(PIECE)
            read += len(piece)
            try:
                rest += decode(piece, final=not piece)
            except UnicodeDecodeError as error:
                found = f"byte {error.object[error.start]:#x} after row {above}"
                raise InputError(f"{path}: expected UTF-8 text, found {found}: save it as UTF-8") from None
            rows, rest = _whole_rows(rest) if piece else (rest, "")
            if not header:
                header, _, rows = rows.lstrip("\r\n").partition("\n")
            if rows:
                frame = _frame(path, header, rows, above)
                above += frame.height
                yield frame, read / size
            if not piece:
                return


def _whole_rows(text: str) -> tuple[str, str]:
    """Text up to the last end of a line that is not within quotes, and what follows."""
    end = text.rfind("\n") + 1
    while end and text.count('"', 0, end) % 2:
        end = text.rfind("\n", 0, end - 1) + 1
    return text[:end], text[end:]


def _frame(path: Path, header: str, rows: str, above: int) -> pl.DataFrame:
    """Some rows of a CSV file under its header."""
    text = f"{header}\n{rows}"
    try:
        names = [name.strip() for name in next(csv.reader(StringIO(header)))]
        check_delimiter(path, names, ",", None)
        frame = pl.read_csv(text.encode(), infer_schema=False)
        frame.columns = [f"{n} of column {i}" if n in names[: i - 1] else n for i, n in enumerate(names, start=1)]
        uneven = list(uneven_rows(path, text, ",", above)) if frame.height and frame[:, -1].null_count() else []
    except (pl.exceptions.PolarsError, csv.Error) as error:
        why = f"{path}: cannot be read as a table: {str(error).splitlines()[0]}"
        raise InputError(*(list(uneven_rows(path, text, ",", above)) or [why])) from None
    if uneven:
        raise InputError(*uneven)
    return frame
