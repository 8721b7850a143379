"""Descriptors: a TOML beside an instrument's own file that says how to read it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Literal

import numpy as np
from pydantic.dataclasses import dataclass

from elastocal.chain import Array
from elastocal.errors import InputError, unknown_name
from elastocal.io.checking import check
from elastocal.io.files import read_toml
from elastocal.io.robot_schema import STRICT
from elastocal.io.tables import Table, read_table
from elastocal.io.tidy import rotations, sliding
from elastocal.io.units import UNITS, factor
from elastocal.measurements import Labels, Measurements
from elastocal.robot import Robot


@dataclass(config=STRICT)
class Columns:
    """Columns of the instrument's file, with their unit, and the convention of an orientation."""

    columns: list[str]
    unit: str | None = None
    convention: str | None = None


@dataclass(config=STRICT)
class Names:
    """A column of names, or one name for all rows."""

    column: str | None = None
    value: str | None = None


@dataclass(config=STRICT)
class ColumnsTable:
    """[columns]."""

    q: Columns
    position: Columns | None = None
    orientation: Columns | None = None
    distance: Columns | None = None
    sigma: Columns | None = None
    sigma_angle: Columns | None = None
    force: Columns | None = None
    moment: Columns | None = None
    temperature: Columns | None = None
    target: Names | None = None
    load: Names | None = None
    station: Names | None = None
    pose: Names | None = None


@dataclass(config=STRICT)
class Descriptor:
    """The whole file."""

    format: Literal["elastocal-measurements/1"]
    file: str
    columns: ColumnsTable
    delimiter: str = ","
    decimal: Literal[".", ","] = "."
    skip: int = 0


ORIENTATIONS = {
    "quaternion-wxyz": 4,
    "quaternion-xyzw": 4,
    "rotation-vector": 3,
    "matrix": 9,
}
"""Conventions of orientations beside Euler angles, by number of columns; a matrix row by row."""

COUNTS = {
    "position": (3,),
    "distance": (1,),
    "sigma": (1, 3),
    "sigma_angle": (1, 3),
    "force": (3,),
    "moment": (3,),
    "temperature": (1,),
}
QUANTITIES = {
    "position": "length",
    "distance": "length",
    "sigma": "length",
    "sigma_angle": "angle",
    "force": "force",
    "moment": "moment",
    "temperature": "temperature",
}


def read_described(path: Path, robot: Robot) -> tuple[Table, Measurements]:
    """The measurements of the file that a descriptor describes; faults of its rows are noted in the table.

    Raises:
        InputError: the descriptor itself, or the file as a whole, is faulty.
    """
    descriptor = check(Descriptor, read_toml(path), path)
    if len(descriptor.delimiter) != 1:
        raise InputError(f"{path}: delimiter: expected one character, found {descriptor.delimiter!r}")
    table = read_table(path.parent / descriptor.file, descriptor.delimiter, descriptor.decimal, descriptor.skip)
    faults = [f"{path}: columns, {fault}" for fault in _faults(descriptor.columns, table, robot)]
    if faults:
        raise InputError(*faults)
    return table, _measurements(descriptor.columns, table, robot)


def described_file(path: Path) -> Path:
    """The instrument's file that a descriptor describes."""
    return path.parent / str(read_toml(path)["file"])


def _faults(columns: ColumnsTable, table: Table, robot: Robot) -> Iterator[str]:
    """Missing columns, units and conventions that do not exist, wrong numbers of columns."""
    for name, found in vars(columns).items():
        listed = found.columns if isinstance(found, Columns) else [found.column] if found and found.column else []
        for column in listed:
            if column not in table.frame.columns:
                yield f"{name}: {unknown_name(f'column of {table.path.name}', column, table.frame.columns)}"
        if isinstance(found, Columns) and name in QUANTITIES:
            if len(listed) not in COUNTS[name]:
                yield f"{name}: expected {' or '.join(map(str, COUNTS[name]))} columns, found {len(listed)}"
            yield from _unit_faults(name, found.unit, QUANTITIES[name])
    yield from _joint_faults(columns.q, robot)
    if columns.orientation is not None:
        yield from _orientation_faults(columns.orientation)
    if not (columns.position or columns.orientation or columns.distance):
        yield "expected something measured: position, orientation and/or distance, found none"


