"""The tidy table: one row, one observation; headers like "x [mm]" carry the units."""

from __future__ import annotations

import re
from difflib import get_close_matches
from io import BytesIO
from typing import Any

import numpy as np
import polars as pl

from elastocal.chain import Array
from elastocal.errors import InputError, unknown_name
from elastocal.io.tables import Header, Table
from elastocal.io.units import UNITS, factor
from elastocal.measurements import Labels, Measurements
from elastocal.robot import Robot

QUANTITIES = {
    **dict.fromkeys(("x", "y", "z", "distance", "sigma"), "length"),
    **dict.fromkeys(("qw", "qx", "qy", "qz"), "none"),
    "sigma_angle": "angle",
    **dict.fromkeys(("wrench_fx", "wrench_fy", "wrench_fz"), "force"),
    **dict.fromkeys(("wrench_mx", "wrench_my", "wrench_mz"), "moment"),
    "temperature": "temperature",
}
"""Numeric columns beside the joints', by quantity."""

NAMES = ("target", "load", "station", "pose")

MEASURED = ("x", "y", "z", "qw", "qx", "qy", "qz", "distance")

ALL_OR_NONE = (
    ("x", "y", "z"),
    ("qw", "qx", "qy", "qz"),
    ("wrench_fx", "wrench_fy", "wrench_fz", "wrench_mx", "wrench_my", "wrench_mz"),
)

_HEADER = re.compile(r"\s*(?P<name>[^\[\]]*?)\s*(?:\[\s*(?P<unit>[^\]]*?)\s*\])?\s*")

_UNIT = "|".join(sorted({re.escape(unit) for units in UNITS.values() for unit in units if unit}, key=len, reverse=True))

_LOOSE = re.compile(rf"\s*(?P<name>\w+?)(?:[\s_]*[\s_(\[]\s*(?P<unit>{_UNIT})\s*[)\]]?)?\s*", re.IGNORECASE)
"""A header as people also write it: "q1 (deg)", "X_mm"."""


def read_tidy(table: Table, robot: Robot, measured: bool = True) -> Measurements:
    """The measurements of a tidy table; faults are noted in the table, what they leave is zero.

    Args:
        table: as it was read.
        robot: whose joints it has.
        measured: whether something must have been measured; else joint positions will do, and columns that are still
            to be filled in count as none.
    """
    columns = table.headers = _columns(table, robot)
    if not measured:
        columns = {name: h for name, h in columns.items() if name not in MEASURED or not table.is_empty(h.text)}
    if measured and not any(name in columns for name in MEASURED):
        table.fault("expected something measured: columns x, y, z and/or qw, qx, qy, qz and/or distance, found none")
    joints = [f"q{i + 1}" for i in range(robot.positions)]
    quantities = {joint: "length" if slides else "angle" for joint, slides in zip(joints, sliding(robot), strict=True)}
    quantities |= QUANTITIES

    def numbers(name: str) -> Array:
        header, unit = columns[name]
        scale = factor(quantities[name], unit)
        if scale is None:
            table.fault(f"column {header!r}: {unknown_unit(quantities[name], unit or '')}")
        return table.numbers(header) * (scale or 1.0)

    def together(names: tuple[str, ...]) -> Array | None:
        return np.stack([numbers(name) for name in names], axis=1) if all(name in columns for name in names) else None

    def alone(name: str) -> Array | None:
        return numbers(name) if name in columns else None

    def labels(name: str) -> Labels | None:
        return Labels.of(table.names(columns[name][0])) if name in columns else None

    q, sigma, pose = together(tuple(joints)), alone("sigma"), labels("pose")
    return Measurements(
        q=np.zeros((len(table), len(joints))) if q is None else q,
        position=together(ALL_OR_NONE[0]),
        orientation=rotations(table, together(ALL_OR_NONE[1]), "qw, qx, qy, qz"),
        distance=alone("distance"),
        sigma=None if sigma is None else np.repeat(sigma[:, None], 3, axis=1),
        sigma_angle=alone("sigma_angle"),
        target=labels("target"),
        load=labels("load"),
        station=labels("station"),
        wrench=together(ALL_OR_NONE[2]),
        pose=None if pose is None else pose.codes.astype(np.int64),
        temperature=alone("temperature"),
    )


