"""A calibration's outcome as its folder tells it: values only."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from elastocal.chain import Array
from elastocal.identification.result import IdentifiedParameter
from elastocal.robot import Robot


@dataclass(frozen=True)
class SavedResult:
    """What result.json and robot.toml say of a calibration.

    Attributes:
        robot: the identified robot, its frames known.
        status: "converged", "not_converged" or "not_identifiable".
        parameters: every parameter of the robot.
        names: the identified parameters.
        covariance: (names, names); of small rotations for frames.
        model_sigma: by kind of observation, what the model leaves unexplained [m or rad].
        freedom: degrees of freedom that the covariance rests on.
    """

    robot: Robot
    status: str
    parameters: tuple[IdentifiedParameter, ...]
    names: tuple[str, ...]
    covariance: Array
    model_sigma: Mapping[str, float]
    freedom: float
