"""Descriptors: a TOML beside an instrument's own file that says how to read it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Literal

import numpy as np
from pydantic.dataclasses import dataclass

from elastocal.chain import Array
from elastocal.errors import InputError, unknown_name
from elastocal.io.checking import STRICT, Character, Count, Texts, check
from elastocal.io.files import read_toml
from elastocal.io.tables import Header, Table, read_table
from elastocal.io.tidy import joint_names, rotations, sliding, unknown_unit
from elastocal.io.units import factor
from elastocal.measurements import Labels, Measurements
from elastocal.robot import Robot


@dataclass(config=STRICT)
class Columns:
    """Columns of the instrument's file, with their unit, and the convention of an orientation."""

    columns: Texts
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
    delimiter: Character = ","
    decimal: Literal[".", ","] = "."
    skip: Count = 0


ORIENTATIONS = {
    "quaternion-wxyz": 4,
    "quaternion-xyzw": 4,
    "rotation-vector": 3,
    "matrix": 9,
}
"""Conventions of orientations beside Euler angles, by number of columns; a matrix row by row."""

EXAMPLES = ("euler-XYZ", "euler-xyz", "euler-ZYX", "euler-zyx", "euler-ZYZ", "euler-zyz", *ORIENTATIONS)
"""What is shown where a convention does not exist; Euler angles may have any axes."""

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
    file = path.parent / descriptor.file
    table = read_table(file, descriptor.delimiter, descriptor.decimal, descriptor.skip, described=path)
    faults = dict.fromkeys(_faults(descriptor.columns, table, robot))
    if faults:
        raise InputError(*(f"{path}: {fault}" for fault in faults))
    table.headers = _headers(descriptor.columns, robot)
    return table, _measurements(descriptor.columns, table, robot)


def _headers(columns: ColumnsTable, robot: Robot) -> dict[str, Header]:
    """The instrument's headers by the names that the tidy table has for them."""
    found: dict[str, Header] = {}
    for name, entry in vars(columns).items():
        if isinstance(entry, Columns):
            names = {"q": joint_names(robot), "position": ["x", "y", "z"]}.get(name, [name])
            found |= {n: Header(column, entry.unit) for n, column in zip(names, entry.columns, strict=False)}
        elif entry and entry.column:
            found[name] = Header(entry.column, None)
    return found


def described_file(path: Path) -> Path:
    """The instrument's file that a descriptor describes; itself if it names none, which its reader refuses."""
    return path.parent / str(read_toml(path).get("file", path.name))


def _faults(columns: ColumnsTable, table: Table, robot: Robot) -> Iterator[str]:
    """Missing columns, units and conventions that do not exist, wrong numbers of columns."""
    for name, found in vars(columns).items():
        listed = found.columns if isinstance(found, Columns) else [found.column] if found and found.column else []
        yield from _column_faults(f"columns.{name}", listed, table)
        if isinstance(found, Names) and (found.column is None) == (found.value is None):
            yield f"columns.{name}: expected a column or a value for all rows, found {'both' if listed else 'neither'}"
        if isinstance(found, Columns) and found.convention is not None and name != "orientation":
            yield f"columns.{name}: only an orientation has a convention: leave it out"
        if isinstance(found, Columns) and name in QUANTITIES:
            if len(listed) not in COUNTS[name]:
                yield f"columns.{name}: expected {_columns(*COUNTS[name])}, found {len(listed)}"
            yield from _unit_faults(name, found.unit, QUANTITIES[name])
    yield from _joint_faults(columns.q, robot)
    if columns.orientation is not None:
        yield from _orientation_faults(columns.orientation)
    if not (columns.position or columns.orientation or columns.distance):
        yield "columns: expected something measured: position, orientation and/or distance, found none"


def _columns(*counts: int) -> str:
    return f"{' or '.join(map(str, counts))} column{'s' if counts != (1,) else ''}"


def _column_faults(where: str, listed: list[str], table: Table) -> Iterator[str]:
    for column in listed:
        if column not in table.frame.columns:
            yield f"{where}: {table.path.name} has {unknown_name('column', column, table.frame.columns)}"
        elif column in table.repeated:
            yield f"{where}: {table.path.name} has several columns {column!r}: expected one"
        elif listed.count(column) > 1 and not where.endswith("sigma"):
            yield f"{where}: column {column!r} is named twice"


def _joint_faults(q: Columns, robot: Robot) -> Iterator[str]:
    if len(q.columns) != robot.positions:
        joints = f"the joint{'s' if robot.positions > 1 else ''} of {robot.name}"
        yield f"columns.q: expected {_columns(robot.positions)} for {joints}, found {len(q.columns)}"
    kinds = {"length" if slides else "angle" for slides in sliding(robot)}
    if len(kinds) == 1:
        yield from _unit_faults("q", q.unit, kinds.pop())
    elif q.unit is not None:
        yield f"columns.q.unit: {robot.name} has joints that turn and joints that slide: leave it out, give rad and m"


def _unit_faults(name: str, unit: str | None, quantity: str) -> Iterator[str]:
    if unit is not None and factor(quantity, unit) is None:
        yield f"columns.{name}.unit: {unknown_unit(quantity, unit)}"


def _orientation_faults(found: Columns) -> Iterator[str]:
    where, convention = "columns.orientation", found.convention
    if convention is None:
        yield f"{where}: 'convention' is missing: expected one of {', '.join(EXAMPLES)}"
        return
    if not (_is_euler(convention) or convention in ORIENTATIONS):
        yield f"{where}.convention: {unknown_name('convention', convention, EXAMPLES)}"
        return
    count = ORIENTATIONS.get(convention, 3)
    if len(found.columns) != count:
        yield f"{where}: expected {count} columns for {convention}, found {len(found.columns)}"
    if _is_euler(convention) or convention == "rotation-vector":
        yield from _unit_faults("orientation", found.unit, "angle")
    elif found.unit is not None:
        yield f"{where}.unit: {convention} has none: leave it out"


def _is_euler(convention: str) -> bool:
    """Whether it is three axes after "euler-", no two neighbours the same, all capitals or all small."""
    axes = convention.removeprefix("euler-")
    named = set(axes) <= set("XYZ") or set(axes) <= set("xyz")
    return convention.startswith("euler-") and len(axes) == 3 and named and axes[1] not in (axes[0], axes[2])


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
        return rotations(table, values, ", ".join(found.columns))
    if found.convention == "matrix":
        return _orthonormal(table, values.reshape(-1, 3, 3), ", ".join(found.columns))
    angles = np.nan_to_num(values) * (factor("angle", found.unit) or 1.0)
    if found.convention == "rotation-vector":
        return Rotation.from_rotvec(angles).as_matrix()
    return Rotation.from_euler(str(found.convention).removeprefix("euler-"), angles).as_matrix()


def _orthonormal(table: Table, matrices: Array, column: str) -> Array:
    """Rotations from matrices (rows, 3, 3); one that is far from a rotation is a fault."""
    whole = np.nan_to_num(matrices)
    off = np.abs(whole @ whole.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
    mirrored = np.linalg.det(whole) < 0.0
    bad = np.flatnonzero(((off > 0.01) | mirrored) & np.isfinite(matrices).all(axis=(1, 2)))
    found = "".join(f"R·Rᵀ off by {off[row]:.2g}" if off[row] > 0.01 else "a mirrored one" for row in bad[:1])
    table.rows_fault(column, bad.tolist(), found, "a rotation matrix")
    left, _, right = np.linalg.svd(whole)
    return left @ right
