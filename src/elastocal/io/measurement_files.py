"""Measurement files of any kind into measurements, checked against the robot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from elastocal.errors import unknown_name
from elastocal.io.descriptor import described_file, read_described
from elastocal.io.files import require_file, sha256, write_files
from elastocal.io.tables import Table, read_table
from elastocal.io.tidy import measurements_to_csv, read_tidy, sliding
from elastocal.measurements import SAME_POSE, Labels, Measurements, concatenate
from elastocal.robot import Robot

DEGREES = 4.0 * np.pi
"""A joint angle [rad] larger than this where no limits are known is one in degrees."""


def load_measurements(paths: str | Path | Sequence[str | Path], robot: Robot) -> Measurements:
    """Read measurements of a robot: CSV, Parquet, or the TOML descriptor of an instrument's own file.

    Args:
        paths: one file, or several that are read one after the other.
        robot: whose joints, targets, payloads and stations they name.

    Raises:
        InputError: with every fault of a file: its place, what was expected and what was found.
    """
    if isinstance(paths, (str, Path)):
        paths = [paths]
    return concatenate([_load(Path(path), robot) for path in paths])


def data_hashes(paths: Sequence[str | Path]) -> list[str]:
    """SHA-256 of each measurement file's rows: of a descriptor, those of the file that it describes."""
    return [sha256(described_file(path) if path.suffix.lower() == ".toml" else path) for path in map(Path, paths)]


def _load(path: Path, robot: Robot) -> Measurements:
    require_file(path)
    if path.suffix.lower() == ".toml":
        table, data = read_described(path, robot)
    else:
        table = read_table(path)
        data = read_tidy(table, robot)
    table.raise_faults()
    data = _with_default_target(robot, data, table)
    _check_names(robot, data, table)
    _check_joints(robot, data, table)
    _check_values(data, table)
    _check_duplicates(data, table)
    table.raise_faults()
    n = len(data)
    return replace(data, source=Labels((path.name,), np.zeros(n, dtype=np.int32)), row=np.arange(1, n + 1))


def _with_default_target(robot: Robot, data: Measurements, table: Table) -> Measurements:
    """A robot with one target measures that one; with several, each row must say which."""
    if not robot.targets:
        return data
    names = Labels.none(len(data)) if data.target is None else data.target
    missing = np.flatnonzero(names.codes < 0)
    if len(robot.targets) > 1:
        if data.target is None:
            table.fault(f"expected a column 'target' with one of {', '.join(robot.targets)}, found none")
        else:
            table.rows_fault("target", missing.tolist(), ["an empty cell"], f"one of {', '.join(robot.targets)}")
        return data
    only = next(iter(robot.targets))
    return replace(data, target=Labels.of([names.name(int(code)) or only for code in names.codes]))


def _check_names(robot: Robot, data: Measurements, table: Table) -> None:
    for kind, labels, valid in (
        ("target", data.target, robot.targets),
        ("load", data.load, robot.loads),
        ("station", data.station, robot.stations),
    ):
        if labels is not None:
            for code, name in enumerate(labels.names):
                if name not in valid:
                    row = int(np.flatnonzero(labels.codes == code)[0]) + 1
                    table.fault(f"row {row}: {robot.name} has {unknown_name(kind, name, valid)}")


def _check_joints(robot: Robot, data: Measurements, table: Table) -> None:
    """Joint positions out of limits, or in degrees."""
    square = robot.coupling is None or len(robot.joints) == robot.positions
    limits = [row.limits for row in robot.joints] if square else [None] * robot.positions
    for column, (slides, bounds) in enumerate(zip(sliding(robot), limits, strict=True)):
        q, name = data.q[:, column], f"q{column + 1}"
        widest = DEGREES if bounds is None else max(DEGREES, *map(abs, bounds))
        turned = np.flatnonzero(np.abs(q) > widest)
        if not slides and len(turned):
            found = [f"{q[turned[0]]:g} rad, {abs(q[turned[0]]) / 2.0 / np.pi:.0f} turns"]
            table.rows_fault(name, turned.tolist(), found, f"radians (for degrees write the unit: '{name} [deg]')")
        elif bounds is not None:
            low, high = bounds
            out = np.flatnonzero((q < low - SAME_POSE) | (q > high + SAME_POSE))
            unit, scale = ("mm", 1e3) if slides else ("deg", 180.0 / np.pi)
            expected = f"joint {column + 1} within its limits {low * scale:g} … {high * scale:g} {unit}"
            table.rows_fault(name, out.tolist(), [f"{q[row] * scale:g} {unit}" for row in out[:1]], expected)


def _check_values(data: Measurements, table: Table) -> None:
    for name, values in (("sigma", data.sigma), ("sigma_angle", data.sigma_angle), ("distance", data.distance)):
        if values is not None:
            bad = np.flatnonzero((values.reshape(len(data), -1) <= 0.0).any(axis=1))
            found = [f"{np.min(values[row]):g}" for row in bad[:1]]
            table.rows_fault(name, bad.tolist(), found, "a positive number")


def _check_duplicates(data: Measurements, table: Table) -> None:
    """Rows that agree to the last digit are copies, not repeats."""
    columns = [data.q, data.position, data.orientation, data.distance, data.wrench]
    columns += [labels.codes.astype(float) for labels in (data.target, data.load, data.station) if labels is not None]
    stacked = np.concatenate([c.reshape(len(data), -1) for c in columns if c is not None], axis=1)
    order = np.lexsort(stacked.T)
    same = (stacked[order[1:]] == stacked[order[:-1]]).all(axis=1)
    pairs = sorted((max(a, b) + 1, min(a, b) + 1) for a, b in zip(order[1:][same], order[:-1][same], strict=True))
    if pairs:
        again, first = pairs[0]
        more = f" (and {len(pairs) - 1} more copies)" if len(pairs) > 1 else ""
        table.fault(f"row {again} is a copy of row {first}, to the last digit{more}: leave one out")


def save_measurements(data: Measurements, robot: Robot, path: str | Path) -> None:
    """Write measurements as a tidy CSV table, in degrees and millimetres.

    Raises:
        InputError: the file cannot be written.
    """
    path = Path(path)
    write_files(path.parent, {path.name: measurements_to_csv(data, robot)})
