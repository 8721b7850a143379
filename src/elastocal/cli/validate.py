"""The command `elastocal validate`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter
from cyclopts.validators import Number

from elastocal.cli.options import Globs, Json, Output, Seed, Tip, require_data
from elastocal.errors import InputError, unknown_name

if TYPE_CHECKING:
    from elastocal.identification import SavedResult
    from elastocal.measurements import Measurements

MAP_POSES = 1000
"""Poses of an uncertainty map over the workspace."""


def validate(
    robot: Path,
    /,
    *data: Path,
    refit: Globs | None = None,
    uncertainty_map: Annotated[bool, Parameter(negative=())] = False,
    poses: Annotated[int | None, Parameter(validator=Number(gte=1))] = None,
    station: str | None = None,
    target: str | None = None,
    load: str | None = None,
    seed: Seed = 0,
    tip: Tip = None,
    output: Output = None,
    json: Json = False,
) -> int:
    """Errors of a robot, nominal or calibrated, on measurements it was not fitted to.

    Frames that the robot file does not call known are fitted to these measurements first.

    Args:
        robot: Robot: a robot file (TOML), such as a calibration writes, or a URDF.
        data: Measurements: CSV, Parquet, or the TOML descriptor of an instrument's own file.
        refit: Frames to fit anew, as base or tool, where the instrument or the probe was moved since.
        uncertainty_map: Instead of errors, the standard deviation of the position that the robot predicts, from its
            parameters and from what its model leaves out: at the poses of the measurements, of which joint positions
            will do, or, without any, at random poses within the joint limits. The robot must be the robot.toml in the
            folder of its calibration.
        poses: How many random poses; 1000 if left out.
        station: Station of the instrument at random poses.
        target: Target whose position is predicted at random poses; the tool's origin if the robot has none.
        load: Payload that is carried at random poses.
        seed: Of the random poses.
        tip: Link where the chain of a URDF ends.
        output: CSV file for the residuals, or the standard deviations, of every row.
        json: Print the result object and nothing else on standard output.
    """
    from elastocal.cli.main import DONE
    from elastocal.cli.show import show
    from elastocal.io import (
        data_hashes,
        load_measurements,
        load_robot,
        require_writable,
        save_residuals,
        source_files,
        validation_json,
    )
    from elastocal.report import validation_sections
    from elastocal.validation import validate as validate_robot

    if uncertainty_map:
        if refit:
            raise InputError("--refit fits a frame to measurements, --uncertainty-map tells what is known: choose one")
        return _map(robot, data, (poses, station, target, load), seed, output, json)
    if (poses, station, target, load) != (None,) * 4:
        raise InputError("--poses, --station, --target and --load go with --uncertainty-map")
    require_data(data)
    given = load_robot(robot, tip)
    measured = load_measurements(data, given)
    inputs = (robot, *source_files(data))
    if output is not None:
        require_writable(output.parent, [output.name], inputs)
    result = validate_robot(given, measured, refit=refit or ())
    if output is not None:
        save_residuals(result, output, inputs)
        print(f"{output}", file=sys.stderr)
    if json:
        print(validation_json(result, data_hashes(data)))
    else:
        show(validation_sections(result))
    return DONE


Choice = tuple[int | None, str | None, str | None, str | None]
"""How many random poses, and the station, target and payload there."""


def _map(robot: Path, data: tuple[Path, ...], choice: Choice, seed: int, output: Path | None, json: bool) -> int:
    """The uncertainty of the predicted position."""
    from elastocal.cli.main import DONE
    from elastocal.cli.show import show
    from elastocal.io import (
        load_measurements,
        load_result,
        require_writable,
        save_uncertainty,
        source_files,
        uncertainty_json,
    )
    from elastocal.report import uncertainty_sections
    from elastocal.uncertainty import uncertainty_at

    if data and choice != (None,) * 4:
        raise InputError("--poses, --station, --target and --load are of random poses: leave the measurements out")
    inputs = (robot, robot.parent / "result.json", *source_files(data))
    if output is not None:
        require_writable(output.parent, [output.name], inputs)
    known = load_result(robot.parent, robot.name)
    at = load_measurements(data, known.robot, measured=False) if data else _random(known, choice, seed)
    found = uncertainty_at(known, at)
    if output is not None:
        save_uncertainty(found, output, inputs)
        print(f"{output}", file=sys.stderr)
    if json:
        print(uncertainty_json(known.robot, found))
    else:
        show(uncertainty_sections(known.robot, found))
    return DONE


def _random(known: SavedResult, choice: Choice, seed: int) -> Measurements:
    """Random poses within the joint limits, with what the robot measures there."""
    from elastocal.measurements import Labels, Measurements
    from elastocal.simulation import random_poses

    robot, (count, station, target, load) = known.robot, choice
    valid = {"station": robot.stations, "target": robot.targets, "load": robot.loads}
    given = {"station": station, "target": target, "load": load}
    faults = [
        f"--{kind}: {unknown_name(kind, name, valid[kind])}"
        for kind, name in given.items()
        if name is not None and name not in valid[kind]
    ]
    for kind in ("station", "target"):  # without one it is the base's frame, or the tool's, which nobody measured
        if given[kind] is None and len(valid[kind]) > 1:
            faults.append(f"--{kind}: expected one of {', '.join(valid[kind])}, found none")
    if faults:
        raise InputError(*faults)
    names = {kind: name or next(iter(valid[kind] if kind != "load" else ()), None) for kind, name in given.items()}
    q = random_poses(robot, count or MAP_POSES, seed)
    labels = {kind: Labels.same(name, len(q)) for kind, name in names.items()}
    return Measurements(q, station=labels["station"], target=labels["target"], load=labels["load"])
