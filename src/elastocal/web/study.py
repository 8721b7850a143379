"""What can be said of robot and measurements before any calibration: plausible or not, and what bends visibly."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from elastocal.chain import Array
from elastocal.errors import ElastocalError, InputError
from elastocal.identification import choose_gauge, fit_frames, residuals
from elastocal.identification.plausibility import require_plausible
from elastocal.identification.request import requested, with_laws
from elastocal.measurements import Measurements
from elastocal.robot import Robot
from elastocal.web.faults import Fault, fault_of

SOFT = {"revolute": (1e-5, "10 µrad/(N·m)"), "prismatic": (1e-8, "10 nm/N")}
"""An ordinary compliance by kind of joint, at which its effect is told."""

WORTH = 1e-5
"""A joint whose effect is smaller [m] than what an instrument resolves is suggested to be rigid."""

SHARE, FEWEST = 0.3, 100
"""Fraction of the rows that is held out unless the user says otherwise, from so many rows on."""


@dataclass(frozen=True)
class Joint:
    """A joint, and whether the measurements can show that it gives way.

    Attributes:
        effect: how far it moves the target at an ordinary compliance, rms at generic poses [m]; None where it cannot
            be told.
        at: that compliance.
        why: the reason where it cannot.
    """

    name: str
    effect: float | None
    at: str
    why: str = ""

    @property
    def worth(self) -> bool:
        """Whether it is suggested to identify its compliance."""
        return self.effect is not None and self.effect >= WORTH


@dataclass(frozen=True)
class Study:
    """What is known before a calibration.

    Attributes:
        joints: of the robot.
        faults: of the data as a whole.
        aligned: the nominal robot where it stands; None where it cannot be told.
        errors: (n,) distances of the nominal robot, aligned, from the measured points [m].
    """

    joints: tuple[Joint, ...]
    faults: tuple[Fault, ...] = ()
    aligned: Robot | None = None
    errors: Array | None = None

    @property
    def loaded(self) -> bool:
        """Whether any joint's compliance can be told."""
        return any(joint.effect is not None for joint in self.joints)


def study(robot: Robot, data: Measurements) -> Study:
    """What can be said of a robot and what was measured of it."""
    laws = {row.name: "linear" for row in robot.joints}
    try:
        wished, springs = with_laws(robot, laws)
        gauge = choose_gauge(wished, data, requested(wished, springs))
    except ElastocalError as error:
        return Study((), (Fault("", str(error)),))
    joints = []
    for row in robot.joints:
        size, at = SOFT[row.joint or "revolute"]
        name = f"{row.joint_element}.c"
        effect = gauge.effects.get(name)
        why = gauge.dropped[name].reason if name in gauge.dropped else ""
        joints.append(Joint(row.name, None if effect is None else size * effect, at, why))
    try:
        aligned = fit_frames(wished, data, gauge)
        require_plausible(wished, aligned, data)
        errors = residuals(aligned, data)
    except InputError as error:
        return Study(tuple(joints), tuple(fault_of(fault, Path()) for fault in error.faults))
    except (ElastocalError, np.linalg.LinAlgError) as error:
        return Study(tuple(joints), (Fault("", str(error)),))
    return Study(tuple(joints), (), aligned, errors.norms)


def usual_holdout(rows: int, held_out: int) -> float:
    """The fraction of rows to hold out unless the user says otherwise: none of few rows, or beside held-out files."""
    return SHARE if rows >= FEWEST and not held_out else 0.0