def unknown_unit(quantity: str, unit: str) -> str:
    """A sentence on a unit that a quantity does not have."""
    if quantity == "none":
        return f"expected no unit, found {unit!r}"
    return unknown_name(f"{quantity} unit", unit, UNITS[quantity])


def _columns(table: Table, robot: Robot) -> dict[str, Header]:
    """Headers by the names that the format knows; unknown, repeated and missing ones are noted."""
    valid = [*joint_names(robot), *QUANTITIES, *NAMES]
    found: dict[str, Header] = {}
    others = []
    for header in table.frame.columns:
        match = _HEADER.fullmatch(header)
        name, unit = (match["name"], match["unit"]) if match else (header, None)
        if name in found:
            table.fault(f"columns {found[name].text!r} and {header!r} say the same: leave one out")
        elif name in valid:
            found[name] = Header(header, unit)
        else:
            others.append(header)
        if header in table.repeated and name in valid:
            table.fault(f"column {header!r} is there {_times(table, header)} times: leave all but one out")
    for header in others:
        _check_unknown(table, header, valid, found)
    used = [header.text for header in found.values()]
    _check_columns(table, robot, found, [h for h in others if h not in used and re.match(r"\s*[qQ]\d+\b", h)])
    return found


def _times(table: Table, header: str) -> int:
    return 1 + sum(other.startswith(f"{header} of column ") for other in table.frame.columns)


def _check_unknown(table: Table, header: str, valid: list[str], found: dict[str, Header]) -> None:
    """A column that the format does not know: it is left alone, unless one that it knows was meant."""
    loose = _LOOSE.fullmatch(header)
    name, unit = (loose["name"].lower(), loose["unit"]) if loose else (header, None)
    if name in valid and name not in found and not (unit and name in NAMES):
        proper = [known for known in UNITS[QUANTITIES.get(name, "angle")] if known.lower() == (unit or "").lower()]
        meant = f"{name} [{(proper or [unit])[0]}]" if unit else name
        table.fault(f"column {header!r}: expected the header {meant!r}")
        found[name] = Header(header, None)
    elif not re.fullmatch(r"q\d+", name) and get_close_matches(name, set(valid) - set(found), n=1, cutoff=0.75):
        table.fault(unknown_name("column", header, valid))


def _check_columns(table: Table, robot: Robot, found: dict[str, Header], spare: list[str]) -> None:
    """Whether there is a column for every joint, and all of those that go together."""
    joints = joint_names(robot)
    missing = [joint for joint in joints if joint not in found]
    if missing or spare:
        wanted = f"{joints[0]} … {joints[-1]} of the {len(joints)} joints" if len(joints) > 1 else "q1 of the one joint"
        wrong = [f"{', '.join(missing)} missing"] if missing else []
        wrong += [f"{', '.join(map(repr, spare))} too many"] if spare else []
        said = "found none of them" if len(missing) == len(joints) and not spare else "; ".join(wrong)
        table.fault(f"expected the columns {wanted} of {robot.name}: {said}")
    for group in ALL_OR_NONE:
        missing = [name for name in group if name not in found]
        if 0 < len(missing) < len(group):
            table.fault(f"expected the columns {', '.join(group)}, or none of them: {', '.join(missing)} missing")


def joint_names(robot: Robot) -> list[str]:
    """The names of the joints' columns."""
    return [f"q{i + 1}" for i in range(robot.positions)]


def sliding(robot: Robot) -> list[bool]:
    """Which of the controller's joint positions are lengths."""
    return [row.joint == "prismatic" for row in robot.joints][: robot.positions]


