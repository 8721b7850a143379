"""What a plan consists of: values only."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.design.task import Reading
from elastocal.identification import Gauge, Observability
from elastocal.measurements import Measurements
from elastocal.robot import Robot


@dataclass(frozen=True)
class PlannedParameter:
    """A parameter that the poses are to tell, with the standard deviation to expect; None where they do not tell it."""

    name: str
    unit: str
    nominal: float | None
    std: float | None


@dataclass(frozen=True)
class PlannedTransition:
    """The loads that the chosen poses put on an element with a transition torque; N m or N.

    Attributes:
        torque: that the plan reckons with, and `source`: where it comes from.
        below, above: how many of the poses are on each side of it.
        lowest, highest: of the loads' sizes.
        widest_gap: between neighbouring ones: where a step's torque could hide.
    """

    element: str
    law: str
    torque: float
    source: str
    below: int
    above: int
    lowest: float
    highest: float
    widest_gap: float


@dataclass(frozen=True)
class CurvePoint:
    """The accuracy to expect of so many poses: root mean square of the position's standard deviation [m].

    Attributes:
        planned: chosen by the criterion; None where they do not tell all parameters.
        random: of as many random candidates, the median of several draws; None likewise.
    """

    poses: int
    planned: float | None
    random: float | None


@dataclass(frozen=True)
class Plan:
    """Which poses to measure.

    Attributes:
        robot: nominal, as it was given.
        rows: (poses,) of the candidates, in the order in which to measure them.
        poses: joint positions with target, payload and station, in this order; nothing observed.
        expected: (poses, 3) where the nominal robot has the target, in the instrument's frame [m]; None where its
            frames are not known.
        criterion: by which they were chosen.
        status: "planned", or "not_identifiable" if the poses do not tell every parameter.
        parameters: what they tell.
        gauge: which parameters a calibration identifies, which not and why.
        observability: of the poses and those measured before: what `calibrate` will say of them.
        accuracy: root mean square over the workspace of the standard deviation of the predicted position that the
            instrument's noise leaves [m]; None where a parameter is not told.
        curve: the same for other numbers of poses.
        enough: the fewest poses from which five more improve the accuracy by less than 5 %; None if none of the curve.
        transitions: loads on elements with a transition torque.
        travel: "before" and "after" ordering, the sum of the largest joint moves [rad or m].
        reading: how they will be measured.
        candidates: how many there were to choose from; `measured`: how many were measured before.
        settings: what was asked for.
        warnings: sentences with a remedy.
        notes: what else there is to know.
        seconds: what it took.
    """

    robot: Robot
    rows: NDArray[np.intp]
    poses: Measurements
    expected: Array | None
    criterion: str
    status: str
    parameters: tuple[PlannedParameter, ...]
    gauge: Gauge
    observability: Observability
    accuracy: float | None
    curve: tuple[CurvePoint, ...]
    enough: int | None
    transitions: tuple[PlannedTransition, ...]
    travel: Mapping[str, float]
    reading: Reading
    candidates: int
    measured: int
    settings: Mapping[str, object]
    warnings: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    seconds: float = 0.0

    @property
    def q(self) -> Array:
        """Joint positions (poses, joints) in the order in which to measure them [rad or m]."""
        return self.poses.q

    @property
    def std(self) -> dict[str, float | None]:
        """Standard deviations to expect, by parameter."""
        return {parameter.name: parameter.std for parameter in self.parameters}

    def __str__(self) -> str:
        """Poses, parameters and the accuracy to expect."""
        lines = [f"{self.robot.name}: {len(self.rows)} of {self.candidates} poses by {self.criterion}: {self.status}"]
        if self.accuracy is not None:
            lines.append(f"expected accuracy {1e3 * self.accuracy:.4f} mm (rms, noise {1e3 * self.reading.noise:g} mm)")
        seen = self.observability
        told = f"{seen.rank} of {seen.parameters} parameters told"
        lines.append(f"{told}; O1 {seen.O1:.4g}, condition {seen.condition:.4g}")
        return "\n".join([*lines, *self.warnings])
