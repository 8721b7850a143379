"""Compensations out: tables written block by block, and what they come to as JSON."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from typing import Any, BinaryIO, Protocol

import numpy as np
import polars as pl

from elastocal.chain import Array
from elastocal.compensation import Rows, Spread, Summary, verdict
from elastocal.errors import InputError
from elastocal.io.files import require_writable
from elastocal.io.results import dump

MOST_ROWS = 1000
"""Up to so many rows are part of the JSON object."""

PICOMETRES = 9
"""Decimals of lengths in mm and angles in mrad: beyond is rounding."""


class RowWriter(Protocol):
    """Where blocks of rows go."""

    def write(self, rows: Rows) -> None:
        """Add a block."""


def compensation_columns(rows: Rows) -> dict[str, Any]:
    """A block of rows as columns; angles only where orientations matter."""
    from scipy.spatial.transform import Rotation

    columns: dict[str, Any] = {f"q{i}": values for i, values in enumerate(rows.q.T, start=1)}
    columns["reached"] = rows.reached
    columns["correction [mm]"] = _shown(rows.correction)
    columns["correction_angle [mrad]"] = _shown(rows.correction_angle)
    for name in ("error_before", "error_after"):
        columns[f"{name} [mm]"] = _shown(getattr(rows, name))
    for name in ("angle_before", "angle_after"):
        columns[f"{name} [mrad]"] = _shown(getattr(rows, name))
    columns |= {f"fake_{axis} [mm]": 1e3 * at for axis, at in zip("xyz", rows.fake_position.T, strict=True)}
    quaternions = Rotation.from_matrix(rows.fake_rotation).as_quat(canonical=True)
    columns |= {f"fake_{name}": quaternions[:, i] for name, i in (("qw", 3), ("qx", 0), ("qy", 1), ("qz", 2))}
    columns["note"] = list(rows.notes)
    return columns


def _shown(values: Array) -> Array:
    return np.round(1e3 * values, PICOMETRES)


def _frame(rows: Rows) -> pl.DataFrame:
    frame = pl.DataFrame(compensation_columns(rows), schema_overrides={"note": pl.String})
    return frame.fill_nan(None).with_columns(pl.col("note").replace("", None))


class CsvWriter:
    """Rows as CSV."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file
        self._header = True

    def write(self, rows: Rows) -> None:
        """Add a block."""
        self._file.write(_frame(rows).write_csv(None, include_header=self._header).encode())
        self._header = False


class ParquetWriter:
    """Rows as Parquet: a file for each block, put together at the end."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._waiting: list[pl.DataFrame] = []
        self._parts: list[Path] = []

    def write(self, rows: Rows) -> None:
        """Add a block."""
        self._waiting.append(_frame(rows))
        if len(self._waiting) == BLOCKS_A_PART:
            self._write_part()

    def finish(self, path: Path) -> None:
        """Put everything into one file."""
        if self._waiting or not self._parts:
            self._write_part()
        pl.scan_parquet(self._parts).sink_parquet(path, maintain_order=True)

    def _write_part(self) -> None:
        self._parts.append(self._folder / f"{len(self._parts):06d}.parquet")
        pl.concat(self._waiting).write_parquet(self._parts[-1])
        self._waiting = []


BLOCKS_A_PART = 50


@contextmanager
def compensation_file(path: Path, inputs: Iterable[Path] = ()) -> Iterator[RowWriter]:
    """A file for rows, CSV or Parquet by its suffix; it takes its place at the end, or not at all.

    Args:
        path: of the file.
        inputs: files that must not be overwritten.

    Raises:
        InputError: it would overwrite an input, its suffix is of another kind, or it cannot be written.
    """
    require_compensation_file(path, inputs)
    made = [folder for folder in (path.parent, *path.parent.parents) if not folder.exists()]
    path.parent.mkdir(parents=True, exist_ok=True)
    folder = Path(tempfile.mkdtemp(dir=path.parent, prefix=f".{path.name}."))
    done = False
    try:
        there = folder / "whole"
        if path.suffix.lower() in PARQUET:
            parquet = ParquetWriter(folder)
            yield parquet
            parquet.finish(there)
        else:
            with there.open("wb") as file:
                yield CsvWriter(file)
        there.replace(path)
        done = True
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {(error.strerror or str(error)).lower()}") from None
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        if not done:
            for empty in made:
                empty.rmdir()


PARQUET = (".parquet", ".pq")
TEXT = (".csv", ".txt", "")


def require_compensation_file(path: Path, inputs: Iterable[Path] = ()) -> None:
    """Check that rows can be written to a file, before the work.

    Raises:
        InputError: they cannot.
    """
    if path.suffix.lower() not in (*PARQUET, *TEXT):
        raise InputError(f"-o {path}: expected a CSV (.csv) or Parquet (.parquet) file, found {path.suffix}")
    require_writable(path.parent, [path.name], inputs)


def compensation_json(summary: Summary, rows: Rows | None) -> str:
    """What a compensation comes to as JSON, SI units; rows only if there are at most MOST_ROWS."""
    return dump(
        {
            "format": "elastocal-compensation/1",
            "robot": summary.robot,
            "verdict": verdict(summary),
            "targets": summary.targets,
            "reached": summary.reached,
            **{name: _spread(spread) for name, spread in summary.figures.items()},
            "missed": [{"target": number, "note": note} for number, note in summary.missed],
            "noted": summary.noted,
            "rows": None if rows is None else _rows(rows),
            "warnings": list(summary.warnings),
            "version": version("elastocal"),
        }
    )


def _spread(spread: Spread) -> dict[str, float] | None:
    return {"mean": spread.mean, "max": spread.max} if spread.n else None


def _rows(rows: Rows) -> list[dict[str, Any]]:
    figures = ("correction", "correction_angle", "error_before", "error_after", "angle_before", "angle_after")
    return [
        {
            "q": rows.q[i].tolist(),
            "reached": bool(rows.reached[i]),
            **{name: float(getattr(rows, name)[i]) for name in figures},
            "fake_position": rows.fake_position[i].tolist(),
            "fake_rotation": rows.fake_rotation[i].tolist(),
            "note": rows.notes[i],
        }
        for i in range(len(rows))
    ]
