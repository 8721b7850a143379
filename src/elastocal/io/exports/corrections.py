"""Corrections of each joint as CSV, for controllers whose own files cannot be tested here."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from elastocal.conversion import RowChange, rigid, row_changes, with_offsets_only
from elastocal.conversion.deviation import AT_BASE
from elastocal.errors import InputError
from elastocal.io.exports.dh import FRAME_COLUMNS, frame_numbers, plain
from elastocal.io.exports.exported import Draft, Request
from elastocal.io.exports.losses import losses, tool_note
from elastocal.io.results import csv_bytes
from elastocal.robot import DH_KEYS, FRAME_KEYS, ROTATION_KEYS, Compliance, Robot

LAW_COLUMNS = ("law", "stiffness", "stiffness_high", "transition_torque", "coefficients", "unit")

NAMES = {"tx": "x", "ty": "y", "tz": "z"}


def corrections_csv(request: Request) -> Draft:
    """What changed in each row, compliance, tool and base."""
    robot = request.robot
    if request.nominal is None:
        raise InputError(
            "--to corrections-csv: the nominal robot is not known: name it (--nominal ROBOT), or export the robot.toml "
            "in the folder of its calibration, beside its result.json"
        )
    changes = row_changes(request.nominal, robot)
    return Draft(
        text=csv_bytes(_columns(list(_lines(robot, changes)), robot)).decode(),
        readings={
            "geometry and compliance": replace(robot, base=AT_BASE, stations={}, transmission={}),
            "geometry": replace(rigid(robot), base=AT_BASE),
            "offsets and tool": replace(with_offsets_only(request.nominal, changes, robot), base=AT_BASE),
        },
        cannot_hold=losses(robot, {"compliance", "base"}),
        notes=(
            *tool_note(robot),
            "Deltas are identified minus nominal, in the model's own sense; 'offset' is what to add to the "
            "controller's joint position. 'geometry and compliance' is under the masses of the robot file. Which "
            "field of a controller takes which column: docs/controllers.md.",
        ),
    )


def _lines(robot: Robot, changes: Sequence[RowChange]) -> Iterator[dict[str, Any]]:
    for change in changes:
        row = change.row
        yield {"row": row.name, "joint": row.joint or "fixed", **_numbers(change), **_law(robot, row.joint_element)}
    others = [name for name in robot.elastic if name not in {row.joint_element for row in robot.rows}]
    yield from ({"row": name, "joint": None, **_law(robot, name)} for name in others)
    frames = {name: frame for name, frame in robot.frames.items() if not name.startswith("target")}
    for name, frame in frames.items():
        if name == "tool" or frame.xyz is not None or frame.rpy is not None:
            yield {"row": name, "joint": None, **dict(zip(FRAME_COLUMNS, frame_numbers(frame), strict=True))}


def _numbers(change: RowChange) -> dict[str, float]:
    unit = "mm" if change.row.joint == "prismatic" else "deg"
    numbers = {f"offset [{unit}]": _shown(change.offset, unit)} if change.row.joint else {}
    return numbers | {_header(key): _shown(value, _unit(key)) for key, value in change.deltas.items()}


def _unit(key: str) -> str:
    return "deg" if key in ROTATION_KEYS else "mm"


def _header(key: str) -> str:
    return f"delta_{NAMES.get(key, key)} [{_unit(key)}]"


def _shown(value: float, unit: str) -> float:
    return plain(math.degrees(value) if unit == "deg" else 1e3 * value)


def _law(robot: Robot, element: str | None) -> dict[str, Any]:
    """A law with its stiffnesses where it is linear piece by piece, and its coefficients (SI) in any case."""
    found: Compliance | None = robot.elastic.get(element or "")
    if found is None or element is None:
        return {}
    turns = element.rpartition(".")[2] in ROTATION_KEYS
    stiff = [1.0 / c if c else None for c in found.coefficients] if found.law in ("linear", "step", "hinge") else []
    return {
        "law": found.law,
        "stiffness": stiff[0] if stiff else None,
        "stiffness_high": stiff[1] if len(stiff) > 1 else None,
        "transition_torque": found.transition_torque,
        "coefficients": " ".join(repr(c) for c in found.coefficients),
        "unit": "N·m/rad" if turns else "N/m",
    }


def _columns(lines: Sequence[dict[str, Any]], robot: Robot) -> dict[str, list[Any]]:
    keys = FRAME_KEYS if robot.convention == "urdf" else DH_KEYS
    offsets = ("offset [deg]", "offset [mm]")
    names = ("row", "joint", *offsets, *map(_header, keys), *LAW_COLUMNS, *FRAME_COLUMNS)
    columns = {name: [line.get(name) for line in lines] for name in names}
    optional = (*offsets, *LAW_COLUMNS)
    return {
        name: values for name, values in columns.items() if name not in optional or any(v is not None for v in values)
    }
