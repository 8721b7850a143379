"""Files and commands for tests: small ones that are right, to be spoiled, and commands run in this process."""

from __future__ import annotations

import shlex
from contextlib import chdir, redirect_stderr, redirect_stdout
from dataclasses import dataclass, replace
from io import StringIO
from pathlib import Path

import numpy as np
import pytest

import elastocal as ec
from elastocal.cli.main import main
from elastocal.robot import Compliance, Robot
from support.robots import arm, placed

ROBOT = """\
format = "elastocal-robot/1"
name = "arm"
convention = "modified-dh"
length_unit = "m"
angle_unit = "rad"

[[row]]
name = "1"
d = 0.4
joint = "revolute"
limits = [-3.0, 3.0]

[[row]]
name = "elbow"
alpha = 1.5
a = 0.2
joint = "revolute"
mass = 5.0

[tool]
xyz = [0.0, 0.1, 0.0]

[load.heavy]
mass = 3.0

[station.north]
xyz = [1.0, 0.0, 0.0]
"""
"""A robot of two joints, one without limits, one target, a payload and a station."""

URDF = """\
<robot name="u">
<link name="base_link"/><link name="l1"/><link name="l2"/>
<joint name="j1" type="revolute"><parent link="base_link"/><child link="l1"/>
<axis xyz="0 0 1"/><limit lower="-3" upper="3"/></joint>
<joint name="j2" type="continuous"><parent link="l1"/><child link="l2"/>
<origin xyz="0.3 0 0.4" rpy="1.5 0 0"/><axis xyz="0 0 1"/></joint>
</robot>
"""
"""The same as a URDF."""

TABLE = """\
q1 [deg],q2 [deg],x [mm],y [mm],z [mm]
10,20,100,200,300
11,21,101,201,301
12,22,102,202,302
"""
"""Measurements of either."""

DESCRIPTOR = """\
format = "elastocal-measurements/1"
file = "tracker.csv"
delimiter = ";"
decimal = ","

[columns]
q = { columns = ["shoulder", "wrist"], unit = "deg" }
position = { columns = ["mx", "my", "mz"], unit = "mm" }
orientation = { columns = ["rx", "ry", "rz"], unit = "deg", convention = "euler-XYZ" }
"""

TRACKER = """\
shoulder;wrist;mx;my;mz;rx;ry;rz;std;probe
10,5;20;100,5;200;300;10;20;30;0,1;a
11,5;21;101,5;201;301;11;21;31;0,1;a
"""
"""An instrument's own file, and its description."""


def edited(text: str, *edits: tuple[str, str]) -> str:
    """The text with replacements, each of something that is there."""
    for old, new in edits:
        assert old in text, f"{old!r} is not in the text to be edited"
        text = text.replace(old, new, 1)
    return text


def contents(folder: Path) -> dict[str, bytes]:
    """Everything in a folder."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@dataclass(frozen=True)
class Ran:
    """What became of a command."""

    status: int
    out: str
    err: str


@dataclass(frozen=True)
class Desk:
    """A folder that commands run in, on a terminal of 80 columns."""

    folder: Path

    def write(self, **texts: str | bytes) -> None:
        """Write files; fit_csv is fit.csv."""
        for name, text in texts.items():
            path = self.folder / ".".join(name.rsplit("_", 1))
            path.write_bytes(text.encode() if isinstance(text, str) else text)

    def run(self, command: str) -> Ran:
        """Run a command line, as "validate robot.toml fit.csv"."""
        out, err = StringIO(), StringIO()
        with chdir(self.folder), pytest.MonkeyPatch.context() as patch, redirect_stdout(out), redirect_stderr(err):
            patch.setenv("COLUMNS", "80")
            status = main(shlex.split(command))
        return Ran(status, out.getvalue(), err.getvalue())

    def done(self, command: str, status: int = 0) -> str:
        """Run a command that must end with a status; what it prints."""
        ran = self.run(command)
        assert ran.status == status, ran.err
        return ran.out

    def refused(self, command: str) -> list[str]:
        """Run a command that must exit 2 with faults on standard error only and leave the folder as it was."""
        before = contents(self.folder)
        ran = self.run(command)
        assert ran.status == 2
        assert ran.out == ""
        assert "Traceback" not in ran.err
        assert contents(self.folder) == before
        return [line.removeprefix("elastocal: ") for line in ran.err.splitlines()]


@pytest.fixture
def desk(tmp_path: Path) -> Desk:
    """An empty folder to run commands in."""
    return Desk(tmp_path)


def flawed(robot: Robot, rng: np.random.Generator, size: float = 1e-3) -> Robot:
    """The robot as built: every number of its rows off by `size` [rad or m]."""
    names = [element.name for row in robot.row_elements for element in row if element.name]
    return robot.displaced({name: size * rng.standard_normal() for name in names})


def save_simulated(folder: Path, fit: int = 40, held_out: int = 40) -> Robot:
    """Write robot.toml, fit.csv and held_out.csv of an arm with two soft joints; returns the actual one."""
    nominal, rng = arm(), np.random.default_rng(0)
    elastic = {"2.theta": Compliance("linear", (2e-6,)), "3.theta": Compliance("linear", (4e-6,))}
    actual = replace(flawed(placed(nominal, rng), rng), elastic=elastic)
    q = ec.random_poses(actual, fit + held_out, 1)
    ec.save_robot(nominal, folder / "robot.toml")
    for name, rows, seed in (("fit.csv", q[:fit], 2), ("held_out.csv", q[fit:], 3)):
        ec.save_measurements(ec.simulate(actual, rows, noise=1e-5, seed=seed), nominal, folder / name)
    return actual
