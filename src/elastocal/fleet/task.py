"""One row of a fleet: all that a worker needs of it, and what becomes of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from elastocal.errors import ElastocalError
from elastocal.identification import SavedResult, calibrate
from elastocal.identification.threads import one_thread
from elastocal.io import load_measurements, load_robot, save_result
from elastocal.io.manifests import FleetRow
from elastocal.measurements import Measurements
from elastocal.robot import Robot

FAILED = "failed"
"""Status of a row that led to no result."""


@dataclass(frozen=True)
class FleetOutcome:
    """What became of a row.

    Attributes:
        status: of the calibration; "failed" if there is none.
        reason: why it failed.
        kept: whether the result is that of an earlier run on the same inputs.
    """

    row: FleetRow
    status: str
    reason: str = ""
    kept: bool = False
    result: SavedResult | None = None


@dataclass(frozen=True)
class FleetTask:
    """A row with its files read, so that workers need none.

    Attributes:
        index: of the row, from 0.
        files: names of its files, for the settings of the result.
        hashes: of its measurement files.
    """

    index: int
    robot: Robot
    data: Measurements
    held_out: Measurements | None
    options: Mapping[str, Any]
    files: Mapping[str, object]
    hashes: tuple[str, ...]


@dataclass(frozen=True)
class FleetFiles:
    """What a worker makes of a row.

    Attributes:
        index: of the row.
        contents: of the files of its result; none if it failed.
        reason: why it failed.
    """

    index: int
    contents: Mapping[str, bytes]
    reason: str = ""


def prepared(index: int, row: FleetRow, hashes: tuple[str, ...]) -> FleetTask:
    """A row with its files read.

    Raises:
        InputError: with every fault of a file.
    """
    robot = load_robot(row.robot, row.tip)
    data = load_measurements(row.data, robot)
    held_out = load_measurements(row.held_out, robot) if row.held_out else None
    files = {"robot": str(row.robot), "data": [*map(str, row.data)], "held_out": [*map(str, row.held_out)]}
    return FleetTask(index, robot, data, held_out, row.options, files, hashes)


@one_thread
def calibrated(task: FleetTask) -> FleetFiles:
    """In a worker: the files of a row's result, or why there are none. Nothing that goes wrong stops other rows."""
    try:
        result = calibrate(task.robot, task.data, held_out=task.held_out, **task.options)
        result = replace(result, settings={**task.files, **result.settings})
        with TemporaryDirectory() as folder:
            names = save_result(result, folder, task.hashes)
            return FleetFiles(task.index, {name: (Path(folder) / name).read_bytes() for name in names})
    except ElastocalError as error:
        return FleetFiles(task.index, {}, str(error))
    except Exception as error:  # of numbers that nobody has thought of, for one
        return FleetFiles(task.index, {}, f"{type(error).__name__}: {error}")
