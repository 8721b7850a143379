"""A study's folder: what study it is, and its results as a Parquet data set of parts, each written whole."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import polars as pl

from elastocal.errors import InputError
from elastocal.io.files import require_writable, write_files
from elastocal.io.results import dump
from elastocal.io.study_values import Setting, Study, cell_key

FORMAT = "elastocal-study-results/1"
RECORD = "study.json"
PARTS = "parts"
SUMMARIES = (RECORD, "summary.parquet", "summary.html")

_PART = re.compile(r"(?P<cell>[0-9a-f]{12})-(?P<repeats>\d+(?:\.\d+)*)\.parquet")

TYPES = {bool: pl.Boolean, int: pl.Int64, float: pl.Float64, str: pl.String}

SCHEMA: dict[str, Any] = {
    "cell": pl.String,
    "repeat": pl.Int64,
    **{name: TYPES[type(value)] for name, value in vars(Setting()).items()},
    "status": pl.String,
    "reason": pl.String,
    **dict.fromkeys(("nominal_mean", "nominal_max", "held_out_mean", "held_out_max", "held_out_rms"), pl.Float64),
    "fitted_mean": pl.Float64,
    "parameters": pl.Int64,
    "condition": pl.Float64,
    "chi2_reduced": pl.Float64,
    "iterations": pl.Int64,
    "seconds": pl.Float64,
    "name": pl.List(pl.String),
    "identified": pl.List(pl.Float64),
    "std": pl.List(pl.Float64),
    "interval_name": pl.List(pl.String),
    "covered": pl.List(pl.Boolean),
    "position_square": pl.Float64,
    "position_variance": pl.Float64,
    "chi2_true": pl.Float64,
    "recommended": pl.String,
    "right": pl.Boolean,
    "compared": pl.List(pl.String),
    "compared_parameters": pl.List(pl.Int64),
    "compared_coordinates": pl.List(pl.Int64),
    "deviance": pl.List(pl.Float64),
    "criterion": pl.List(pl.Float64),
    "torque": pl.List(pl.Float64),
    "torque_error": pl.List(pl.Float64),
    "torque_score": pl.List(pl.Float64),
    "same_sides": pl.Boolean,
    "search_seconds": pl.Float64,
    "outliers_wrong": pl.Int64,
    "outliers_named": pl.Int64,
    "outliers_accused": pl.Int64,
}
"""Columns of the results, SI; what a study does not tell is null."""


def require_study_folder(folder: Path, study: Study) -> None:
    """Check that a study's results can be written into a folder, before the work.

    Raises:
        InputError: it holds results of another study, or cannot be written to.
    """
    require_writable(folder, SUMMARIES)
    record = folder / RECORD
    if not record.exists():
        return
    try:
        found = json.loads(record.read_text(encoding="utf-8"))["study"]
    except (OSError, ValueError, KeyError, TypeError):
        raise InputError(f"{record}: is no record of a study: choose another folder (-o DIR)") from None
    other = [key for key, value in study.identity.items() if found.get(key) != value]
    if other:
        raise InputError(
            f"{folder} holds the results of another study ({', '.join(other)} differ"
            f"{'s' if len(other) == 1 else ''}): choose another folder (-o DIR); a study goes on only with more "
            "repeats or another grid"
        )


def write_record(folder: Path, study: Study) -> None:
    """Say which study a folder holds."""
    write_files(folder, {RECORD: dump({"format": FORMAT, "name": study.name, "study": study.identity}) + "\n"})


def repeats_done(folder: Path) -> dict[str, set[int]]:
    """The repeats that are there, by point of the grid; a part is there whole or not at all."""
    found: dict[str, set[int]] = {}
    for path in (folder / PARTS).glob("*.parquet"):
        named = _PART.fullmatch(path.name)
        if named:
            found.setdefault(named["cell"], set()).update(map(int, named["repeats"].split(".")))
    return found


def write_part(folder: Path, setting: Setting, rows: Sequence[Mapping[str, Any]]) -> None:
    """Add the rows of some repeats of one point of the grid.

    Raises:
        InputError: they cannot be written.
    """
    buffer = BytesIO()
    pl.DataFrame([dict.fromkeys(SCHEMA) | dict(row) for row in rows], schema=SCHEMA).write_parquet(buffer)
    name = f"{cell_key(setting)}-{'.'.join(str(row['repeat']) for row in rows)}.parquet"
    write_files(folder / PARTS, {name: buffer.getvalue()})


def read_rows(folder: Path, settings: Iterable[Setting], repeats: int) -> Iterator[list[dict[str, Any]]]:
    """The rows of each setting in the order of the repeats, those beyond `repeats` left out."""
    parts = sorted((folder / PARTS).glob("*.parquet"))
    for setting in settings:
        key = cell_key(setting)
        own = [path for path in parts if path.name.startswith(key)]
        if own:
            table = pl.scan_parquet(own).filter(pl.col("repeat") < repeats).sort("repeat").collect()
            yield table.to_dicts()
        else:
            yield []
