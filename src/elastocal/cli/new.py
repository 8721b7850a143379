"""The command `elastocal new`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from elastocal.cli.options import Tip


def new(
    folder: Path,
    /,
    *,
    joints: int = 6,
    convention: Literal["modified-dh", "standard-dh"] = "modified-dh",
    orientation: Annotated[bool, Parameter(negative=())] = False,
    urdf: Path | None = None,
    tip: Tip = None,
) -> int:
    """A commented robot file and an empty measurement table to fill in.

    Args:
        folder: Where robot.toml and measurements.csv are written; neither may be there yet.
        joints: How many joints the robot has.
        convention: Of the Denavit-Hartenberg table.
        orientation: Whether the instrument measures orientations too.
        urdf: Take the robot from a URDF instead of an empty table.
        tip: Link where the chain of the URDF ends.
    """
    from elastocal.errors import InputError
    from elastocal.io import load_robot, write_files
    from elastocal.io.templates import empty_table, robot_template, urdf_template

    if not 1 <= joints <= 30:
        raise InputError(f"--joints {joints}: expected 1 to 30")
    if tip is not None and urdf is None:
        raise InputError("--tip goes with --urdf")
    if urdf is not None:
        robot = load_robot(urdf, tip)
        text, slides = urdf_template(robot), [row.joint == "prismatic" for row in robot.joints]
    else:
        text, slides = robot_template(folder.resolve().name, joints, convention), [False] * joints
    files = {"robot.toml": text, "measurements.csv": empty_table(slides, orientation)}
    there = [str(folder / name) for name in files if (folder / name).exists()]
    if there:
        raise InputError(*(f"{path} is there already: choose another folder" for path in there))
    write_files(folder, files)
    print(
        f"{folder / 'robot.toml'}: fill in the Denavit-Hartenberg table, masses and limits\n"
        f"{folder / 'measurements.csv'}: one row per measured pose\n"
        f"then: elastocal calibrate {folder / 'robot.toml'} {folder / 'measurements.csv'} -o {folder / 'result'}"
    )
    return 0
