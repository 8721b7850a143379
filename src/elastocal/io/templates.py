"""Files to fill in: a commented robot file and an empty measurement table."""

from __future__ import annotations

from collections.abc import Sequence

import tomli_w

from elastocal.io.robot_toml import robot_to_toml
from elastocal.robot import Robot

_ORDER = {
    "modified-dh": "Rx(alpha) Tx(a) Ry(beta) Ty(b) Rz(theta) Tz(d)",
    "standard-dh": "Rz(theta) Tz(d) Tx(a) Rx(alpha) Ry(beta) Ty(b)",
}

_HEAD = """\
# A robot file. What is left out is 0; a line that starts with # is a comment.
format = "elastocal-robot/1"
name = {name}
convention = "{convention}"        # each row: {order}
length_unit = "mm"                  # "m" or "mm", for every length in this file
angle_unit = "deg"                  # "rad" or "deg"
gravity = [0.0, 0.0, -9.81]         # m/s², in the base frame: a robot that hangs has [0.0, 0.0, 9.81]
"""

_FIRST_ROW = """
[[row]]
name = "1"                          # its parameters are "1.alpha", "1.a", "1.beta", "1.b", "1.theta", "1.d"
alpha = 0.0
a = 0.0
theta = 0.0                         # joint offset of a revolute joint
d = 0.0
joint = "revolute"                  # or "prismatic"; left out: a fixed row
# sign = -1                         # where the controller counts the other way
limits = [-180.0, 180.0]
mass = 0.0                          # kg, of the link that moves with this row; needed for --elastic
com = [0.0, 0.0, 0.0]               # its centre of mass, in the frame after this row
# stiffness = 1.0e5                 # N·m/rad, only where it is known
"""

_ROW = """
[[row]]
name = "{name}"
alpha = 0.0
a = 0.0
theta = 0.0
d = 0.0
joint = "revolute"
limits = [-180.0, 180.0]
mass = 0.0
com = [0.0, 0.0, 0.0]
"""

_TAIL = """
# [base]                            # instrument_T_base: where the robot stands, seen from the instrument
# xyz = [0.0, 0.0, 0.0]             # left out, it is identified, from no first guess
# rpy = [0.0, 0.0, 0.0]             # extrinsic x, y, z
# known = true                      # take it as it is

[tool]                              # flange_T_tool; what is measured sits at its origin
# xyz = [0.0, 0.0, 120.0]           # left out, it is identified, from no first guess
mass = 0.0                          # kg
com = [0.0, 0.0, 0.0]               # in the flange frame

# [target.nest1]                    # several measured points: name them here and in the measurements' column "target"
# xyz = [50.0, 0.0, 0.0]            # in the tool frame
# [load.heavy]                      # payloads that the measurements' column "load" may name
# mass = 20.0
# com = [0.0, 0.0, 100.0]           # in the flange frame
"""


def robot_template(name: str, joints: int, convention: str) -> str:
    """A robot file to fill in."""
    head = _HEAD.format(name=_quoted(name), convention=convention, order=_ORDER[convention])
    return head + _FIRST_ROW + "".join(_ROW.format(name=i) for i in range(2, joints + 1)) + _TAIL


def _quoted(text: str) -> str:
    return tomli_w.dumps({"name": text}).partition("= ")[2].strip()


def urdf_template(robot: Robot) -> str:
    """A robot file of a URDF's chain, with the tool to fill in."""
    return "# A URDF's chain as a robot file; fill in [tool].\n" + robot_to_toml(robot)


def empty_table(slides: Sequence[bool], orientation: bool) -> str:
    """The header of a measurement table: joints, position and, if measured, orientation."""
    joints = [f"q{i} [{'mm' if sliding else 'deg'}]" for i, sliding in enumerate(slides, start=1)]
    return ",".join([*joints, "x [mm]", "y [mm]", "z [mm]", *(["qw", "qx", "qy", "qz"] if orientation else [])]) + "\n"
