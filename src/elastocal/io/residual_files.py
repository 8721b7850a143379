"""residuals.csv: every row's residuals of a calibration, out and in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from elastocal.chain import Array
from elastocal.errors import InputError
from elastocal.identification import Residuals, RowErrors
from elastocal.measurements import Labels, Measurements

WRENCH = tuple(f"wrench_{axis}" for axis in ("fx", "fy", "fz", "mx", "my", "mz"))

NAMED = ("file", "station", "target", "load")


def residual_columns(found: Residuals, prefix: str) -> dict[str, Any]:
    """Residuals as columns of a table: of positions, distances and orientations, what of them there is."""
    columns: dict[str, Any] = {}
    if found.position is not None:
        columns |= {f"{prefix}d{axis} [mm]": 1e3 * d for axis, d in zip("xyz", found.position.T, strict=True)}
    columns[f"{prefix}error [mm]"] = 1e3 * found.norms
    if found.distance is not None:
        columns[f"{prefix}ddistance [mm]"] = 1e3 * found.distance
    if found.orientation is not None and found.angles is not None:
        columns[f"{prefix}angle [mrad]"] = 1e3 * found.angles
        turns = zip("xyz", found.orientation.T, strict=True)
        columns |= {f"{prefix}dr{axis} [mrad]": 1e3 * values for axis, values in turns}
    return columns


def read_residuals(content: bytes, joints: int, place: str) -> RowErrors:
    """The rows that a calibration wrote.

    Args:
        content: of residuals.csv, of this version or an earlier one.
        joints: joint positions that the controller reports.
        place: the file's name, for messages.

    Raises:
        InputError: it is no such table.
    """
    try:
        table = pl.read_csv(BytesIO(content), infer_schema=False)
        return _rows(table, joints)
    except (pl.exceptions.PolarsError, ValueError) as error:
        reason = str(error).splitlines()[0] if str(error) else "it is empty"
        raise InputError(f"{place}: not the residuals that a calibration wrote: {reason}") from None


def load_residuals(path: Path, joints: int) -> RowErrors | None:
    """The same of a file; None where there is none.

    Raises:
        InputError: it cannot be read, or is no such table.
    """
    if not path.is_file():
        return None
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {(error.strerror or str(error)).lower()}") from None
    return read_residuals(content, joints, str(path))


def _rows(table: pl.DataFrame, joints: int) -> RowErrors:
    q = _numbers(table, [f"q{i + 1}" for i in range(joints)])
    if q is None or not {"row", "set"} <= set(table.columns):
        missing = [name for name in ("row", "set", *(f"q{i + 1}" for i in range(joints))) if name not in table.columns]
        raise ValueError(f"columns {', '.join(missing)} are missing")
    named = {name: Labels.of(table[name].to_list()) for name in NAMED if name in table.columns}
    data = Measurements(
        q,
        target=named.get("target"),
        load=named.get("load"),
        station=named.get("station"),
        wrench=_numbers(table, WRENCH),
        source=named.get("file"),
        row=table["row"].cast(pl.Int64).to_numpy(),
    )
    held_out = (table["set"] == "held_out").to_numpy()
    return RowErrors(data, held_out, _residuals(table, "nominal_"), _residuals(table, "calibrated_"))


def _residuals(table: pl.DataFrame, prefix: str) -> Residuals:
    position = _numbers(table, [f"{prefix}d{axis} [mm]" for axis in "xyz"], 1e-3)
    orientation = _numbers(table, [f"{prefix}dr{axis} [mrad]" for axis in "xyz"], 1e-3)
    distance = _numbers(table, [f"{prefix}ddistance [mm]"], 1e-3)
    if position is None and distance is None:  # an earlier version wrote its size alone
        distance = _numbers(table, [f"{prefix}error [mm]"], 1e-3)
    if position is None and distance is None and orientation is None:
        raise ValueError(f"column {prefix}error [mm] is missing")
    return Residuals(len(table), position, orientation, None if distance is None else distance[:, 0])


def _numbers(table: pl.DataFrame, names: Sequence[str], scale: float = 1.0) -> Array | None:
    """Columns as (rows, columns), NaN where they are empty; None if one is not there."""
    if not set(names) <= set(table.columns):
        return None
    columns = [table[name].cast(pl.Float64).fill_null(np.nan).to_numpy() for name in names]
    return scale * np.stack(columns, axis=1)


def wrench_columns(data: Measurements) -> Mapping[str, Array]:
    """The wrenches of rows by column [N, N m]; nothing if there are none."""
    return {} if data.wrench is None else dict(zip(WRENCH, data.wrench.T, strict=True))
