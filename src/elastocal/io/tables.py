"""Measurement tables: CSV and Parquet with units in the headers, in."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from io import BytesIO, StringIO
from pathlib import Path
from typing import NamedTuple

import numpy as np
import polars as pl
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.errors import InputError
from elastocal.io.files import read_bytes, read_text, require_file

MOST_FAULTS = 20
"""Faults of one file that are told one by one."""

SHEETS = (".xlsx", ".xls", ".ods")


class Header(NamedTuple):
    """A column's header as it stands in the file, and its unit; None: SI."""

    text: str
    unit: str | None


@dataclass
class Table:
    """A table as read, and the faults found in it.

    Attributes:
        path: the file.
        frame: its columns; of a text file all strings.
        decimal: the decimal mark of a text file.
        described: the descriptor that says how to read it, if one does.
        repeated: headers that stand above several columns.
        blank: (rows,) which of them are empty.
        headers: by the names that a fault in a row speaks of, "q1".
        faults: one sentence each.
        sound: whether its columns are what they should be, so that their rows can be judged.
        above: how many rows of the file are above these, where they are a part of it.
    """

    path: Path
    frame: pl.DataFrame
    decimal: str = "."
    described: Path | None = None
    repeated: frozenset[str] = frozenset()
    blank: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=bool))
    headers: dict[str, Header] = field(default_factory=dict)
    faults: list[str] = field(default_factory=list)
    sound: bool = True
    above: int = 0

    def __len__(self) -> int:
        return self.frame.height

    def number(self, row: int) -> int:
        """The number of a row in the file, from 1."""
        return self.above + row + 1

    def header(self, name: str) -> Header:
        """The header of the column that a name stands for."""
        return self.headers.get(name, Header(name, None))

    def with_unit(self, name: str, unit: str) -> str:
        """What to write so that a column has a unit."""
        if self.described is not None:
            return f'unit = "{unit}" in {self.described.name}'
        return f"the header '{name} [{unit}]'"

    def fault(self, text: str) -> None:
        """Note a fault of the table as a whole."""
        self.faults.append(f"{self.path}: {text}")
        self.sound = False

    def rows_fault(self, column: str, rows: Sequence[int], found: str, expected: str) -> None:
        """Note a fault in some rows of a column: the first of them, and how many there are."""
        if len(rows):
            place = f"row {self.number(rows[0])}, column {column!r}"
            self.faults.append(f"{self.path}: {place}: expected {expected}, found {found}{more(len(rows) - 1)}")

    def no_blank_rows(self) -> None:
        """Note rows that are empty."""
        empty = np.flatnonzero(self.blank)
        if len(empty):
            place, others = f"row {self.number(empty[0])}", more(len(empty) - 1)
            self.faults.append(f"{self.path}: {place}: expected measurements, found none{others}")

    def numbers(self, column: str) -> Array:
        """A column of numbers, (rows,); what is none is a fault, and NaN."""
        series = self.frame[column]
        if not (series.dtype == pl.String or series.dtype == pl.Null or series.dtype.is_numeric()):
            self.fault(f"column {column!r}: expected numbers, found {series.dtype}")
            return np.zeros(len(self))
        if series.dtype == pl.String:
            series = series.str.strip_chars()
            parsed = self._pointed(series).cast(pl.Float64, strict=False)
        else:
            parsed = series.cast(pl.Float64, strict=False)
        values = parsed.fill_null(float("nan")).to_numpy().copy()
        bad = np.flatnonzero(~np.isfinite(values) & ~self.blank)
        if len(bad):
            first = series[int(bad[0])]
            found = "an empty cell" if first in (None, "") else shortened(repr(first))
            self.rows_fault(column, bad.tolist(), found, self._number(str(first)))
        values[bad] = np.nan
        return values

    def _pointed(self, text: pl.Series) -> pl.Series:
        """Text of numbers with a decimal point; where a comma is expected, a point is no part of a number."""
        if self.decimal == ".":
            return text
        return text.str.replace_all(".", "?", literal=True).str.replace(self.decimal, ".", literal=True)

    def _number(self, found: str) -> str:
        """What is expected where something else was found."""
        if self.decimal == "." and re.fullmatch(r"-?\d*,\d+", found):
            remedy = f"write in {self.described.name}" if self.described else "describe the file by a TOML with"
            return f'a number with a decimal point (for decimal commas {remedy} decimal = ",")'
        return "a number with a decimal comma" if self.decimal == "," and "." in found else "a number"

    def is_empty(self, column: str) -> bool:
        """Whether nothing stands in a column."""
        series = self.frame[column]
        text = series.str.strip_chars().replace("", None) if series.dtype == pl.String else series
        return text.null_count() == len(series) > 0

    def names(self, column: str) -> list[str | None]:
        """A column of names; an empty cell is None."""
        if self.frame[column].dtype.is_nested():
            self.fault(f"column {column!r}: expected names, found {self.frame[column].dtype}")
            return [None] * len(self)
        return [text.strip() or None if text else None for text in self.frame[column].cast(pl.String).to_list()]

    def raise_faults(self) -> None:
        """Raise what was found.

        Raises:
            InputError: if there is any fault.
        """
        if self.faults:
            shown = list(dict.fromkeys(self.faults))
            rest = len(shown) - MOST_FAULTS
            raise InputError(*shown[:MOST_FAULTS], *([f"{self.path}: and {rest} more faults"] if rest > 0 else []))


