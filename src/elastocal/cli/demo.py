"""The command `elastocal demo`."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from elastocal.cli.options import Json, Output, Seed
from elastocal.errors import InputError


def demo(
    *,
    full: Annotated[bool, Parameter(negative=())] = False,
    output: Output = None,
    seed: Seed = 0,
    json: Json = False,
) -> int:
    """The whole way on a built-in example, in a few seconds and with nothing to download.

    A simulated arm, whose lengths and angles are a little off and whose joints give way under load, is measured by a
    simulated laser tracker; then it is calibrated, and judged on poses that the calibration has not seen.

    Args:
        full: All the way: which poses to measure, calibration of joints that stiffen under load, a program of poses
            corrected, and measured again.
        output: Folder for the robot file, the measurements and the result; elastocal-demo, or the next free name, if
            left out.
        seed: Of the arm's errors, the poses and the noise.
        json: Print the result object and nothing else on standard output.
    """
    if full:
        return full_demo(output or free_folder(Path("elastocal-demo")), seed, json)
    from elastocal.cli.calibrate import calibrate
    from elastocal.cli.show import show
    from elastocal.examples import COMPLIANCE, ROBOT_FILE, actual_arm, measure
    from elastocal.io import load_robot, measurements_to_csv, write_files
    from elastocal.report import Section

    folder = output or free_folder(Path("elastocal-demo"))
    nominal = load_robot(ROBOT_FILE)
    actual = actual_arm(nominal, seed)
    files = {
        "robot.toml": ROBOT_FILE.read_bytes(),
        "fit.csv": measurements_to_csv(measure(actual, 60, seed + 1), nominal),
        "held_out.csv": measurements_to_csv(measure(actual, 200, seed + 2), nominal),
    }
    require_new(folder, files, ROBOT_FILE.read_bytes())
    write_files(folder, files)
    robot, fit, held_out = (folder / name for name in files)
    elastic = ",".join(name.partition(".")[0] for name in COMPLIANCE)
    result = folder / "result"
    say = sys.stderr if json else sys.stdout
    print(
        f"A simulated arm, measured at 60 poses to fit and 200 to hold out, noise 0.03 mm per axis: {folder}\n"
        f"What follows is the output of\n\n"
        f"elastocal calibrate {robot} {fit} \\\n  --held-out {held_out} --elastic {elastic} -o {result}\n",
        file=say,
    )
    status = calibrate(robot, fit, held_out=[held_out], elastic=elastic, output=result, json=json)
    if not json:
        found = load_robot(result / "robot.toml")
        rows = [
            (name, f"{1e6 * true:.2f}", f"{1e6 * found.elastic[name].coefficients[0]:.2f}")
            for name, true in COMPLIANCE.items()
        ]
        show(
            [
                Section(
                    "The truth, since it is a simulation",
                    ("compliance [µrad/(N·m)]", "true", "identified"),
                    tuple(rows),
                )
            ]
        )
        print(f"Look at {result}, change {robot}, or measure your own robot: elastocal new my-robot")
    return status


def full_demo(folder: Path, seed: int, json: bool) -> int:
    """The whole way, from a plan to corrected targets.

    Raises:
        InputError: the folder holds other files.
    """
    from elastocal.cli.full_demo import FILES, MADE, contents, play
    from elastocal.io import write_files

    files = contents(seed)
    require_new(folder, (*FILES, *MADE), str(files["robot.toml"]).encode())
    write_files(folder, files)
    say = sys.stderr if json else sys.stdout
    print(f"A simulated arm whose joints stiffen under load, and a program of poses for it: {folder}\n", file=say)
    return play(folder, seed, json)


def require_new(folder: Path, names: Iterable[str], robot_file: bytes) -> None:
    """Check that a folder holds none of the demo's files, or those of an earlier demo.

    Raises:
        InputError: it holds others.
    """
    there = [folder / name for name in names if (folder / name).exists()]
    robot = folder / "robot.toml"
    earlier = robot.is_file() and robot.read_bytes() == robot_file
    if there and not earlier:
        raise InputError(*(f"{path} is there already, and not of a demo: choose another folder (-o)" for path in there))


def free_folder(wanted: Path) -> Path:
    """The folder wanted, or with the first number that makes it a new one."""
    number, folder = 1, wanted
    while folder.exists():
        number += 1
        folder = wanted.with_name(f"{wanted.name}-{number}")
    return folder
