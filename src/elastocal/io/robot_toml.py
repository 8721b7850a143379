"""Robot files: TOML in and out."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import tomli_w
from pydantic import TypeAdapter, ValidationError

from elastocal.errors import InputError
from elastocal.io.checking import faults_of
from elastocal.io.files import read_toml
from elastocal.io.robot_checks import joined_faults, local_faults, sound_part
from elastocal.io.robot_schema import FrameEntry, RobotEntry, RowEntry
from elastocal.io.units import UNITS
from elastocal.robot import DH_KEYS, JOINT_KEYS, ROTATION_KEYS, Compliance, Frame, JointMap, Payload, Robot, Row

FORMAT = "elastocal-robot/1"

ORIGIN = (0.0, 0.0, 0.0)


def read_robot_toml(path: Path) -> Robot:
    """The robot of a TOML file.

    Raises:
        InputError: with every fault of the file.
    """
    return robot_of(read_toml(path), str(path))


def robot_of(values: dict[str, Any], place: str) -> Robot:
    """The robot of a TOML file's values; `place` is where they stand.

    Raises:
        InputError: with every fault of them.
    """
    robot, faults = _checked(values)
    if robot is None or faults:
        raise InputError(*(f"{place}: {fault}" for fault in faults))
    return robot


def _checked(values: dict[str, Any]) -> tuple[Robot | None, list[str]]:
    """The robot, if the file follows the schema, and all faults; what of it is sound is checked further in any case."""
    schema = TypeAdapter(RobotEntry)
    try:
        entry = schema.validate_python(values)
    except ValidationError as error:
        found = faults_of(RobotEntry, values, error)
        faults = [fault.text for fault in found]
        part = sound_part(values, found)
        return None, faults if part is None else [*faults, *local_faults(schema.validate_python(part))]
    robot = _robot(entry)
    return robot, [*local_faults(entry), *joined_faults(entry, robot)]


def _robot(entry: RobotEntry) -> Robot:
    length, angle = UNITS["length"][entry.length_unit], UNITS["angle"][entry.angle_unit]
    urdf = entry.convention == "urdf"

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
        geometry = {key: (getattr(given, key) or 0.0) * (angle if key in ROTATION_KEYS else length) for key in DH_KEYS}
        return Row(
            name=given.name,
            joint=given.joint,
            geometry={} if urdf else geometry,
            origin=Frame(lengths(given.xyz or ORIGIN), angles(given.rpy or ORIGIN)) if urdf else Frame(),
            axis=_direction(given.axis or (0.0, 0.0, 1.0)),
            sign=int(given.sign),
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
        tolerance=_tolerances(entry),
    )


def _tolerances(entry: RobotEntry) -> dict[str, float]:
    units = {
        "length": UNITS["length"][entry.length_unit],
        "angle": UNITS["angle"][entry.angle_unit],
        "offset": UNITS["angle"][entry.angle_unit],
    }
    given = {kind: getattr(entry.tolerance, kind) for kind in units}
    return {kind: value * units[kind] for kind, value in given.items() if value is not None}


def _direction(axis: tuple[float, float, float]) -> tuple[float, float, float]:
    """An axis of unit length; one that has it already stays as it is, to the last digit."""
    length = math.hypot(*axis) or 1.0
    return axis if abs(length - 1.0) < 1e-12 else (axis[0] / length, axis[1] / length, axis[2] / length)


def _padded(sin: list[float], cos: list[float]) -> tuple[tuple[float, ...], tuple[float, ...]]:
    orders = max(len(sin), len(cos))
    return tuple(sin + [0.0] * (orders - len(sin))), tuple(cos + [0.0] * (orders - len(cos)))


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
        "tolerance": dict(robot.tolerance),
    }
    optional = ("target", "load", "coupling", "elastic", "transmission", "station", "tolerance")
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
