"""Plain Denavit-Hartenberg tables as CSV."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from elastocal.conversion import Table, dh_table
from elastocal.io.exports.exported import Draft, Request
from elastocal.io.exports.losses import losses, require_uncoupled, tool_note
from elastocal.io.results import csv_bytes
from elastocal.robot import Frame

FRAME_COLUMNS = ("x [mm]", "y [mm]", "z [mm]", "roll [deg]", "pitch [deg]", "yaw [deg]")

PLACES = 9
"""Of millimetres and degrees in a table."""

ORDERS = {
    "standard-dh": "Rz(theta) Tz(d) Tx(a) Rx(alpha)",
    "modified-dh": "Rx(alpha) Tx(a) Rz(theta) Tz(d)",
}


def dh_csv(request: Request) -> Draft:
    """The robot as a standard table."""
    return _table(request, "standard-dh", "dh-csv")


def mdh_csv(request: Request) -> Draft:
    """The robot as a modified table (Craig)."""
    return _table(request, "modified-dh", "mdh-csv")


def _table(request: Request, convention: str, to: str) -> Draft:
    robot = request.robot
    require_uncoupled(robot, to)
    table = dh_table(robot, convention, request.q, request.longest)
    return Draft(
        text=csv_bytes(_columns(table)).decode(),
        readings={"the table": table.robot},
        cannot_hold=losses(robot),
        notes=(*tool_note(robot), *_notes(table, convention, request.longest)),
    )


def _columns(table: Table) -> dict[str, Sequence[Any]]:
    """One line for the base, one for each joint, one for the tool."""
    rows, blank = table.robot.rows, [None]
    angles = {key: [plain(math.degrees(row.geometry[key])) for row in rows] for key in ("theta", "alpha")}
    lengths = {key: [plain(1e3 * row.geometry[key]) for row in rows] for key in ("d", "a")}
    frames: list[Sequence[float | None]] = [
        frame_numbers(table.robot.base),
        *([None] * 6 for _ in rows),
        frame_numbers(table.robot.tool),
    ]
    columns: dict[str, Sequence[Any]] = {
        "row": ["base", *(row.name for row in rows), "tool"],
        "joint": [*blank, *(row.joint for row in rows), *blank],
        "theta_offset [deg]": [*blank, *angles["theta"], *blank],
        "d [mm]": [*blank, *lengths["d"], *blank],
        "a [mm]": [*blank, *lengths["a"], *blank],
        "alpha [deg]": [*blank, *angles["alpha"], *blank],
    }
    return columns | dict(zip(FRAME_COLUMNS, zip(*frames, strict=True), strict=True))


def frame_numbers(frame: Frame) -> list[float]:
    """Translation [mm] and roll, pitch and yaw [deg] of a frame."""
    lengths = (1e3 * value for value in frame.translation.tolist())
    return [*map(plain, lengths), *(plain(math.degrees(angle)) for angle in frame.rpy or (0.0, 0.0, 0.0))]


def plain(value: float) -> float:
    """The value to as many places as are written; no minus before a zero."""
    return round(value, PLACES) + 0.0


def _notes(table: Table, convention: str, longest: float) -> Iterator[str]:
    yield (
        f"A row is {ORDERS[convention]}; the joint position, as the controller counts it, is added to theta (d of a "
        "prismatic joint). The line 'base' is from the robot's base to the table's first frame, 'tool' from its last "
        "frame to the tool: Tx Ty Tz Rz(yaw) Ry(pitch) Rx(roll)."
    )
    for (one, other), tilt in table.tilts.items():
        yield (
            f"Axes {one} and {other} are nearly parallel: their common normal is further than {longest:g} m away, so "
            f"their tilt of {1e3 * abs(tilt):.3g} mrad (Hayati's beta) is left out and the table is the nearest one "
            "without it (--longest takes normals that are further away, and holds the tilt)."
        )
    if table.tilts:
        mean, most = 1e3 * table.distance.mean(), 1e3 * table.distance.max()
        yield f"Of the rigid geometry alone that leaves {mean:.4f} mm mean and {most:.4f} mm at most."