def _joint_faults(q: Columns, robot: Robot) -> Iterator[str]:
    if len(q.columns) != robot.positions:
        yield f"q: expected {robot.positions} columns for the joints of {robot.name}, found {len(q.columns)}"
    kinds = {"length" if slides else "angle" for slides in sliding(robot)}
    if len(kinds) == 1:
        yield from _unit_faults("q", q.unit, kinds.pop())
    elif q.unit is not None:
        yield "q: joints turn and slide: leave the unit out and give rad and m"


def _unit_faults(name: str, unit: str | None, quantity: str) -> Iterator[str]:
    if factor(quantity, unit) is None:
        yield f"{name}: {unknown_name('unit', unit or '', UNITS[quantity])}"


def _orientation_faults(found: Columns) -> Iterator[str]:
    convention = found.convention or ""
    axes = convention.removeprefix("euler-")
    euler = convention.startswith("euler-") and len(axes) == 3 and (set(axes) <= set("XYZ") or set(axes) <= set("xyz"))
    if not euler and convention not in ORIENTATIONS:
        yield f"orientation: {unknown_name('convention', convention, ['euler-XYZ', 'euler-xyz', *ORIENTATIONS])}"
        return
    count = 3 if euler else ORIENTATIONS[convention]
    if len(found.columns) != count:
        yield f"orientation: expected {count} columns for {convention}, found {len(found.columns)}"
    if euler or convention == "rotation-vector":
        yield from _unit_faults("orientation", found.unit, "angle")


def _measurements(columns: ColumnsTable, table: Table, robot: Robot) -> Measurements:
    def stacked(found: Columns, quantity: str) -> Array:
        scale = (factor(quantity, found.unit) or 1.0) if found.unit else 1.0
        return np.stack([table.numbers(column) for column in found.columns], axis=1) * scale

    def numbers(name: str) -> Array | None:
        found: Columns | None = getattr(columns, name)
        return None if found is None else stacked(found, QUANTITIES[name])

    def labels(name: str) -> Labels | None:
        found: Names | None = getattr(columns, name)
        if found is None:
            return None
        return Labels.of(table.names(found.column) if found.column else [found.value] * len(table))

    sigma, sigma_angle, pose = numbers("sigma"), numbers("sigma_angle"), labels("pose")
    force, moment, distance, temperature = (
        numbers("force"),
        numbers("moment"),
        numbers("distance"),
        numbers("temperature"),
    )
    wrench = None
    if force is not None or moment is not None:
        none = np.zeros((len(table), 3))
        wrench = np.concatenate([none if force is None else force, none if moment is None else moment], axis=1)
    return Measurements(
        q=stacked(columns.q, "length" if all(sliding(robot)) else "angle"),
        position=numbers("position"),
        orientation=_rotations(columns.orientation, table),
        distance=None if distance is None else distance[:, 0],
        sigma=None if sigma is None else np.broadcast_to(sigma, (len(table), 3)).copy(),
        sigma_angle=None if sigma_angle is None else np.sqrt((sigma_angle**2).mean(axis=1)),
        target=labels("target"),
        load=labels("load"),
        station=labels("station"),
        wrench=wrench,
        pose=None if pose is None else pose.codes.astype(np.int64),
        temperature=None if temperature is None else temperature[:, 0],
    )


def _rotations(found: Columns | None, table: Table) -> Array | None:
    """Rotations (rows, 3, 3) of orientations in any convention."""
    if found is None:
        return None
    from scipy.spatial.transform import Rotation

    values = np.stack([table.numbers(column) for column in found.columns], axis=1)
    if found.convention == "quaternion-xyzw":
        values = values[:, [3, 0, 1, 2]]
    if found.convention in ("quaternion-wxyz", "quaternion-xyzw"):
        return rotations(table, values)
    if found.convention == "matrix":
        return _orthonormal(table, values.reshape(-1, 3, 3))
    angles = np.nan_to_num(values) * (factor("angle", found.unit) or 1.0)
    if found.convention == "rotation-vector":
        return Rotation.from_rotvec(angles).as_matrix()
    return Rotation.from_euler(str(found.convention).removeprefix("euler-"), angles).as_matrix()


def _orthonormal(table: Table, matrices: Array) -> Array:
    """Rotations from matrices (rows, 3, 3); one that is far from a rotation is a fault."""
    off = np.abs(matrices @ matrices.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2)) + (np.linalg.det(matrices) < 0.0)
    bad = np.flatnonzero(~(off < 0.01))
    table.rows_fault("matrix", bad.tolist(), ["none" for _ in bad[:1]], "a rotation matrix")
    left, _, right = np.linalg.svd(np.nan_to_num(matrices))
    return left @ right
