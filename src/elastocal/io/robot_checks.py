"""What no schema can say of a robot file: names, units, directions, laws."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from elastocal.elasticity import CURVES, HARMONIC_DRIVE
from elastocal.errors import unknown_name
from elastocal.io.checking import Fault, dotted, row_place
from elastocal.io.robot_schema import ElasticEntry, FrameEntry, RobotEntry, RowEntry
from elastocal.io.units import UNITS
from elastocal.robot import DH_KEYS, ROTATION_KEYS, Robot

RESERVED = ("base", "tool", "target", "station")

URDF_KEYS = ("xyz", "rpy", "axis")

LONGEST = 50.0
"""A length [m] beyond this is one in millimetres."""

MOST_TURNS = 4.0
"""A joint that travels further is one whose degrees were taken for radians."""

DECISIVE = ("format", "convention", "length_unit", "angle_unit", "row")
"""Without these nothing else of a file can be judged."""


def sound_part(values: dict[str, Any], faults: Sequence[Fault]) -> dict[str, Any] | None:
    """The file without the tables and rows in which the schema found faults; None where too little is left."""
    places = [fault.place for fault in faults]
    if any(place[0] in DECISIVE and (len(place) == 1 or place[0] != "row") for place in places):
        return None
    rows = list(values["row"])
    part = {**values, "row": rows}
    for place in places:
        if place[0] == "row" and isinstance(place[1], int):
            name = rows[place[1]].get("name") if isinstance(rows[place[1]], dict) else None
            rows[place[1]] = {"name": name if name and isinstance(name, str) else f"row {place[1] + 1}"}
        elif place[0] in ("target", "load", "elastic", "transmission", "station") and len(place) > 1:
            part[str(place[0])] = {name: table for name, table in part[str(place[0])].items() if name != place[1]}
        else:
            part.pop(str(place[0]), None)
    return part


def local_faults(entry: RobotEntry) -> Iterator[str]:
    """Faults that one row or one table shows by itself."""
    yield from _name_faults([row.name for row in entry.row])
    for index, row in enumerate(entry.row):
        where = row_place(index, row.name)
        yield from _key_faults(entry, row, where)
        yield from _joint_faults(row, where)
        yield from _unit_faults(entry, row, where)
    yield from _frame_faults(entry)
    for name, found in entry.elastic.items():
        yield from _law_faults(dotted(("elastic", name)), found)


def joined_faults(entry: RobotEntry, robot: Robot) -> Iterator[str]:
    """Faults that show when all rows are known: no joint, wrong coupling, elements that do not exist."""
    if not robot.joints:
        yield 'no row has a joint: write joint = "revolute" or "prismatic" in those that move'
    elif entry.coupling is not None:
        yield from _coupling_faults(entry.coupling.matrix, len(robot.joints))
    driven = {row.name: row.joint_element for row in robot.joints if row.joint_element}
    for name in entry.elastic:
        if name not in robot.compliant_elements:
            yield f"elastic: {_unknown_element('element', name, robot.compliant_elements, driven)}"
    for name in entry.transmission:
        if name not in driven.values():
            yield f"transmission: {_unknown_element('driven element', name, tuple(driven.values()), driven)}"


def _unknown_element(kind: str, name: str, elements: Sequence[str], driven: dict[str, str]) -> str:
    """A sentence on an element that does not exist; of a row that does, its elements."""
    if name in driven:
        return f"no {kind} {name!r}; did you mean {driven[name]!r}, which the joint drives?"
    row = name.rpartition(".")[0]
    near = [element for element in elements if element.rpartition(".")[0] == row]
    return unknown_name(kind, name, near or elements)


def _name_faults(names: list[str]) -> Iterator[str]:
    for name in dict.fromkeys(name for name in names if names.count(name) > 1):
        same = [str(index + 1) for index, other in enumerate(names) if other == name]
        yield f"rows {', '.join(same[:-1])} and {same[-1]} have the same name {name!r}: names must differ"
    for index, name in enumerate(names):
        if name in RESERVED:
            yield f"{row_place(index, name)}: the names {', '.join(RESERVED)} are taken: choose another"


def _coupling_faults(matrix: list[list[float]], joints: int) -> Iterator[str]:
    lengths = list(dict.fromkeys(len(line) for line in matrix))
    if len(matrix) != joints:
        yield f"coupling.matrix: expected {joints} lines, one for each joint, found {len(matrix)}"
    if len(lengths) > 1 or lengths == [0]:
        found = " and ".join(map(str, lengths))
        yield f"coupling.matrix: expected lines of equal length, one number for each controller joint, found {found}"


def _key_faults(entry: RobotEntry, row: RowEntry, where: str) -> Iterator[str]:
    """Keys of the other convention."""
    urdf = entry.convention == "urdf"
    own, other = (URDF_KEYS, DH_KEYS) if urdf else (DH_KEYS, URDF_KEYS)
    for key in other:
        if getattr(row, key) is not None:
            yield f"{where}: {key!r} is not of convention {entry.convention!r} (valid: {', '.join(own)})"
    if urdf and row.axis is not None and not math.hypot(*row.axis) > 1e-9:
        yield f"{where}, axis: expected a direction, found zero length"


def _joint_faults(row: RowEntry, where: str) -> Iterator[str]:
    if row.limits is not None and row.limits[0] >= row.limits[1]:
        yield f"{where}, limits: expected [lower, upper], found {list(row.limits)}"
    lone = [key for key in ("limits", "stiffness") if getattr(row, key) is not None]
    if row.joint is None and lone:
        yield f'{where} has {" and ".join(lone)} but no joint: expected joint = "revolute" or "prismatic"'


def _unit_faults(entry: RobotEntry, row: RowEntry, where: str) -> Iterator[str]:
    for key in (*DH_KEYS, *URDF_KEYS[:2], "com"):
        value = getattr(row, key)
        values = value if isinstance(value, tuple) else () if value is None else (value,)
        unit_fault = _angle_fault if key in ROTATION_KEYS or key == "rpy" else _length_fault
        yield from unit_fault(entry, f"{where}, {key}", values)
    if row.joint == "revolute" and row.limits:
        yield from _angle_fault(entry, f"{where}, limits", row.limits, MOST_TURNS)
    elif row.joint == "prismatic" and row.limits:
        yield from _length_fault(entry, f"{where}, limits", row.limits)


def _frame_faults(entry: RobotEntry) -> Iterator[str]:
    frames: list[tuple[tuple[str, ...], FrameEntry]] = [(("base",), entry.base), (("tool",), entry.tool)]
    frames += [(("target", name), frame) for name, frame in entry.target.items()]
    frames += [(("station", name), frame) for name, frame in entry.station.items()]
    for place, frame in frames:
        yield from _length_fault(entry, dotted((*place, "xyz")), frame.xyz or ())
        yield from _angle_fault(entry, dotted((*place, "rpy")), frame.rpy or ())
    yield from _length_fault(entry, "tool.com", entry.tool.com)
    for name, load in entry.load.items():
        yield from _length_fault(entry, dotted(("load", name, "com")), load.com)


def _angle_fault(entry: RobotEntry, where: str, values: Sequence[float], most: float = 1.01) -> Iterator[str]:
    """An angle in a file of radians that is one in degrees."""
    value = max(values, key=abs, default=0.0)
    if entry.angle_unit == "rad" and abs(value) > most * 2.0 * math.pi:
        turns = abs(value) / (2.0 * math.pi)
        yield f'{where}: {value:g} rad is {turns:.3g} turns: is angle_unit = "deg" meant?'


def _length_fault(entry: RobotEntry, where: str, values: Sequence[float]) -> Iterator[str]:
    """A length that is one in millimetres, or a slip."""
    value = max(values, key=abs, default=0.0)
    if abs(value) * UNITS["length"][entry.length_unit] > LONGEST:
        hint = ': is length_unit = "mm" meant?' if entry.length_unit == "m" else ""
        yield f"{where}: {value:g} {entry.length_unit} is longer than any robot{hint}"


def _law_faults(where: str, found: ElasticEntry) -> Iterator[str]:
    """A law that does not exist, or with coefficients that it does not have."""
    if found.law not in CURVES:
        yield f"{where}.law: {unknown_name('law', found.law, CURVES)}"
        return
    law = CURVES[found.law]
    if len(found.coefficients) != len(law.coefficients):
        names = ", ".join(law.coefficients)
        yield f"{where}.coefficients: expected [{names}] of law {law.name!r}, found {len(found.coefficients)} numbers"
    elif law is HARMONIC_DRIVE:
        yield from _drive_faults(where, found.coefficients)
    if law.transition and found.transition_torque is None:
        yield f"{where}: 'transition_torque' is missing: law {law.name!r} has one"
    if not law.transition and found.transition_torque is not None:
        yield f"{where}.transition_torque: law {law.name!r} has none: leave it out"


def _drive_faults(where: str, coefficients: Sequence[float]) -> Iterator[str]:
    """A harmonic drive's curve that is not steeper than its soft wind-up: it would not carry every load."""
    a3, a1, k_sw, a_sw = coefficients
    for name, value in (("a3", a3), ("k_sw", k_sw), ("a_sw", a_sw)):
        if value < 0.0:
            yield f"{where}.coefficients: expected {name} of 0 or more, found {value:g}"
    if not a1 > k_sw or a1 <= 0.0:
        yield f"{where}.coefficients: expected a1 above k_sw and 0, so that the drive is stiff, found {a1:g}"
