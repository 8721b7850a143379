"""Printed Denavit-Hartenberg tables: read as they stand, turned into SI values by parameter name."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from math import pi
from pathlib import Path

from elastocal.chain import Vector
from elastocal.robot import Frame, Payload, Robot, Row

HERE = Path(__file__).parent

UNITS = {"rad": 1.0, "m": 1.0, "deg": pi / 180.0}
"""Units of the headers, in SI."""


@dataclass(frozen=True)
class Cell:
    """One printed entry.

    Attributes:
        text: as printed, "0(x)".
        value: SI; 0 where only a mark is printed.
        mark: "x" (not selected), "X" (dependent) or "".
        unit: of the print, a key of UNITS.
    """

    text: str
    value: float
    mark: str
    unit: str


Cells = Mapping[str, Cell]
"""A table's entries by parameter name: "2.alpha"."""


def read_tables(file: str) -> dict[str, Cells]:
    """The tables of one of this package's files by name; a file without names has one table, ""."""
    lines = (HERE / file).read_text(encoding="utf-8").splitlines()
    tables: dict[str, dict[str, Cell]] = {}
    for entry in csv.DictReader(line for line in lines if not line.startswith("#")):
        table = tables.setdefault(entry.pop("table", ""), {})
        row = entry.pop("row")
        for header, text in entry.items():
            key, _, unit = header.rstrip("]").partition(" [")
            table[f"{row}.{key}"] = _cell(text, unit)
    return dict(tables)


def _cell(text: str, unit: str) -> Cell:
    mark = next((mark for mark in "xX" if mark in text), "")
    number = text.strip("()xX")
    return Cell(text, float(number or 0.0) * UNITS[unit], mark, unit)


@dataclass(frozen=True)
class Link:
    """What hangs on a row: mass [kg], its centre [m] in the frame after the row, and the joint's limits [deg]."""

    mass: float = 0.0
    com: Vector = (0.0, 0.0, 0.0)
    limits: tuple[float, float] | None = None


def table_robot(name: str, values: Mapping[str, float], links: Mapping[str, Link], payload: Payload) -> Robot:
    """The robot of a table whose rows are those of six joints and of the tool.

    Base and tool stay where the table puts them, so that its parameters are the only ones.

    Args:
        name: of the robot.
        values: SI, by parameter name, row after row.
        links: by row name; what is not there has no mass.
        payload: in the frame after the last row.
    """
    names = list(dict.fromkeys(parameter.partition(".")[0] for parameter in values))
    rows = []
    for row in names:
        link = links.get(row, Link())
        rows.append(
            Row(
                name=row,
                joint="revolute" if row != names[-1] else None,
                geometry={key: values[f"{row}.{key}"] for key in ("alpha", "a", "beta", "b", "theta", "d")},
                limits=None if link.limits is None else (link.limits[0] * pi / 180.0, link.limits[1] * pi / 180.0),
                mass=link.mass,
                com=link.com,
            )
        )
    fixed = Frame(known=True)
    return Robot(name, "modified-dh", tuple(rows), base=fixed, tool=fixed, tool_load=payload)


def si_values(cells: Cells) -> dict[str, float]:
    """A table's values by parameter name."""
    return {name: cell.value for name, cell in cells.items()}


def differing(one: Cells, other: Cells) -> tuple[str, ...]:
    """Names of the parameters in which two tables differ."""
    return tuple(name for name, cell in one.items() if cell.value != other[name].value)


def unmarked(cells: Cells) -> tuple[str, ...]:
    """Names of the parameters without a mark."""
    return tuple(name for name, cell in cells.items() if not cell.mark)
