"""Results in: the folder that a calibration wrote, checked against its robot."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from elastocal.chain import Array
from elastocal.errors import InputError
from elastocal.identification import IdentifiedParameter, SavedResult
from elastocal.io.files import read_text
from elastocal.io.robot_toml import read_robot_toml
from elastocal.parameters import parameters_of
from elastocal.robot import Robot

FORMAT = "elastocal-result/1"

SAME = 1e-9
"""Values of the robot file and of the result that agree to this are the same [rad or m, relative if larger]."""


def load_result(folder: str | Path, robot_file: str = "robot.toml") -> SavedResult:
    """Read what `calibrate -o DIR` or save_result wrote.

    Args:
        folder: with result.json and the identified robot.
        robot_file: the robot's file in it.

    Raises:
        InputError: the folder is not one that a calibration wrote, or its files do not belong together.
    """
    folder = Path(folder)
    if folder.is_file():
        raise InputError(f"{folder}: expected the folder of a calibration (calibrate -o DIR), found a file")
    if not (folder / "result.json").is_file():
        raise InputError(f"{folder}: not the folder of a calibration (calibrate -o DIR): there is no result.json")
    path, robot = folder / "result.json", read_robot_toml(folder / robot_file)
    values = _read(path)
    names, covariance = tuple(values["covariance"]["names"]), np.array(values["covariance"]["matrix"], dtype=float)
    parameters = tuple(map(_parameter, values["parameters"]))
    faults = list(_faults(robot, parameters, names, covariance))
    if faults:
        raise InputError(*(f"{path} does not belong to {folder / robot_file}: {fault}" for fault in faults))
    sigma = {kind: float(found) for kind, found in values["model_sigma"].items() if found is not None}
    return SavedResult(robot, values["status"], parameters, names, covariance, sigma, float(values["freedom"]))


def _read(path: Path) -> Mapping[str, Any]:
    """A result object with all that is needed of it."""
    try:
        values = json.loads(read_text(path))
    except json.JSONDecodeError as error:
        raise InputError(f"{path}: not valid JSON: {error}") from None
    found = values.get("format") if isinstance(values, dict) else None
    if found != FORMAT:
        raise InputError(f"{path}: format: expected {FORMAT!r}, found {found!r}")
    missing = [key for key in ("covariance", "parameters", "model_sigma", "freedom", "status") if key not in values]
    if missing:
        raise InputError(f"{path}: {', '.join(missing)} missing: calibrate anew to write it with them")
    return values


def _parameter(row: Mapping[str, Any]) -> IdentifiedParameter:
    low, high = row.get("interval") or (None, None)
    interval = None if low is None else (float(low), math.inf if high is None else float(high))
    values = {key: row[key] for key in ("name", "unit", "nominal", "identified", "std", "verdict")}
    return IdentifiedParameter(**values, reason=row.get("reason", ""), interval=interval)


def _faults(
    robot: Robot, parameters: tuple[IdentifiedParameter, ...], names: tuple[str, ...], covariance: Array
) -> Iterator[str]:
    """Why a result cannot be that of a robot."""
    if covariance.shape != (len(names), len(names)):
        yield f"covariance: expected {len(names)} rows and columns, found {' x '.join(map(str, covariance.shape))}"
    unknown = [name for name in names if not _has(robot, name)]
    if unknown:
        yield f"{robot.name} has no parameter {', '.join(unknown[:6])}{' …' if len(unknown) > 6 else ''}"
    if robot.convention == "urdf":
        return  # parameters are changes of origins there, which the robot file does not tell apart from origins
    there = parameters_of(robot)
    for p in parameters:
        value = there[p.name].nominal if p.name in there else None
        if value is not None and abs(value - p.identified) > SAME * max(1.0, abs(value)):
            yield f"{p.name} is {value:.10g} in the robot file and {p.identified:.10g} in the result"
            return


def _has(robot: Robot, name: str) -> bool:
    try:
        robot.displaced({name: 0.0})
    except KeyError:
        return False
    return True
