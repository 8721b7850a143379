"""What `elastocal demo --full` plays: from a plan to corrected targets, each step a command that anybody can type."""

from __future__ import annotations

import json
import shlex
import sys
import textwrap
from collections.abc import Mapping
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import replace
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

from elastocal.errors import InputError

if TYPE_CHECKING:
    from elastocal.robot import Robot

ELASTIC = "2:hinge,3:hinge,4,5"

PLANNED, HELD_OUT, PROGRAM = 45, 200, 1000
"""Poses to fit, to hold out, and of the program that is corrected."""

WITHIN = 0.95
"""The program keeps to this part of the joints' ranges, so that there is room to correct it."""

SINGULAR = 0.04
"""The program keeps to poses whose smallest singular value [m, m/rad or 1] is larger: at a stretched elbow or wrist no
correction reaches every direction."""

WIDTH = 77
"""Of a command's line, without the backslash."""

GUESS = "[tool]\nxyz = [75.0, -45.0, 165.0]          # a first guess of where the target sits, to some 5 mm\n"

FILES = ("robot.toml", "actual.toml", "program.csv")
"""What there is to begin with: the nominal robot, the actual one, and a program of joint positions."""

MADE = ("plan.csv", "fit.csv", "held_out.csv", "corrected.csv", "found.csv", "nominal.toml", "before.csv", "after.csv")
"""What the steps make, beside the result's folder."""


def play(folder: Path, seed: int, as_json: bool) -> int:
    """Plan, measure, calibrate, compensate and measure again in a folder; shows the commands and what they say.

    Args:
        folder: that holds FILES.
        seed: of poses and noise.
        as_json: whether standard output gets one object with what each step says, and nothing else.

    Returns:
        The worst exit status of the steps.

    Raises:
        InputError: a step refuses its input.
    """
    at = {name.partition(".")[0]: str(folder / name) for name in (*FILES, *MADE)}
    result = str(folder / "result")
    simulate = ("simulate", at["robot"], "--actual", at["actual"], "--noise", "0.03mm")
    seeds = [str(seed + number) for number in range(1, 5)]
    steps = _Steps(as_json)
    steps.take(
        "Which poses to measure, if joints 2 and 3 may stiffen and 4 and 5 give way",
        ("plan", at["robot"], "--poses", str(PLANNED), "--elastic", ELASTIC, "--criterion", "accuracy"),
        ("--floor", "0mm", "-o", at["plan"]),
        key="plan",
    )
    steps.take("The tracker measures them", simulate, ("--at", at["plan"], "--seed", seeds[0], "-o", at["fit"]))
    steps.take(
        "and others, to judge by",
        simulate,
        ("--poses", str(HELD_OUT), "--floor", "0mm", "--seed", seeds[1], "-o", at["held_out"]),
    )
    steps.take(
        "Geometry, stiffness and transition torques together",
        ("calibrate", at["robot"], at["fit"], "--held-out", at["held_out"], "--elastic", ELASTIC, "-o", result),
        key="calibrate",
    )
    robot = f"{result}/robot.toml"
    steps.take(
        f"A program of {PROGRAM} poses, corrected",
        ("compensate", robot, at["program"], "-o", at["corrected"]),
        key="compensate",
    )
    steps.take(
        "The program as it was, measured", simulate, ("--at", at["program"], "--seed", seeds[2], "-o", at["before"])
    )
    steps.take("and corrected", simulate, ("--at", at["corrected"], "--seed", seeds[3], "-o", at["found"]))
    _write_as_programmed(folder)
    steps.say(
        f"{at['after']} holds these positions beside the joint positions of the program, and {at['nominal']} the robot "
        "that the program means, so that measured - predicted is the error."
    )
    steps.take("The error before", ("validate", at["nominal"], at["before"]), key="before")
    steps.take("The error after", ("validate", at["nominal"], at["after"]), key="after")
    steps.say(
        f"Both are measured with noise. The truth, since it is a simulation: {1e3 * _true_error(folder):.4f} mm on "
        "average after the correction."
    )
    steps.end(folder)
    return steps.status


