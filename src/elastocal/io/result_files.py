"""Results in: the folder that a calibration wrote, checked against its robot."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from elastocal.chain import Array
from elastocal.errors import InputError
from elastocal.identification import IdentifiedParameter, RowErrors, SavedResult
from elastocal.io.covariances import covariance_from
from elastocal.io.files import read_text
from elastocal.io.residual_files import load_residuals, read_residuals
from elastocal.io.result_parts import (
    element_from,
    maps_from,
    observability_from,
    outlier_from,
    parameter_from,
    search_from,
    statistics_from,
)
from elastocal.io.robot_toml import read_robot_toml
from elastocal.parameters import parameters_of
from elastocal.robot import Robot

FORMAT = "elastocal-result/1"

SAME = 1e-9
"""Values of the robot file and of the result that agree to this are the same [rad or m, relative if larger]."""


def load_result(folder: str | Path, robot_file: str = "robot.toml", *, rows: bool = True) -> SavedResult:
    """Read what `calibrate -o DIR` or save_result wrote.

    Args:
        folder: with result.json and the identified robot.
        robot_file: the robot's file in it.
        rows: whether to read residuals.csv too, if it is there.

    Raises:
        InputError: the folder is not one that a calibration wrote, or its files do not belong together.
    """
    folder = Path(folder)
    if folder.is_file():
        raise InputError(f"{folder}: expected the folder of a calibration (calibrate -o DIR), found a file")
    path = folder / "result.json"
    if not path.is_file():
        raise InputError(f"{folder}: not the folder of a calibration (calibrate -o DIR): there is no result.json")
    robot = read_robot_toml(folder / robot_file)
    values = _read(read_text(path), path)
    errors = load_residuals(folder / "residuals.csv", robot.positions) if rows else None
    return _result(robot, values, errors, path, folder / robot_file)


def saved_result(robot: Robot, text: str, residuals: bytes) -> SavedResult:
    """The result that files would be read as: the robot, the text of result.json and the content of residuals.csv."""
    path = Path("result.json")
    errors = read_residuals(residuals, robot.positions, "residuals.csv")
    return _result(robot, _read(text, path), errors, path, Path("robot.toml"))


def _read(text: str, path: Path) -> Mapping[str, Any]:
    """A result object with all that is needed of it."""
    try:
        values = json.loads(text)
    except json.JSONDecodeError as error:
        raise InputError(f"{path}: not valid JSON: {error}") from None
    found = values.get("format") if isinstance(values, dict) else None
    if found != FORMAT:
        raise InputError(f"{path}: format: expected {FORMAT!r}, found {found!r}")
    missing = [key for key in ("covariance", "parameters", "model_sigma", "freedom", "status") if key not in values]
    if missing:
        raise InputError(f"{path}: {', '.join(missing)} missing: calibrate anew to write it with them")
    return values


def _result(
    robot: Robot, values: Mapping[str, Any], errors: RowErrors | None, path: Path, robot_path: Path
) -> SavedResult:
    names, parameters = tuple(values["covariance"]["names"]), tuple(map(parameter_from, values["parameters"]))
    try:
        covariance = covariance_from(values["covariance"])
    except ValueError as error:
        raise InputError(f"{path}: covariance: {error}") from None
    faults = list(_faults(robot, parameters, names, covariance))
    if faults:
        raise InputError(*(f"{path} does not belong to {robot_path}: {fault}" for fault in faults))
    found, search, maps = values.get("observability"), values.get("search"), values.get("transmission")
    chi2 = values.get("chi2_reduced")
    return SavedResult(
        robot=robot,
        status=values["status"],
        parameters=parameters,
        names=names,
        covariance=covariance,
        model_sigma={kind: float(sigma) for kind, sigma in values["model_sigma"].items() if sigma is not None},
        freedom=float(values["freedom"]),
        elastic=tuple(element_from(row, parameters) for row in values.get("elastic", ())),
        residuals={name: statistics_from(table) for name, table in values.get("residuals", {}).items()},
        observability=None if found is None else observability_from(found),
        outliers=tuple(map(outlier_from, values.get("outliers", ()))),
        search=None if search is None else search_from(search),
        maps=None if maps is None else maps_from(maps),
        tolerances=values.get("tolerance", {}),
        chi2_reduced=float("nan") if chi2 is None else float(chi2),
        errors=errors,
        correlated=tuple(tuple(group) for group in values.get("correlated", ())),
        bootstrap=values.get("bootstrap"),
        iterations=values.get("iterations", 0),
        seconds=values.get("seconds", 0.0),
        settings=values.get("settings", {}),
        verdict=values.get("verdict", ""),
        warnings=tuple(values.get("warnings", ())),
        notes=tuple(values.get("notes", ())),
        data_sha256=tuple(values.get("data_sha256", ())),
        version=values.get("version", ""),
    )


def _faults(
    robot: Robot, parameters: tuple[IdentifiedParameter, ...], names: tuple[str, ...], covariance: Array
) -> Iterator[str]:
    """Why a result cannot be that of a robot."""
    if covariance.shape != (len(names), len(names)):
        yield f"covariance: expected {len(names)} rows and columns, found {' x '.join(map(str, covariance.shape))}"
    unknown = [] if _has(robot, names) else [name for name in names if not _has(robot, (name,))]
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


def _has(robot: Robot, names: Iterable[str]) -> bool:
    try:
        robot.displaced(dict.fromkeys(names, 0.0))
    except KeyError:
        return False
    return True
