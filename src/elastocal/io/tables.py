"""Measurement tables: CSV and Parquet with units in the headers, in."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import polars as pl

from elastocal.chain import Array
from elastocal.errors import InputError
from elastocal.io.files import read_text, require_file

MOST_FAULTS = 20
"""Faults of one file that are told one by one."""


@dataclass
class Table:
    """A table as read, and the faults found in it.

    Attributes:
        path: the file.
        frame: its columns; of a text file all strings.
        decimal: the decimal mark of a text file.
    """

    path: Path
    frame: pl.DataFrame
    decimal: str = "."
    faults: list[str] = field(default_factory=list)

    def __len__(self) -> int:
        return self.frame.height

    def fault(self, text: str) -> None:
        """Note a fault of the file."""
        self.faults.append(f"{self.path}: {text}")

    def rows_fault(self, column: str, rows: Sequence[int], found: Sequence[object], expected: str) -> None:
        """Note a fault in some rows of a column: the first of them, and how many there are."""
        if len(rows):
            more = f" (and {len(rows) - 1} more rows)" if len(rows) > 1 else ""
            self.fault(f"row {rows[0] + 1}, column {column!r}: expected {expected}, found {found[0]}{more}")

    def numbers(self, column: str) -> Array:
        """A column of numbers, (rows,); what is none is a fault."""
        series = self.frame[column]
        if series.dtype == pl.String:
            text = series.str.strip_chars()
            if self.decimal != ".":
                text = text.str.replace(self.decimal, ".", literal=True)
            parsed = text.cast(pl.Float64, strict=False)
        else:
            parsed = series.cast(pl.Float64, strict=False)
        values = parsed.fill_null(float("nan")).to_numpy().copy()
        bad = np.flatnonzero(~np.isfinite(values))
        if len(bad):
            first = series[int(bad[0])]
            expected = "a number"
            if isinstance(first, str) and self.decimal == "." and re.fullmatch(r"\s*-?\d+,\d+\s*", first):
                expected = (
                    'a number with a decimal point (for a decimal comma describe the file by a TOML with decimal = ",")'
                )
            self.rows_fault(column, bad.tolist(), ["an empty cell" if first in (None, "") else repr(first)], expected)
        return values

    def names(self, column: str) -> list[str | None]:
        """A column of names; an empty cell is None."""
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


def read_table(path: Path, delimiter: str = ",", decimal: str = ".", skip: int = 0) -> Table:
    """A CSV or Parquet file as a table.

    Raises:
        InputError: it is missing, empty, or its rows have different numbers of fields.
    """
    require_file(path)
    if path.suffix.lower() in (".parquet", ".pq"):
        try:
            return Table(path, pl.read_parquet(path))
        except (pl.exceptions.PolarsError, OSError) as error:
            raise InputError(f"{path}: not a Parquet file: {str(error).splitlines()[0]}") from None
    try:
        frame = pl.read_csv(
            path, separator=delimiter, infer_schema=False, skip_rows=skip, encoding="utf8", truncate_ragged_lines=False
        )
    except (pl.exceptions.PolarsError, OSError) as error:
        raise InputError(*_why_unreadable(path, delimiter, skip, str(error))) from None
    frame = frame.rename({name: name.strip() for name in frame.columns})
    if not frame.height:
        raise InputError(f"{path}: expected at least one row of measurements, found none")
    return Table(path, frame, decimal)


def _why_unreadable(path: Path, delimiter: str, skip: int, error: str) -> Iterator[str]:
    """What is wrong with a text file that cannot be read as a table."""
    lines = read_text(path).splitlines()[skip:]
    if not any(line.strip() for line in lines):
        yield f"{path}: expected a header and rows, found an empty file"
        return
    rows = list(csv.reader(lines, delimiter=delimiter))
    width = len(rows[0])
    uneven = [(i, len(row)) for i, row in enumerate(rows[1:], start=1) if row and len(row) != width]
    if uneven:
        row, found = uneven[0]
        hint = "; a decimal comma? describe the file by a TOML with delimiter and decimal" if found > width else ""
        yield f"{path}: row {row}: expected {width} fields as in the header, found {found}{hint}"
    else:
        yield f"{path}: cannot be read as a table: {error.splitlines()[0]}"
