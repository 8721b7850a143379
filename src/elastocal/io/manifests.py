"""Manifests of fleets: a table of calibrations, CSV or TOML, checked as a whole before the first one runs."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import date, datetime
from pathlib import Path
from typing import Any

from elastocal.errors import InputError, unknown_name
from elastocal.identification.words import laws_of, orders_of, transition_of
from elastocal.io.cells import count, flag, fraction, loss, patterns
from elastocal.io.descriptor import described_file
from elastocal.io.files import read_text, read_toml, require_file

FORMAT = "elastocal-fleet/1"

NOT_IN_NAMES = '/\\:*?"<>|'
"""Characters that a folder's name cannot have everywhere."""


@dataclass(frozen=True)
class FleetRow:
    """One calibration of a fleet.

    Attributes:
        number: in the manifest, from 1.
        serial: of the robot.
        date: of the measurements, ISO 8601.
        robot: its file, with `tip` where a URDF ends.
        data: measurements, and those held out.
        options: of `calibrate`, by name.
        words: the same as the manifest has them.
    """

    number: int
    serial: str
    date: str
    robot: Path
    data: tuple[Path, ...]
    held_out: tuple[Path, ...]
    tip: str | None
    options: Mapping[str, Any]
    words: Mapping[str, str]

    @property
    def folder(self) -> Path:
        """Where its result goes, below that of the fleet."""
        return Path(self.serial) / self.date.replace(":", "")

    @property
    def inputs(self) -> tuple[Path, ...]:
        """All files that it reads, those that descriptors describe among them."""
        described = []
        for path in (*self.data, *self.held_out):
            if path.suffix.lower() == ".toml":
                with suppress(InputError, KeyError):  # a fault of the row itself: it fails, the others run
                    described.append(described_file(path))
        return (self.robot, *self.data, *self.held_out, *described)


OPTIONS: dict[str, Callable[[str, str], Any]] = {
    "holdout": fraction,
    "identify": patterns,
    "fix": patterns,
    "elastic": lambda option, text: laws_of(option, text.replace(";", ",")),
    "transition": lambda option, text: transition_of(option, text.replace(";", ",")),
    "non_negative": flag,
    "loss": loss,
    "transmission": orders_of,
    "prior": flag,
    "bootstrap": count,
    "seed": count,
}
"""Options of `calibrate` that a manifest may have, and how each is read."""

FILES = ("robot", "data", "held_out")
REQUIRED = ("serial", "date", "robot", "data")
COLUMNS = (*REQUIRED, "held_out", "tip", *OPTIONS)


def read_manifest(path: str | Path) -> tuple[FleetRow, ...]:
    """The rows of a manifest; files are relative to it.

    Raises:
        InputError: with every fault of the whole table: unknown columns and options, files that are not there, a serial
            number and date that occur twice.
    """
    path = Path(path)
    require_file(path)
    if path.suffix.lower() not in (".csv", ".toml"):
        raise InputError(f"{path}: expected a manifest (.csv or .toml), found {path.suffix or 'no suffix'}")
    faults: list[str] = []
    table = _toml_rows(path, faults) if path.suffix.lower() == ".toml" else _csv_rows(path, faults)
    if not table and not faults:
        faults.append("expected one calibration or more, found none")
    rows = []
    for number, cells in enumerate(table, start=1):
        found = _row(number, cells, path.parent)
        if isinstance(found, FleetRow):
            rows.append(found)
        else:
            faults += found
    faults += _repeated(table)
    if faults:
        raise InputError(*(f"{path}: {fault}" for fault in dict.fromkeys(faults)))
    return tuple(rows)


def _csv_rows(path: Path, faults: list[str]) -> list[dict[str, str]]:
    """Cells by column; those left empty are left out."""
    text = read_text(path)
    first = text.partition("\n")[0]
    lines = csv.reader(io.StringIO(text), delimiter=";" if first.count(";") > first.count(",") else ",")
    header = [name.strip() for name in next(lines, [])]
    faults += [unknown_name("column", name, COLUMNS) for name in header if name not in COLUMNS]
    faults += [f"column {name!r} is there twice" for name in dict.fromkeys(header) if header.count(name) > 1]
    faults += [f"expected a column {name!r}, found none" for name in REQUIRED if name not in header]
    rows: list[dict[str, str]] = []
    if faults:
        return rows
    for number, cells in enumerate((line for line in lines if any(cell.strip() for cell in line)), start=1):
        if len(cells) > len(header):
            faults.append(
                f"row {number}: expected {len(header)} cells, as in the header, found {len(cells)}: put a cell with "
                "commas in quotes, or use ; in it"
            )
        rows.append({name: cell.strip() for name, cell in zip(header, cells, strict=False) if cell.strip()})
    return rows