def shortened(text: str) -> str:
    """A text that may be long, fit for a sentence."""
    return text if len(text) < 60 else text[:57] + "..."


def more(count: int, what: str = "row") -> str:
    """How many more rows have the same fault."""
    return f" (and {count} more {what if count == 1 else f'{what}s'})" if count else ""


def read_table(
    path: Path, delimiter: str = ",", decimal: str = ".", skip: int = 0, described: Path | None = None
) -> Table:
    """A CSV or Parquet file as a table.

    Args:
        path: of the file.
        delimiter: between the fields of a text file.
        decimal: its decimal mark.
        skip: lines above its header.
        described: the descriptor that says all this.

    Raises:
        InputError: it is missing, empty, or its rows have different numbers of fields.
    """
    if require_file(path).suffix.lower() in SHEETS:
        raise InputError(f"{path}: expected CSV, Parquet or a TOML descriptor: save the sheet as CSV")
    if path.suffix.lower() in (".parquet", ".pq"):
        frame, repeated = _read_parquet(path), frozenset[str]()
    else:
        frame, repeated = _read_text(path, delimiter, skip, described)
    if not frame.width or not frame.height:
        raise InputError(f"{path}: expected at least one row of measurements, found none")
    blank = frame.select(pl.all_horizontal(pl.all().is_null())).to_series().to_numpy()
    height = len(blank) - int(np.argmin(blank[::-1])) if not blank.all() else 0
    if not height:
        raise InputError(f"{path}: expected at least one row of measurements, found none")
    table = Table(path, frame.head(height), decimal, described, repeated, blank[:height])
    table.no_blank_rows()
    return table


def _read_parquet(path: Path) -> pl.DataFrame:
    try:
        frame = pl.read_parquet(BytesIO(read_bytes(path)))
    except pl.exceptions.PolarsError as error:
        raise InputError(f"{path}: not a Parquet file: {str(error).splitlines()[0]}") from None
    return frame.rename({name: name.strip() for name in frame.columns})


def _read_text(path: Path, delimiter: str, skip: int, described: Path | None) -> tuple[pl.DataFrame, frozenset[str]]:
    """Columns of text, named by their headers; and the headers that occur several times."""
    text = read_text(path)
    for _ in range(skip):
        text = text.partition("\n")[2]
    text = text.lstrip("\r\n")
    if not text.strip():
        raise InputError(f"{path}: expected a header and rows, found an empty file")
    try:
        header = [name.strip() for name in next(_records(text, delimiter))]
        check_delimiter(path, header, delimiter, described)
        frame = pl.read_csv(text.encode(), separator=delimiter, infer_schema=False)
        frame.columns = [
            f"{name} of column {i}" if name in header[: i - 1] else name for i, name in enumerate(header, start=1)
        ]
        uneven = list(uneven_rows(path, text, delimiter)) if frame[:, -1].null_count() else []
    except (pl.exceptions.PolarsError, csv.Error) as error:
        why = f"{path}: cannot be read as a table: {str(error).splitlines()[0]}"
        raise InputError(*(list(uneven_rows(path, text, delimiter)) or [why])) from None
    if uneven:
        raise InputError(*uneven)
    return frame, frozenset(name for name, count in Counter(header).items() if count > 1)


def _records(text: str, delimiter: str) -> Iterator[list[str]]:
    return csv.reader(StringIO(text, newline=""), delimiter=delimiter)


def check_delimiter(path: Path, header: list[str], delimiter: str, described: Path | None) -> None:
    """Raise InputError if the header is one column because something else stands between columns."""
    mark = next((mark for mark in (";", "\t", ",", "|") if mark in header[0]), None) if len(header) == 1 else None
    if mark is not None:
        remedy = f"write in {described.name}" if described else "describe the file by a TOML with"
        raise InputError(
            f"{path}: expected {delimiter!r} between columns, found {mark!r} in the header {header[0][:40]!r}: "
            f"{remedy} delimiter = {mark!r}".replace("'", '"')
        )


def uneven_rows(path: Path, text: str, delimiter: str, above: int = 0) -> Iterator[str]:
    """Rows that have other numbers of fields than the header; `above` rows of the file come before them."""
    try:
        header, *rows = _records(text, delimiter)
    except csv.Error:
        return
    width = len(header)
    uneven = [(i, len(row)) for i, row in enumerate(rows, start=above + 1) if row and len(row) != width]
    if uneven:
        row, found = uneven[0]
        remedy = 'export them with ";" between columns, described by a TOML with delimiter = ";" and decimal = ","'
        hint = f"; decimal commas? {remedy}" if delimiter == "," and found > width else ""
        yield f"{path}: row {row}: expected {width} fields as in the header, found {found}{more(len(uneven) - 1)}{hint}"
