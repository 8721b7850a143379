"""Measurement files of any kind into measurements, checked against the robot."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.errors import InputError, unknown_name
from elastocal.io.descriptor import described_file, read_described
from elastocal.io.files import require_file, sha256, write_files
from elastocal.io.parquet_files import is_parquet, write_parquet
from elastocal.io.tables import Table, more, read_table
from elastocal.io.tidy import measurements_to_csv, read_tidy, sliding
from elastocal.io.units import UNITS, factor
from elastocal.measurements import SAME_POSE, Labels, Measurements, concatenate
from elastocal.robot import Robot

DEGREES = 4.0 * np.pi
"""A joint angle [rad] larger than this where no limits are known is one in degrees."""

FAR = 200.0
"""A target [m] further from the instrument is one in millimetres."""


def load_measurements(paths: str | Path | Sequence[str | Path], robot: Robot, *, measured: bool = True) -> Measurements:
    """Read measurements of a robot: CSV, Parquet, or the TOML descriptor of an instrument's own file.

    Args:
        paths: one file, or several that are read one after the other.
        robot: whose joints, targets, payloads and stations they name.
        measured: whether something must have been measured; else a table of joint positions will do.

    Raises:
        InputError: with every fault of a file: its place, what was expected and what was found.
    """
    files = [Path(paths)] if isinstance(paths, (str, Path)) else [Path(path) for path in paths]
    require_different(files)
    named = zip(files, source_names(files), strict=True)
    return concatenate([_load(path, robot, source, measured) for path, source in named])


def source_names(paths: Sequence[Path]) -> list[str]:
    """What files are called: by their names, in full where several have the same."""
    shared = Counter(path.name for path in paths)
    return [path.name if shared[path.name] == 1 else str(path) for path in paths]


def require_different(paths: Sequence[Path]) -> None:
    """Check that no file is given twice: its rows would count twice, or be fitted and held out.

    Raises:
        InputError: one is.
    """
    times = Counter(path.resolve() for path in paths)
    twice = dict.fromkeys(path for path in paths if times[path.resolve()] > 1)
    if twice:
        raise InputError(*(f"{path} is given {times[path.resolve()]} times: leave all but one out" for path in twice))


def source_files(paths: Sequence[str | Path]) -> list[Path]:
    """The files that measurements are read from: those given, and those that descriptors among them describe."""
    return [*map(Path, paths), *(described_file(path) for path in map(Path, paths) if path.suffix.lower() == ".toml")]


def data_hashes(paths: Sequence[str | Path]) -> list[str]:
    """SHA-256 of each measurement file's rows: of a descriptor, those of the file that it describes."""
    return [sha256(described_file(path) if path.suffix.lower() == ".toml" else path) for path in map(Path, paths)]


def _load(path: Path, robot: Robot, source: str, measured: bool) -> Measurements:
    require_file(path)
    if path.suffix.lower() == ".toml":
        table, data = read_described(path, robot)
    else:
        table = read_table(path)
        data = read_tidy(table, robot, measured)
    return placed(checked(data, robot, table), source)


def checked(data: Measurements, robot: Robot, table: Table) -> Measurements:
    """The measurements of a table, each row with its target, if nothing is wrong with them.

    Raises:
        InputError: with every fault of the table.
    """
    if table.sound:
        data = with_default_target(robot, data, table)
        _check_names(robot, data, table)
        check_joints(robot, data, table)
        _check_positive(data, table)
        check_lengths(data, table)
        _check_duplicates(data, table)
    table.raise_faults()
    return data


def placed(data: Measurements, source: str, above: int = 0) -> Measurements:
    """The measurements with where they come from: a file, and so many rows above them in it."""
    n = len(data)
    return replace(data, source=Labels((source,), np.zeros(n, dtype=np.int32)), row=np.arange(above + 1, above + n + 1))


def with_default_target(robot: Robot, data: Measurements, table: Table) -> Measurements:
    """A robot with one target measures that one; with several, each row must say which."""
    if not robot.targets:
        return data
    names = Labels.none(len(data)) if data.target is None else data.target
    missing = np.flatnonzero(names.codes < 0)
    if len(robot.targets) > 1:
        valid = f"one of {', '.join(robot.targets)}"
        if data.target is None:
            table.fault(f"expected a column 'target' with {valid}, found none")
        else:
            table.rows_fault(table.header("target").text, missing.tolist(), "an empty cell", valid)
        return data
    only = next(iter(robot.targets))
    return replace(data, target=Labels.of([names.name(int(code)) or only for code in names.codes]))


def _check_names(robot: Robot, data: Measurements, table: Table) -> None:
    for kind, labels, valid in (
        ("target", data.target, robot.targets),
        ("load", data.load, robot.loads),
        ("station", data.station, robot.stations),
    ):
        for code, name in enumerate(labels.names if labels is not None else ()):
            if labels is not None and name not in valid:
                rows = np.flatnonzero(labels.codes == code)
                place = f"{table.path}: row {table.number(int(rows[0]))}, column {table.header(kind).text!r}"
                unknown = f"{robot.name} has {unknown_name(kind, name, valid)}"
                table.faults.append(f"{place}: {unknown}{more(len(rows) - 1)}")