class _Steps:
    """Commands one after the other: their lines and what they print are shown, or their result objects are kept."""

    def __init__(self, as_json: bool) -> None:
        self.as_json, self.status = as_json, 0
        self.objects: dict[str, Any] = {}

    def say(self, text: str) -> None:
        """A sentence between the steps, on standard error if standard output is for the object."""
        print(f"{text}\n", file=sys.stderr if self.as_json else sys.stdout, flush=True)

    def take(self, title: str, *words: tuple[str, ...], key: str = "") -> None:
        """One step; `key` is its name in the object, if it has a result object.

        Raises:
            InputError: the command refuses its input, so that the steps after it have none.
        """
        from elastocal.cli.main import BAD_INPUT, main

        arguments = [word for some in words for word in some]
        self.say(f"# {title}\n{_wrapped(f'$ elastocal {shlex.join(arguments)}')}")
        heard = StringIO()
        if self.as_json:
            with redirect_stdout(heard):
                status = main([*arguments, "--json"] if key else arguments)
        else:
            with redirect_stderr(heard):  # it names the files that the line above names
                status = main(arguments)
        if status == BAD_INPUT:
            said = [] if self.as_json else heard.getvalue().splitlines()
            raise InputError(*(line.removeprefix("elastocal: ") for line in said), f"the demo ends here: {title}")
        self.status = max(self.status, status)
        if self.as_json and key:
            self.objects[key] = json.loads(heard.getvalue())

    def end(self, folder: Path) -> None:
        """Where to look, or the object."""
        if self.as_json:
            print(json.dumps({"format": "elastocal-demo/1", **self.objects}, indent=1, ensure_ascii=False))
        else:
            print(f"Look at {folder / 'result' / 'report.html'}. Your own robot: elastocal new my-robot")


def _wrapped(command: str) -> str:
    """A command line over several lines of a terminal, as a shell takes it."""
    return " \\\n".join(textwrap.wrap(command, WIDTH, subsequent_indent="    ", break_on_hyphens=False))


def contents(seed: int) -> dict[str, str | bytes]:
    """The files that there are to begin with."""
    import numpy as np

    from elastocal.examples import ROBOT_FILE, stiffening_arm
    from elastocal.io import load_robot, robot_to_toml
    from elastocal.io.results import csv_bytes
    from elastocal.prediction.driving import Driver
    from elastocal.simulation import Region, random_poses

    nominal = load_robot(ROBOT_FILE)
    actual = stiffening_arm(nominal, seed)
    region = Region(floor=0.0)
    q = random_poses(_within(nominal), 2 * PROGRAM, np.random.default_rng(seed), region=region, actual=actual)
    moved = Driver.of(actual).at(q.T).jacobian.transpose(2, 0, 1)
    q = q[np.linalg.svd(moved, compute_uv=False)[:, -1] > SINGULAR][:PROGRAM]
    file = "".join(line for line in ROBOT_FILE.read_text().splitlines(keepends=True) if not line.startswith("[tool]"))
    first, mass, rest = file.partition("mass = 10.0\n")
    program: Mapping[str, Any] = {f"q{i + 1}": joint for i, joint in enumerate(q.T)}
    return dict(zip(FILES, (first + GUESS + mass + rest, robot_to_toml(actual), csv_bytes(program)), strict=True))


def _within(robot: Robot) -> Robot:
    """The robot with a part of its joints' ranges."""
    rows = []
    for row in robot.rows:
        if row.limits is not None:
            middle, half = 0.5 * (row.limits[0] + row.limits[1]), 0.5 * WITHIN * (row.limits[1] - row.limits[0])
            row = replace(row, limits=(middle - half, middle + half))
        rows.append(row)
    return replace(robot, rows=tuple(rows))


def _true_error(folder: Path) -> float:
    """Mean distance of the actual robot at the corrected program from where the program means it to be [m]."""
    import numpy as np

    from elastocal.io import load_measurements, load_robot
    from elastocal.prediction import predict

    actual, nominal = load_robot(folder / "actual.toml"), load_robot(folder / "nominal.toml")
    program, corrected = (
        load_measurements(folder / name, nominal, measured=False).q for name in ("program.csv", "corrected.csv")
    )
    meant = predict(nominal, program)[0]
    return float(np.linalg.norm(predict(actual, corrected)[0] - meant, axis=1).mean())


def _write_as_programmed(folder: Path) -> None:
    """What the corrected program reaches, beside the program's own joint positions; and the robot that it means."""
    from elastocal.conversion import nominal_geometry, rigid
    from elastocal.io import load_measurements, load_result, measurements_to_csv, robot_to_toml, write_files

    saved = load_result(folder / "result")
    program = load_measurements(folder / "program.csv", saved.robot, measured=False)
    found = load_measurements(folder / "found.csv", saved.robot)
    after = replace(found, q=program.q)
    files: dict[str, str | bytes] = {
        "nominal.toml": robot_to_toml(rigid(nominal_geometry(saved.robot, saved.parameters))),
        "after.csv": measurements_to_csv(after, saved.robot),
    }
    write_files(folder, files)
