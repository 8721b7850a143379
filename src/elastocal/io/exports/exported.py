"""What an export is: a text, what a reader of it has, and what it leaves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from elastocal.chain import Array
from elastocal.conversion import LONGEST, Residual
from elastocal.robot import Robot


@dataclass(frozen=True)
class Request:
    """What is to be exported.

    Attributes:
        robot: identified.
        nominal: as the controller has it; None where it is not known.
        q: (poses, joints) joint positions at which a format may fit what it cannot hold exactly [rad or m].
        longest: how far away a common normal of a table may lie [m].
    """

    robot: Robot
    nominal: Robot | None
    q: Array
    longest: float = LONGEST


@dataclass(frozen=True)
class Draft:
    """A robot in some format.

    Attributes:
        text: the file's.
        readings: the robots that a reader has, by what of the file is used; `base` of each is from the robot's base to
            its first frame.
        cannot_hold: what of this robot the format has no place for.
        notes: what a reader must know.
        comment: how lines of comment are written around; None where readers of the format may not skip them.
    """

    text: str
    readings: Mapping[str, Robot]
    cannot_hold: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    comment: str | None = None


@dataclass(frozen=True)
class Exported:
    """A robot written for other software.

    Attributes:
        robot: its name.
        to: the format.
        text: the file's.
        cannot_hold: what of this robot the format has no place for.
        notes: what a reader must know.
        residuals: what the readings leave of the loaded robot's tool pose.
    """

    robot: str
    to: str
    text: str
    cannot_hold: tuple[str, ...]
    notes: tuple[str, ...]
    residuals: tuple[Residual, ...]
