"""The command `elastocal validate`."""

from __future__ import annotations

import sys
from pathlib import Path

from elastocal.cli.options import Globs, Json, Output, Tip, require_data


def validate(
    robot: Path,
    /,
    *data: Path,
    refit: Globs | None = None,
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
        tip: Link where the chain of a URDF ends.
        output: CSV file for the residuals of every row.
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
