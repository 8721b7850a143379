"""The command `elastocal export`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from elastocal.cli.options import Json, Output, Seed, Tip, parse_quantities
from elastocal.errors import InputError, unknown_name

if TYPE_CHECKING:
    from elastocal.report import Section
    from elastocal.robot import Robot


def export(
    robot: Path,
    /,
    *,
    to: str,
    nominal: Path | None = None,
    longest: str | None = None,
    tip: Tip = None,
    seed: Seed = 0,
    output: Output = None,
    json: Json = False,
) -> int:
    """The identified robot for other software, with what the format cannot hold and the residual that this leaves.

    Args:
        robot: Robot: a robot file (TOML), such as a calibration writes, or a URDF.
        to: Format: urdf, dh-csv, mdh-csv (modified, Craig), ur-yaml (Universal Robots' ROS packages) or corrections-csv
            (what changed in each joint, for controllers).
        nominal: Robot as the controller has it, for corrections-csv; without it the result.json beside ROBOT tells.
        longest: How far away along an axis a common normal of a DH table may lie, as 1000m; beyond, the two axes count
            as parallel; 10 m if left out.
        tip: Link where the chain of a URDF ends.
        seed: Of the random poses at which the residual is computed.
        output: File to write; without it the robot goes to standard output and what is said of it to standard error.
        json: Print the result object and nothing else on standard output.
    """
    from elastocal.cli.main import DONE
    from elastocal.conversion import LONGEST
    from elastocal.io import EXPORTS, export_json, export_robot, load_robot, require_writable, save_export
    from elastocal.report import export_sections

    if to not in EXPORTS:
        raise InputError(f"--to: {unknown_name('format', to, EXPORTS)}")
    if nominal is not None and to != "corrections-csv":
        raise InputError("--nominal goes with --to corrections-csv: the other formats hold the robot itself")
    if longest is not None and to not in ("dh-csv", "mdh-csv"):
        raise InputError("--longest goes with --to dh-csv and mdh-csv: the other formats have no common normals")
    reach = LONGEST if longest is None else parse_quantities("--longest", longest, ["length"])[0]
    given = load_robot(robot, tip)
    inputs = [robot, *([nominal] if nominal else [robot.parent / "result.json"])]
    if output is not None:
        require_writable(output.parent, [output.name], inputs)
    before = _nominal(robot, given, nominal) if to == "corrections-csv" else None
    exported = export_robot(given, to, nominal=before, longest=reach, seed=seed)
    if output is not None:
        save_export(exported, output, inputs)
        print(f"{output}", file=sys.stderr)
    if json:
        print(export_json(exported, output))
        return DONE
    if output is None:
        sys.stdout.write(exported.text)
    _show(export_sections(exported), aside=output is None)
    return DONE


def _nominal(path: Path, given: Robot, nominal: Path | None) -> Robot | None:
    """The robot as the controller has it, from its file or from the calibration."""
    from elastocal.io import load_robot, nominal_of

    return nominal_of(path, given) if nominal is None else load_robot(nominal)


def _show(sections: list[Section], aside: bool) -> None:
    """Print sections; aside, on standard error, where standard output has the robot."""
    from rich.console import Console

    from elastocal.cli.show import show
    from elastocal.report import print_sections

    if aside:
        print_sections(sections, Console(stderr=True, highlight=False))
    else:
        show(sections)
