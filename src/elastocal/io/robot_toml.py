"""Robot files: TOML in and out."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from elastocal.elasticity import LAWS
from elastocal.errors import InputError, unknown_name
from elastocal.io.checking import check
from elastocal.io.files import read_toml
from elastocal.io.robot_schema import FrameEntry, RobotEntry, RowEntry
from elastocal.io.units import UNITS
from elastocal.robot import DH_KEYS, JOINT_KEYS, ROTATION_KEYS, Compliance, Frame, JointMap, Payload, Robot, Row

RESERVED = ("base", "tool", "target", "station")

FORMAT = "elastocal-robot/1"

LONGEST = 50.0
"""A length [m] beyond this is one in millimetres."""

MOST_TURNS = 4.0
"""A joint that travels further is one whose degrees were taken for radians."""


def read_robot_toml(path: Path) -> Robot:
    """The robot of a TOML file.

    Raises:
        InputError: with every fault of the file.
    """
    entry = check(RobotEntry, read_toml(path), path)
    faults = [f"{path}: {fault}" for fault in _faults(entry)]
    if faults:
        raise InputError(*faults)
    robot = _robot(entry)
    faults = [f"{path}: {fault}" for fault in _element_faults(entry, robot)]
    if faults:
        raise InputError(*faults)
    return robot


def _robot(entry: RobotEntry) -> Robot:
    length, angle = UNITS["length"][entry.length_unit], UNITS["angle"][entry.angle_unit]

    def lengths(values: tuple[float, float, float]) -> tuple[float, float, float]:
        x, y, z = values
        return x * length, y * length, z * length

    def angles(values: tuple[float, float, float]) -> tuple[float, float, float]:
        x, y, z = values
        return x * angle, y * angle, z * angle

    def frame(given: FrameEntry) -> Frame:
        xyz = None if given.xyz is None else lengths(given.xyz)
        return Frame(xyz, None if given.rpy is None else angles(given.rpy), given.known)

    def row(given: RowEntry) -> Row:
        travel = length if given.joint == "prismatic" else angle
        geometry = {key: getattr(given, key) * (angle if key in ROTATION_KEYS else length) for key in DH_KEYS}
        axis = np.array(given.axis) / np.linalg.norm(given.axis)
        return Row(
            name=given.name,
            joint=given.joint,
            geometry={} if entry.convention == "urdf" else geometry,
            origin=Frame(lengths(given.xyz), angles(given.rpy)) if entry.convention == "urdf" else Frame(),
            axis=tuple(axis.tolist()),
            sign=given.sign,
            limits=None if given.limits is None else (given.limits[0] * travel, given.limits[1] * travel),
            mass=given.mass,
            com=lengths(given.com),
        )

    stiff = {f"{r.name}.{JOINT_KEYS[r.joint]}": 1.0 / r.stiffness for r in entry.row if r.joint and r.stiffness}
    elastic = {name: Compliance("linear", (compliance,)) for name, compliance in stiff.items()}
    for name, found in entry.elastic.items():
        elastic[name] = Compliance(found.law, tuple(found.coefficients), found.transition_torque)
    return Robot(
        name=entry.name,
        convention=entry.convention,
        rows=tuple(row(given) for given in entry.row),
        gravity=entry.gravity,
        base=frame(entry.base),
        tool=frame(entry.tool),
        tool_load=Payload(entry.tool.mass, lengths(entry.tool.com)),
        targets={name: frame(given) for name, given in entry.target.items()},
        loads={name: Payload(given.mass, lengths(given.com)) for name, given in entry.load.items()},
        coupling=None if entry.coupling is None else tuple(tuple(line) for line in entry.coupling.matrix),
        elastic=elastic,
        transmission={name: JointMap(*_padded(given.sin, given.cos)) for name, given in entry.transmission.items()},
        stations={name: frame(given) for name, given in entry.station.items()},
    )


def _padded(sin: list[float], cos: list[float]) -> tuple[tuple[float, ...], tuple[float, ...]]:
    orders = max(len(sin), len(cos))
    return tuple(sin + [0.0] * (orders - len(sin))), tuple(cos + [0.0] * (orders - len(cos)))


def _faults(entry: RobotEntry) -> Iterator[str]:
    """What no schema can say of a file."""
    yield from _name_faults([row.name for row in entry.row])
    joints = sum(row.joint is not None for row in entry.row)
    if not joints:
        yield "no row has a joint: write joint = 'revolute' or 'prismatic' in those that move"
    for row in entry.row:
        yield from _row_faults(entry, row)
    for place, values in _lengths(entry):
        for value in values:
            if abs(value) * UNITS["length"][entry.length_unit] > LONGEST:
                yield f'{place}: {value:g} {entry.length_unit} is longer than any robot: is length_unit = "mm" meant?'
    if entry.coupling is not None:
        yield from _coupling_faults(entry.coupling.matrix, joints)


def _name_faults(names: list[str]) -> Iterator[str]:
    for name in sorted({name for name in names if names.count(name) > 1}):
        yield f"two rows are named {name!r}: names must differ"
    for name in names:
        if name in RESERVED:
            yield f"row {name!r}: the names {', '.join(RESERVED)} are taken: choose another"


def _coupling_faults(matrix: list[list[float]], joints: int) -> Iterator[str]:
    if len(matrix) != joints or len({len(line) for line in matrix}) != 1 or not matrix[0]:
        shape = "×".join(str(size) for size in (len(matrix), *sorted({len(line) for line in matrix})))
        yield f"coupling, matrix: expected {joints} lines of equal length, one for each joint, found {shape}"


def _row_faults(entry: RobotEntry, row: RowEntry) -> Iterator[str]:
    urdf = entry.convention == "urdf"
    other = DH_KEYS if urdf else ("xyz", "rpy", "axis")
    defaults = RowEntry(name="-")
    for key in other:
        if getattr(row, key) != getattr(defaults, key):
            valid = ", ".join(("xyz", "rpy", "axis") if urdf else DH_KEYS)
            yield f"row {row.name!r}: {key!r} is not of convention {entry.convention!r} (valid: {valid})"
    if urdf and not np.linalg.norm(row.axis) > 1e-9:
        yield f"row {row.name!r}, axis: expected a direction, found zero length"
    if row.limits is not None and row.limits[0] >= row.limits[1]:
        yield f"row {row.name!r}, limits: expected [lower, upper], found {list(row.limits)}"
    if row.joint is None and (row.limits is not None or row.stiffness is not None):
        yield f"row {row.name!r} has limits or stiffness but no joint: expected joint = 'revolute' or 'prismatic'"
    if entry.angle_unit == "rad":
        angles = {key: (getattr(row, key), 1.01) for key in ROTATION_KEYS if hasattr(row, key)}
        if row.joint == "revolute" and row.limits:
            angles["limits"] = (max(map(abs, row.limits)), MOST_TURNS)
        for key, (value, most) in angles.items():
            if abs(value) > most * 2.0 * np.pi:
                turns = abs(value) / (2.0 * np.pi)
                yield f'row {row.name!r}, {key}: {value:g} rad is {turns:.0f} turns: is angle_unit = "deg" meant?'


def _lengths(entry: RobotEntry) -> Iterator[tuple[str, tuple[float, ...]]]:
    for row in entry.row:
        yield f"row {row.name!r}", (row.a, row.b, row.d, *row.xyz, *row.com)
    yield "tool", ((*(entry.tool.xyz or ()), *entry.tool.com))
    for name, target in entry.target.items():
        yield f"target {name!r}", target.xyz or ()


def _element_faults(entry: RobotEntry, robot: Robot) -> Iterator[str]:
    """Names of elements and laws, and how many coefficients they have."""
    elements = [e.name for row in robot.row_elements for e in row if e.name]
    elements += [f"{prefix}.{key}" for prefix in robot.frames for key in ("tx", "ty", "tz", "rx", "ry", "rz")]
    driven = [row.joint_element for row in robot.joints]
    for name, found in entry.elastic.items():
        if name not in elements:
            yield f"elastic: {unknown_name('element', name, elements)}"
        if found.law not in LAWS:
            yield f"elastic, {name}: {unknown_name('law', found.law, LAWS)}"
            continue
        law = LAWS[found.law]
        if len(found.coefficients) != len(law.coefficients):
            yield (
                f"elastic, {name}: law {law.name!r} has the coefficients [{', '.join(law.coefficients)}], "
                f"found {len(found.coefficients)}"
            )
        if law.transition != (found.transition_torque is not None):
            yield f"elastic, {name}: law {law.name!r} has {'a' if law.transition else 'no'} transition_torque"
    for name in entry.transmission:
        if name not in driven:
            yield f"transmission: {unknown_name('driven element', name, [d for d in driven if d])}"


def robot_to_toml(robot: Robot) -> str:
    """A robot as the text of a robot file, SI units."""
    urdf = robot.convention == "urdf"
    tables: dict[str, Any] = {
        "format": FORMAT,
        "name": robot.name,
        "convention": robot.convention,
        "length_unit": "m",
        "angle_unit": "rad",
        "gravity": list(robot.gravity),
        "row": [_row_table(row, urdf) for row in robot.rows],
        "base": _frame_table(robot.base),
        "tool": _frame_table(robot.tool) | _payload_table(robot.tool_load),
        "target": {name: _frame_table(frame) for name, frame in robot.targets.items()},
        "load": {name: _payload_table(load) for name, load in robot.loads.items()},
        "coupling": {} if robot.coupling is None else {"matrix": [list(line) for line in robot.coupling]},
        "elastic": {name: _compliance_table(compliance) for name, compliance in robot.elastic.items()},
        "transmission": {
            name: {"sin": list(joint_map.sin), "cos": list(joint_map.cos)}
            for name, joint_map in robot.transmission.items()
        },
        "station": {name: _frame_table(frame) for name, frame in robot.stations.items()},
    }
    optional = ("target", "load", "coupling", "elastic", "transmission", "station")
    return tomli_w.dumps({key: value for key, value in tables.items() if value or key not in optional})


def _row_table(row: Row, urdf: bool) -> dict[str, Any]:
    table: dict[str, Any] = {"name": row.name}
    if urdf:
        table |= {"xyz": row.origin.translation.tolist(), "rpy": list(row.origin.rpy or (0.0, 0.0, 0.0))}
        if row.joint:
            table["axis"] = list(row.axis)
    else:
        table |= {key: float(row.geometry.get(key, 0.0)) for key in DH_KEYS}
    if row.joint:
        table |= {"joint": row.joint, "sign": row.sign}
    if row.limits:
        table["limits"] = list(row.limits)
    if row.mass:
        table |= {"mass": row.mass, "com": list(row.com)}
    return table


def _frame_table(frame: Frame) -> dict[str, Any]:
    table: dict[str, Any] = {}
    if frame.xyz is not None:
        table["xyz"] = list(frame.xyz)
    if frame.rpy is not None:
        table["rpy"] = list(frame.rpy)
    return table | ({"known": True} if frame.known else {})


def _payload_table(payload: Payload) -> dict[str, Any]:
    return {"mass": payload.mass, "com": list(payload.com)}


def _compliance_table(compliance: Compliance) -> dict[str, Any]:
    table: dict[str, Any] = {"law": compliance.law, "coefficients": list(compliance.coefficients)}
    if compliance.transition_torque is not None:
        table["transition_torque"] = compliance.transition_torque
    return table