def _toml_rows(path: Path, faults: list[str]) -> list[dict[str, str]]:
    """Cells by key, as text; [defaults] hold for all rows."""
    values = read_toml(path)
    if values.get("format") != FORMAT:
        faults.append(f"format: expected {FORMAT!r}, found {values.get('format')!r}")
    known = ("format", "defaults", "calibration")
    faults += [unknown_name("key", key, known) for key in values if key not in known]
    defaults, tables = values.get("defaults", {}), values.get("calibration", [])
    if not isinstance(defaults, dict) or not isinstance(tables, list) or not all(isinstance(t, dict) for t in tables):
        faults.append("expected one or more tables [[calibration]], and at most one [defaults]")
        return []
    rows = []
    for number, table in enumerate([defaults, *tables]):
        place = f"row {number}" if number else "defaults"
        faults += [f"{place}: {unknown_name('key', key, COLUMNS)}" for key in table if key not in COLUMNS]
        cells = {}
        for key, value in table.items():
            text = _text(value)
            if text is None:
                faults.append(f"{place}, {key}: expected text, a number, true or false, or a list of texts")
            else:
                cells[key] = text
        rows.append(cells)
    return [{**rows[0], **cells} for cells in rows[1:]]


def _text(value: object) -> str | None:
    """A TOML value as a cell."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (str, int, float)):
        return str(value)
    if isinstance(value, (date, datetime)):
        return value.isoformat()
    if isinstance(value, list) and all(isinstance(item, (str, int, float)) for item in value):
        return ";".join(map(str, value))
    return None


def _row(number: int, cells: Mapping[str, str], folder: Path) -> FleetRow | list[str]:
    """A row, or its faults."""
    faults = [f"{name!r} is missing" for name in REQUIRED if name not in cells]
    options: dict[str, Any] = {}
    for name, read in OPTIONS.items():
        if name in cells:
            try:
                options[name] = read(name, cells[name])
            except InputError as error:
                faults += error.faults
    if "held_out" in cells and "holdout" in cells:
        faults.append("held-out rows are given and asked for (held_out and holdout): give one of the two")
    files = {name: [part.strip() for part in cells.get(name, "").split(";") if part.strip()] for name in FILES}
    paths = {name: tuple(folder / part for part in parts) for name, parts in files.items()}
    if len(paths["robot"]) > 1:
        faults.append(f"robot: expected one file, found {len(paths['robot'])}")
    for name, listed in paths.items():
        faults += [f"{name}: {fault}" for path in listed for fault in _file_faults(path)]
    both = set(paths["data"]) & set(paths["held_out"])
    faults += [f"{path} is both fitted and held out: choose one" for path in sorted(both)]
    serial, when = cells.get("serial", ""), cells.get("date", "")
    faults += _name_faults(serial) if serial else []
    try:
        when = _iso(when) if when else ""
    except ValueError:
        faults.append(f"date: expected a date as 2026-03-31 (or 2026-03-31T14:30), found {when!r}")
    if faults:
        place = f"row {number}" + (f" ({serial})" if serial else "")
        return [f"{place}: {fault}" for fault in faults]
    words = {name: cells[name] for name in OPTIONS if name in cells}
    robot, tip = paths["robot"][0], cells.get("tip")
    return FleetRow(number, serial, when, robot, paths["data"], paths["held_out"], tip, options, words)


def _iso(text: str) -> str:
    """A date, or a date and time to the minute."""
    if len(text) == len("2026-03-31"):
        return date.fromisoformat(text).isoformat()
    return datetime.fromisoformat(text).replace(tzinfo=None).isoformat(timespec="minutes")


def _name_faults(serial: str) -> Iterator[str]:
    bad = [character for character in serial if character in NOT_IN_NAMES or not character.isprintable()]
    if bad or serial.startswith(".") or serial.endswith("."):
        yield f"serial: its folder gets this name: expected one without {' '.join(NOT_IN_NAMES)} and outer dots"


def _file_faults(path: Path) -> Iterator[str]:
    """Why a file, or the one that it describes, cannot be read."""
    try:
        require_file(path)
        if path.suffix.lower() == ".toml":
            described: Path | None = None
            with suppress(InputError, KeyError):  # what is wrong in it is a fault of the row alone
                described = described_file(path)
            if described is not None:
                require_file(described)
    except InputError as error:
        yield from error.faults


def _repeated(table: Sequence[Mapping[str, str]]) -> Iterator[str]:
    first: dict[tuple[str, str], int] = {}
    for number, cells in enumerate(table, start=1):
        serial, when = cells.get("serial", ""), cells.get("date", "")
        with suppress(ValueError):
            when = _iso(when)
        if serial and when and (serial, when) in first:
            yield f"row {number}: serial {serial} and date {when} are in row {first[serial, when]} already"
        first.setdefault((serial, when), number)
