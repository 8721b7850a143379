"""The tidy table: one row, one observation; headers like "x [mm]" carry the units."""

from __future__ import annotations

import re
from difflib import get_close_matches
from io import BytesIO
from typing import Any

import numpy as np
import polars as pl

from elastocal.chain import Array
from elastocal.errors import unknown_name
from elastocal.io.tables import Table
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

ALL_OR_NONE = (
    ("x", "y", "z"),
    ("qw", "qx", "qy", "qz"),
    ("wrench_fx", "wrench_fy", "wrench_fz", "wrench_mx", "wrench_my", "wrench_mz"),
)

_HEADER = re.compile(r"\s*(?P<name>[^\[\]]*?)\s*(?:\[\s*(?P<unit>[^\]]*?)\s*\])?\s*")


def read_tidy(table: Table, robot: Robot) -> Measurements:
    """The measurements of a tidy table; faults are noted in the table, what they leave is zero."""
    columns = _columns(table, robot)
    joints = [f"q{i + 1}" for i in range(robot.positions)]
    quantities = {joint: "length" if slides else "angle" for joint, slides in zip(joints, sliding(robot), strict=True)}
    quantities |= QUANTITIES

    def numbers(name: str) -> Array:
        header, unit = columns[name]
        scale = factor(quantities[name], unit)
        if scale is None:
            valid = UNITS[quantities[name]]
            table.fault(f"column {header!r}: {unknown_name('unit', unit or '', valid)}")
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
        orientation=rotations(table, together(ALL_OR_NONE[1])),
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


def _columns(table: Table, robot: Robot) -> dict[str, tuple[str, str | None]]:
    """Header and unit by the names that the format knows; unknown and missing ones are noted."""
    valid = [*(f"q{i + 1}" for i in range(robot.positions)), *QUANTITIES, *NAMES]
    found: dict[str, tuple[str, str | None]] = {}
    for header in table.frame.columns:
        match = _HEADER.fullmatch(header)
        name, unit = (match["name"], match["unit"]) if match else (header, None)
        if name in found:
            table.fault(f"columns {found[name][0]!r} and {header!r} say the same: leave one out")
        elif name in valid:
            found[name] = (header, unit)
        elif get_close_matches(name, valid, n=1, cutoff=0.75) and not re.fullmatch(r"q\d+", name):
            table.fault(unknown_name("column", name, valid))
    _check_columns(table, robot, found)
    return found


def _check_columns(table: Table, robot: Robot, found: dict[str, tuple[str, str | None]]) -> None:
    headers = table.frame.columns
    if len(headers) == 1 and any(mark in headers[0] for mark in ";\t"):
        mark = ";" if ";" in headers[0] else "\\t"
        table.fault(
            f"the header has one column, {headers[0][:40]!r}: expected commas between columns; for another mark "
            f'describe the file by a TOML with delimiter = "{mark}"'
        )
        return
    joints = [f"q{i + 1}" for i in range(robot.positions)]
    named = [header for header in headers if re.fullmatch(r"\s*q\d+\s*(\[.*\])?\s*", header)]
    if any(joint not in found for joint in joints) or len(named) != len(joints):
        table.fault(
            f"expected the columns {joints[0]} … {joints[-1]} of the {len(joints)} joints of {robot.name}, "
            f"found {', '.join(repr(header) for header in named) or 'none of them'}"
        )
    for group in ALL_OR_NONE:
        missing = [name for name in group if name not in found]
        if 0 < len(missing) < len(group):
            table.fault(f"expected all of {', '.join(group)} or none, {', '.join(missing)} missing")
    if not any(name in found for name in ("x", "y", "z", "qw", "distance")):
        table.fault("expected something measured: columns x, y, z and/or qw, qx, qy, qz and/or distance, found none")


def sliding(robot: Robot) -> list[bool]:
    """Which of the controller's joint positions are lengths."""
    return [row.joint == "prismatic" for row in robot.joints][: robot.positions]


def rotations(table: Table, quaternions: Array | None) -> Array | None:
    """Rotations (rows, 3, 3) of quaternions (rows, 4), w first; one that is far from unit length is a fault."""
    if quaternions is None:
        return None
    length = np.linalg.norm(quaternions, axis=1)
    bad = np.flatnonzero(~(np.abs(length - 1.0) < 0.01))
    table.rows_fault(
        "qw, qx, qy, qz", bad.tolist(), [f"length {value:.3g}" for value in length[bad[:1]]], "unit length"
    )
    w, x, y, z = (quaternions / np.where(length > 0.0, length, 1.0)[:, None]).T
    matrix = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(matrix), -1, 0)


def measurements_to_csv(data: Measurements, robot: Robot) -> bytes:
    """Measurements as a tidy table in degrees and millimetres, every digit kept."""
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
        columns["pose"] = data.pose
    buffer = BytesIO()
    pl.DataFrame(columns).write_csv(buffer)
    return buffer.getvalue()


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
        columns["sigma [mm]"] = data.sigma[:, 0] / 1e-3
    if data.sigma_angle is not None:
        columns["sigma_angle [rad]"] = data.sigma_angle
    return columns
