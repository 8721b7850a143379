"""Parameters: everything of a robot that a calibration can identify, by name."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from elastocal.elasticity import LAWS
from elastocal.robot import FRAME_KEYS, ROTATION_KEYS, Robot


class Group(IntEnum):
    """What kind of parameter it is. Of parameters that say the same, the one of the lowest group is kept."""

    BASE = 0
    TARGET = 1
    TOOL = 2
    OFFSET = 3
    LENGTH = 4
    TWIST = 5
    SPARE = 6
    COMPLIANCE = 7
    TRANSITION = 8
    MAP = 9


FRAME_GROUPS = (Group.BASE, Group.TARGET, Group.TOOL)


@dataclass(frozen=True)
class Parameter:
    """One number of a robot.

    Attributes:
        name: "2.alpha", "base.rz", "3.theta.c".
        unit: SI.
        nominal: its value in the robot; None for a frame with no first guess. Of a frame's rx, ry, rz the roll, pitch
            and yaw; of a URDF joint's origin rx, ry, rz and of its offset, zero: they are changes of the origin.
        group: what kind it is.
        open: identified unless the user says otherwise.
        power: of the load that a compliance belongs to.
    """

    name: str
    unit: str
    nominal: float | None
    group: Group
    open: bool
    power: int = 1


def parameters_of(robot: Robot) -> dict[str, Parameter]:
    """All parameters of a robot by name, in chain order, then compliances and transition torques, then joint maps."""
    found = [
        *_frame_parameters(robot, "base"),
        *(p for s in robot.stations for p in _frame_parameters(robot, f"station.{s}")),
    ]
    found += _row_parameters(robot)
    found += _frame_parameters(robot, "tool")
    found += [p for target in robot.targets for p in _frame_parameters(robot, f"target.{target}")]
    found += _compliance_parameters(robot)
    found += _map_parameters(robot)
    return {parameter.name: parameter for parameter in found}


def _frame_parameters(robot: Robot, prefix: str) -> list[Parameter]:
    frame = robot.frames[prefix]
    guessed = frame.xyz is not None or frame.rpy is not None or frame.known
    values = (*(frame.xyz or (0.0,) * 3), *(frame.rpy or (0.0,) * 3)) if guessed else (None,) * 6
    group = {"base": Group.BASE, "station": Group.BASE, "tool": Group.TOOL}.get(prefix.split(".")[0], Group.TARGET)
    return [
        Parameter(f"{prefix}.{key}", "m" if key[0] == "t" else "rad", value, group, not frame.known)
        for key, value in zip(FRAME_KEYS, values, strict=True)
    ]


_GROUPS = {
    **dict.fromkeys(("a", "d", "tx", "ty", "tz"), Group.LENGTH),
    **dict.fromkeys(("alpha", "beta", "rx", "ry", "rz"), Group.TWIST),
    **dict.fromkeys(("b", "theta"), Group.SPARE),
}


def _row_parameters(robot: Robot) -> list[Parameter]:
    found = []
    for row, elements in zip(robot.rows, robot.row_elements, strict=True):
        for element in elements:
            if element.name:
                group = Group.OFFSET if element.name == row.joint_element else _GROUPS[element.name.rpartition(".")[2]]
                value = element.value
                found.append(Parameter(element.name, "rad" if element.rotation else "m", value, group, True))
    return found


def _compliance_parameters(robot: Robot) -> list[Parameter]:
    found = []
    for name, compliance in robot.elastic.items():
        law = LAWS.get(compliance.law)
        if law is None:
            continue  # a curve that nobody identifies
        turn = name.rpartition(".")[2] in ROTATION_KEYS
        for coefficient, power, value in zip(law.coefficients, law.powers, compliance.coefficients, strict=True):
            unit = ("rad/(N·m)" if turn else "m/N") + (f"^{power}" if power > 1 else "")
            found.append(Parameter(f"{name}.{coefficient}", unit, value, Group.COMPLIANCE, False, power))
        if law.transition:
            torque, unit = compliance.transition_torque, "N·m" if turn else "N"
            found.append(Parameter(f"{name}.transition_torque", unit, torque, Group.TRANSITION, False))
    return found


def _map_parameters(robot: Robot) -> list[Parameter]:
    found = []
    for element, error in robot.transmission.items():
        unit = "rad" if element.rpartition(".")[2] in ROTATION_KEYS else "m"
        found += [Parameter(f"{element}.{n}", unit, value, Group.MAP, False) for n, value in error.coefficients.items()]
    return found