def rotations(table: Table, quaternions: Array | None, column: str) -> Array | None:
    """Rotations (rows, 3, 3) of quaternions (rows, 4), w first; one that is far from unit length is a fault."""
    if quaternions is None:
        return None
    length = np.linalg.norm(quaternions, axis=1)
    bad = np.flatnonzero(np.abs(length - 1.0) > 0.01)
    table.rows_fault(
        column, bad.tolist(), "".join(f"length {n:.3g}" for n in length[bad[:1]]), "a quaternion, length 1"
    )
    w, x, y, z = (quaternions / np.where(length > 0.0, length, 1.0)[:, None]).T
    matrix = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(matrix), -1, 0)


def measurements_to_csv(data: Measurements, robot: Robot) -> bytes:
    """Measurements as a tidy table in degrees and millimetres, every digit kept.

    Raises:
        InputError: some rows lack what others have.
    """
    buffer = BytesIO()
    pl.DataFrame(tidy_columns(data, robot)).write_csv(buffer)
    return buffer.getvalue()


def tidy_columns(data: Measurements, robot: Robot) -> dict[str, Any]:
    """The columns of measurements' tidy table, by header, in degrees and millimetres.

    Raises:
        InputError: some rows lack what others have.
    """
    _require_complete(data)
    columns: dict[str, Any] = {}
    for i, slides in enumerate(sliding(robot)):
        unit, scale = ("mm", 1e-3) if slides else ("deg", UNITS["angle"]["deg"])
        columns[f"q{i + 1} [{unit}]"] = data.q[:, i] / scale
    columns |= _observed_columns(data)
    for name, labels in (("target", data.target), ("load", data.load), ("station", data.station)):
        if labels is not None:
            columns[name] = [labels.name(int(code)) for code in labels.codes]
    if data.wrench is not None:
        units = ("N", "N", "N", "N·m", "N·m", "N·m")
        columns |= {f"{n} [{u}]": w for n, u, w in zip(ALL_OR_NONE[2], units, data.wrench.T, strict=True)}
    if data.pose is not None:
        columns["pose"] = [int(pose) if pose >= 0 else None for pose in data.pose]
    if data.temperature is not None:
        columns["temperature [degC]"] = data.temperature
    return columns


def _require_complete(data: Measurements) -> None:
    """A table has a number in every cell."""
    kinds = ("position", "orientation", "distance", "sigma", "sigma_angle", "wrench", "temperature")
    given = {kind: getattr(data, kind) for kind in kinds if getattr(data, kind) is not None}
    lacking = {
        kind: np.flatnonzero(~np.isfinite(found.reshape(len(data), -1)).all(axis=1)) for kind, found in given.items()
    }
    faults = [f"row {rows[0] + 1} has no {kind}, which others have" for kind, rows in lacking.items() if len(rows)]
    if faults:
        raise InputError(*(f"{fault}: write them to separate files" for fault in faults))


def _observed_columns(data: Measurements) -> dict[str, Any]:
    columns: dict[str, Any] = {}
    if data.position is not None:
        columns |= {f"{axis} [mm]": values / 1e-3 for axis, values in zip("xyz", data.position.T, strict=True)}
    if data.orientation is not None:
        from scipy.spatial.transform import Rotation

        quaternions = Rotation.from_matrix(data.orientation).as_quat()
        columns |= dict(zip(("qx", "qy", "qz", "qw"), quaternions.T, strict=True))
    if data.distance is not None:
        columns["distance [mm]"] = data.distance / 1e-3
    if data.sigma is not None:
        same = (data.sigma == data.sigma[:, :1]).all(axis=1)
        columns["sigma [mm]"] = np.where(same, data.sigma[:, 0], np.sqrt((data.sigma**2).mean(axis=1))) / 1e-3
    if data.sigma_angle is not None:
        columns["sigma_angle [rad]"] = data.sigma_angle
    return columns
