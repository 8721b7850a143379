"""What a calibration changed in each row: corrections for a controller that holds the nominal robot."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from elastocal.chain import X_AXIS, Y_AXIS, Z_AXIS, Array, rotation_about, rotation_vectors
from elastocal.conversion.deviation import rigid
from elastocal.errors import InputError
from elastocal.identification import IdentifiedParameter
from elastocal.robot import DH_KEYS, FRAME_KEYS, ROTATION_KEYS, Robot, Row


@dataclass(frozen=True)
class RowChange:
    """What became of one row.

    Attributes:
        row: as identified.
        offset: to be added to the controller's joint position [rad or m]; zero for a fixed row.
        deltas: identified - nominal of the row's other elements, by key [rad or m]. Of a URDF joint's origin tx, ty, tz
            in the frame before it, and small turns rx, ry, rz (Rx Ry Rz) about its own axes.
    """

    row: Row
    offset: float
    deltas: Mapping[str, float]


def row_changes(nominal: Robot, identified: Robot) -> tuple[RowChange, ...]:
    """What a calibration changed, row by row.

    Raises:
        InputError: the two are not the same robot: other rows, joints or convention.
    """
    faults = list(_differences(nominal, identified))
    if faults:
        raise InputError(*faults)
    change = _urdf_change if identified.convention == "urdf" else _dh_change
    return tuple(map(change, nominal.rows, identified.rows))


def _differences(nominal: Robot, identified: Robot) -> Iterable[str]:
    if nominal.convention != identified.convention:
        yield (
            f"the nominal robot is of convention {nominal.convention!r}, the identified one {identified.convention!r}: "
            "expected the same"
        )
    names, others = ([row.name for row in robot.rows] for robot in (nominal, identified))
    if names != others:
        yield f"the nominal robot has rows {', '.join(names)}, the identified one {', '.join(others)}"
        return
    for row, other in zip(nominal.rows, identified.rows, strict=True):
        if (row.joint, row.sign) != (other.joint, other.sign):
            yield f"row {row.name}: joint and sign differ between the nominal robot and the identified one"


def _dh_change(nominal: Row, identified: Row) -> RowChange:
    deltas = {key: identified.geometry.get(key, 0.0) - nominal.geometry.get(key, 0.0) for key in DH_KEYS}
    deltas |= {key: math.remainder(deltas[key], 2.0 * math.pi) for key in DH_KEYS if key in ROTATION_KEYS}
    driven = (identified.joint_element or "").rpartition(".")[2]
    return RowChange(identified, identified.sign * deltas.pop(driven, 0.0), deltas)


def _urdf_change(nominal: Row, identified: Row) -> RowChange:
    """The turn about, or the way along, the joint's axis is the joint's offset; the rest is the origin's."""
    axis = np.array(identified.axis)
    shift = identified.origin.translation - nominal.origin.translation
    turn = nominal.origin.rotation.T @ identified.origin.rotation
    offset = 0.0
    if identified.joint == "revolute":
        offset = _twist(turn, axis)
        turn = turn @ rotation_about(identified.axis, -offset)
    elif identified.joint == "prismatic":
        along = identified.origin.rotation @ axis
        offset = float(shift @ along)
        shift = shift - offset * along
    angles = (math.atan2(-turn[1, 2], turn[2, 2]), math.asin(turn[0, 2]), math.atan2(-turn[0, 1], turn[0, 0]))
    deltas = dict(zip(FRAME_KEYS, (*shift.tolist(), *angles), strict=True))
    return RowChange(identified, identified.sign * offset, deltas)


def _twist(rotation: Array, axis: Array) -> float:
    """The angle of a rotation's part about an axis; the rest turns about an axis across it."""
    vector = rotation_vectors(rotation[:, :, None])[:, 0]
    angle = float(np.linalg.norm(vector))
    sine = math.sin(0.5 * angle) * float(vector @ axis) / angle if angle else 0.0
    return 2.0 * math.atan2(sine, math.cos(0.5 * angle))


def with_offsets_only(nominal: Robot, changes: Iterable[RowChange], identified: Robot) -> Robot:
    """The nominal robot with the joint offsets, base and tool of the identified one; rigid."""
    offsets = {c.row.joint_element: c.row.sign * c.offset for c in changes if c.row.joint_element}
    moved = nominal.displaced(offsets)
    return replace(rigid(identified), rows=rigid(moved).rows)


def nominal_geometry(identified: Robot, parameters: Iterable[IdentifiedParameter]) -> Robot:
    """The robot with its rows as they were before the calibration that tells its parameters."""
    values = {p.name: (p.nominal, p.identified) for p in parameters}
    undone = _urdf_undone if identified.convention == "urdf" else _dh_undone
    return replace(identified, rows=tuple(undone(row, values) for row in identified.rows))


Values = Mapping[str, tuple[float | None, float]]
"""Nominal and identified values of parameters by name."""


def _dh_undone(row: Row, values: Values) -> Row:
    before = {key: values[f"{row.name}.{key}"][0] for key in DH_KEYS if f"{row.name}.{key}" in values}
    return replace(row, geometry={**row.geometry, **{key: value for key, value in before.items() if value is not None}})


def _urdf_undone(row: Row, values: Values) -> Row:
    known = {key: values.get(f"{row.name}.{key}", (0.0, 0.0)) for key in (*FRAME_KEYS, "theta", "d")}
    turns = [
        rotation_about(axis, known[key][1])
        for key, axis in zip(("rx", "ry", "rz"), (X_AXIS, Y_AXIS, Z_AXIS), strict=True)
    ]
    offset = rotation_about(row.axis, known["theta"][1]) if row.joint == "revolute" else np.eye(3)
    rotation = row.origin.rotation @ (turns[0] @ turns[1] @ turns[2] @ offset).T
    translation = np.array([known[key][0] if known[key][0] is not None else 0.0 for key in FRAME_KEYS[:3]])
    return replace(row, origin=row.origin.at(translation, rotation))
