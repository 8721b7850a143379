"""Warnings where the TCP to be corrected is not what was calibrated."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from elastocal.chain import Array, rotation_vectors
from elastocal.compensation.targets import Targets
from elastocal.identification import SavedResult
from elastocal.robot import Frame, Robot

SAME_POINT, SAME_ANGLE = 1e-6, 1e-6
"""Points [m] and orientations [rad] that agree to this are the same."""


@dataclass(frozen=True)
class Calibrated:
    """What a calibration measured.

    Attributes:
        robot: as identified.
        targets: names of the measured targets; None: the tool's origin.
        oriented: whether orientations were measured.
    """

    robot: Robot
    targets: frozenset[str | None]
    oriented: bool

    @classmethod
    def of(cls, saved: SavedResult) -> Calibrated | None:
        """What a saved calibration measured; None where its rows are not there to tell."""
        if saved.errors is None:
            return None
        labels = saved.errors.data.target
        names = {None} if labels is None else {labels.name(int(code)) for code in np.unique(labels.codes)}
        return cls(saved.robot, frozenset(names), any(found.angle is not None for found in saved.residuals.values()))


@dataclass(frozen=True)
class Asked:
    """What targets ask for: TCPs by name (None: the tool's origin), and whether any orientation matters."""

    tcps: frozenset[str | None] = frozenset()
    oriented: bool = False

    def with_targets(self, block: Targets) -> Asked:
        """With a further block."""
        labels = block.target
        names = {None} if labels is None else {labels.name(int(code)) for code in np.unique(labels.codes)}
        oriented = block.position is None or block.orientation is not None
        return replace(self, tcps=self.tcps | names, oriented=self.oriented or oriented)


def tcp_warnings(robot: Robot, calibrated: Calibrated, asked: Asked) -> Iterator[str]:
    """What of the TCP no calibration has seen.

    Args:
        robot: with the tool that is used.
        calibrated: what was measured.
        asked: what targets ask for.
    """
    measured = [_flange_pose(calibrated.robot, name) for name in calibrated.targets]
    for name in sorted(asked.tcps, key=str):
        at, turned = _flange_pose(robot, name)
        away = min(float(np.linalg.norm(at - point)) for point, _ in measured)
        if away > SAME_POINT:
            yield (
                f"The TCP is {_said(name)}, {1e3 * away:.1f} mm from what was calibrated, "
                f"{_listed(calibrated.targets)}: an error of the way between them is not corrected. Measure at the TCP."
            )
        elif asked.oriented and calibrated.oriented and min(_angle(turned, turn) for _, turn in measured) > SAME_ANGLE:
            yield f"The TCP is {_said(name)}, turned against what was calibrated, {_listed(calibrated.targets)}."
    if asked.oriented and not calibrated.oriented:
        yield (
            "Only positions were calibrated, so the orientation of the tool on the flange is as the robot file has it: "
            "an error of it is not corrected. Measure orientations too."
        )


def _flange_pose(robot: Robot, target: str | None) -> tuple[Array, Array]:
    """Position (3,) and rotation (3, 3) of a TCP in the flange frame."""
    frame = Frame() if target is None else robot.targets[target]
    return robot.tool.translation + robot.tool.rotation @ frame.translation, robot.tool.rotation @ frame.rotation


def _angle(one: Array, other: Array) -> float:
    return float(np.linalg.norm(rotation_vectors((one @ other.T)[:, :, None])))


def _said(name: str | None) -> str:
    return "the tool's origin" if name is None else f"target {name}"


def _listed(names: Iterable[str | None]) -> str:
    return ", ".join(_said(name) for name in sorted(names, key=str))
