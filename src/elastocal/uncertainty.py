"""How sure a calibrated robot's predictions are: what its parameters leave open, and what its model leaves out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.measurements import Labels, Measurements
from elastocal.prediction import Model
from elastocal.robot import Robot


class Identified(Protocol):
    """What is known of a calibrated robot: the result of `calibrate`, or one that was saved."""

    @property
    def robot(self) -> Robot:
        """The identified robot."""

    @property
    def names(self) -> tuple[str, ...]:
        """The identified parameters."""

    @property
    def covariance(self) -> Array:
        """(names, names); of small rotations for frames."""

    @property
    def model_sigma(self) -> Mapping[str, float]:
        """By kind of observation, what the model leaves unexplained [m or rad]."""


@dataclass(frozen=True)
class Uncertainty:
    """Of the predicted position of a target at n poses, in the instrument's frame.

    Attributes:
        data: the poses, with target, payload and station.
        position: (n, 3) predicted [m].
        covariance: (n, 3, 3) that the parameters' covariance gives it [m2].
        model_sigma: standard deviation along each axis of what the model leaves unexplained [m], and, where the
            measurements stated no standard deviations, of the instrument; NaN if no lengths were measured.
    """

    data: Measurements
    position: Array
    covariance: Array
    model_sigma: float

    @property
    def from_parameters(self) -> Array:
        """(n,) standard deviation of the position: root mean square length of its error [m]."""
        return np.sqrt(np.trace(self.covariance, axis1=1, axis2=2))

    @property
    def from_model(self) -> float:
        """The same of what the model leaves unexplained [m], alike at all poses."""
        return float(np.sqrt(3.0)) * self.model_sigma

    @property
    def total(self) -> Array:
        """(n,) both together [m]."""
        return np.hypot(self.from_parameters, self.from_model)

    @property
    def measured_ratio(self) -> float | None:
        """Errors measured at these poses over the standard deviations, root mean squares; None where there are none."""
        rows = self.data.measures("position")
        if not rows.any():
            return None
        errors = self.data.observed("position")[rows] - self.position[rows]
        return float(np.sqrt((errors**2).sum() / (self.total[rows] ** 2).sum()))


def position_uncertainty(
    result: Identified,
    q: Array,
    *,
    station: str | None = None,
    target: str | None = None,
    load: str | None = None,
    wrench: Array | None = None,
) -> Uncertainty:
    """The uncertainty of the position that a calibrated robot predicts.

    Args:
        result: of a calibration.
        q: (poses, joints) the controller's joint positions [rad or m].
        station: the instrument's station; None: the robot's base.
        target: a target of the robot; None: the tool's origin.
        load: a payload of the robot.
        wrench: (poses, 6) on the tool, force first, in the tool's frame [N, N m].

    Raises:
        EquilibriumError: a pose does not settle under its load.
    """
    q = np.atleast_2d(np.asarray(q, dtype=float))
    stations, targets, loads = (Labels.same(name, len(q)) for name in (station, target, load))
    return uncertainty_at(result, Measurements(q, wrench=wrench, station=stations, target=targets, load=loads))


def uncertainty_at(result: Identified, data: Measurements) -> Uncertainty:
    """The same at the poses of data, whatever was measured there.

    Raises:
        EquilibriumError: a pose does not settle under its load.
    """
    covariance, position = np.zeros((len(data), 3, 3)), np.zeros((len(data), 3))
    for rows, predicted, columns in predicted_positions(result, data):
        position[rows] = predicted
        covariance[rows] = np.einsum("ipn,jpn->nij", columns, result.covariance @ columns)
    sigma = result.model_sigma.get("position", result.model_sigma.get("distance", np.nan))
    return Uncertainty(data, position, covariance, sigma)


def predicted_positions(result: Identified, data: Measurements) -> Iterator[tuple[NDArray[np.intp], Array, Array]]:
    """Rows of data, the target's position there (rows, 3), and its columns (3, names, rows), block by block.

    Raises:
        EquilibriumError: a pose does not settle under its load.
    """
    asked = replace(data, position=np.zeros((len(data), 3)), orientation=None, distance=None)
    for part in Model(result.robot, result.names, asked).parts(np.zeros(len(result.names))):
        yield part.rows, -part.residual.T, part.jacobian[:, :-1]