def check_joints(robot: Robot, data: Measurements, table: Table) -> None:
    """Joint positions out of limits, or in degrees."""
    square = robot.coupling is None or len(robot.joints) == robot.positions
    limits = [row.limits for row in robot.joints] if square else [None] * robot.positions
    for column, (slides, bounds) in enumerate(zip(sliding(robot), limits, strict=True)):
        q, (header, unit) = data.q[:, column], table.header(f"q{column + 1}")
        given = unit or ("m" if slides else "rad")
        scale = factor("length" if slides else "angle", given) or 1.0
        far = np.abs(q) > (FAR if slides else DEGREES)
        out = np.flatnonzero((q < bounds[0] - SAME_POSE) | (q > bounds[1] + SAME_POSE) if bounds else far)
        if not len(out):
            continue
        expected = f"a joint position in {given}"
        if bounds is not None:
            expected = f"joint {column + 1} within its limits {bounds[0] / scale:.6g} … {bounds[1] / scale:.6g} {given}"
        expected += _unit_remedy(table, f"q{column + 1}", given, float(q[out[0]]), bounds)
        table.rows_fault(header, out.tolist(), f"{q[out[0]] / scale:.6g}", expected)


def _unit_remedy(table: Table, name: str, given: str, q: float, bounds: tuple[float, float] | None) -> str:
    """What to write if a joint position out of range is one in degrees or millimetres, taken for rad or m."""
    unit, words = {"rad": ("deg", "degrees"), "m": ("mm", "millimetres")}.get(given, ("", ""))
    meant = q * (UNITS["angle" if given == "rad" else "length"].get(unit) or 0.0)
    likely = unit and (bounds is None or (abs(q) > 2.0 * np.pi and bounds[0] <= meant <= bounds[1]))
    return f" (for {words} write {table.with_unit(name, unit)})" if likely else ""


def _check_positive(data: Measurements, table: Table) -> None:
    for name, values in (("sigma", data.sigma), ("sigma_angle", data.sigma_angle), ("distance", data.distance)):
        if values is not None:
            bad = np.flatnonzero((values.reshape(len(data), -1) <= 0.0).any(axis=1))
            header, unit = table.header(name)
            scale = factor("angle" if name == "sigma_angle" else "length", unit) or 1.0
            found = "".join(f"{np.min(values[row]) / scale:g}" for row in bad[:1])
            table.rows_fault(header, bad.tolist(), found, "a positive number")


def check_lengths(data: Measurements, table: Table) -> None:
    """Positions and distances that are millimetres in a column of metres."""
    observed = [] if data.position is None else list(zip("xyz", data.position.T, strict=True))
    observed += [] if data.distance is None else [("distance", data.distance)]
    for name, values in observed:
        far = np.flatnonzero(np.abs(values) > FAR)
        header, unit = table.header(name)
        remedy = f" (for millimetres write {table.with_unit(name, 'mm')})" if unit in (None, "m") else ""
        found = "".join(f"{values[row]:g} m" for row in far[:1])
        table.rows_fault(header, far.tolist(), found, f"at most {FAR:g} m{remedy}")


def _check_duplicates(data: Measurements, table: Table) -> None:
    """Rows that agree to the last digit are copies, not repeats."""
    columns = [data.q, data.position, data.orientation, data.distance, data.wrench]
    columns += [labels.codes.astype(float) for labels in (data.target, data.load, data.station) if labels is not None]
    stacked = np.concatenate([c.reshape(len(data), -1) for c in columns if c is not None], axis=1)
    measured = stacked[:, min(data.q.shape[1], stacked.shape[1] - 1)]
    likely = _shared(measured)  # noise makes these few, so that few rows need be compared as a whole
    order = likely[np.lexsort(stacked[likely].T)]
    same = (stacked[order[1:]] == stacked[order[:-1]]).all(axis=1)
    pairs = sorted((max(a, b), min(a, b)) for a, b in zip(order[1:][same], order[:-1][same], strict=True))
    if pairs:
        again, first = (table.number(int(row)) for row in pairs[0])
        others = more(len(pairs) - 1, "copied row")
        table.faults.append(
            f"{table.path}: row {again} is a copy of row {first}, to the last digit{others}: leave it out"
        )


def _shared(values: Array) -> NDArray[np.intp]:
    """The rows, ascending, whose value (n,) another row has too."""
    ordered = np.sort(values)
    return np.flatnonzero(np.isin(values, ordered[1:][ordered[1:] == ordered[:-1]]))


def save_measurements(data: Measurements, robot: Robot, path: str | Path) -> None:
    """Write measurements as a tidy table in degrees and millimetres: Parquet if the file is called so, else CSV.

    Raises:
        InputError: the file cannot be written.
    """
    path = Path(path)
    if is_parquet(path):
        write_parquet(path, [data], robot)
        return
    write_files(path.parent, {path.name: measurements_to_csv(data, robot)})
