"""What a calibration found: values only."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.identification.gauge import Gauge
from elastocal.identification.observability import Observability
from elastocal.identification.outliers import Outlier
from elastocal.identification.priors import MapFit, PriorFit
from elastocal.identification.statistics import Residuals, Statistics
from elastocal.identification.transition import Search, TransitionData
from elastocal.measurements import Measurements
from elastocal.robot import Robot


@dataclass(frozen=True)
class IdentifiedParameter:
    """One parameter of the robot after calibration; SI.

    Attributes:
        nominal: before; None for a frame with no first guess.
        identified: after; the same as before where it was not identified.
        std: standard deviation; None where it was not identified.
        verdict: "identified", "insignificant" (a compliance that is zero within two standard deviations), "dependent",
            "unobservable" or "fixed".
        reason: a sentence where the verdict asks for one.
        data_share: how much of it the data tell, from 0 to 1, where a prior carries the rest; None without a prior.
        interval: that covers the truth with 95 % confidence; None where it was not identified.
    """

    name: str
    unit: str
    nominal: float | None
    identified: float
    std: float | None
    verdict: str
    reason: str = ""
    data_share: float | None = None
    interval: tuple[float, float] | None = None


@dataclass(frozen=True)
class IdentifiedElement:
    """An elastic element after calibration: its law and coefficients, with standard deviations where identified.

    Attributes:
        transition_torque: [N m or N], where the law has one, with `transition_std` where it was searched.
        transition: what the data say of it; None where the law has none.
    """

    element: str
    law: str
    transition_torque: float | None
    coefficients: tuple[float, ...]
    std: tuple[float | None, ...]
    verdict: str
    transition_std: float | None = None
    transition: TransitionData | None = None


@dataclass(frozen=True)
class RowErrors:
    """Residuals of every row, nominal and calibrated, fitted and held out.

    Attributes:
        data: the rows, those fitted first.
        held_out: (n,) which of them were held out.
        nominal: with the nominal robot in the fitted frames.
        calibrated: with the identified robot.
    """

    data: Measurements
    held_out: NDArray[np.bool_]
    nominal: Residuals
    calibrated: Residuals


@dataclass(frozen=True)
class Streamed:
    """What was read part by part.

    Attributes:
        rows: how many were fitted, outliers counted with them.
        parts: in how many parts.
        sample: rows of the sample that alignment, searches and outliers were decided on.
        outliers: how many rows do not fit the others, of which the result lists the worst.
        rejected: how many of them were left out of the fit.
    """

    rows: int
    parts: int
    sample: int
    outliers: int
    rejected: int


@dataclass(frozen=True)
class CalibrationResult:
    """A calibration's outcome.

    Attributes:
        robot: the identified robot, its frames known.
        nominal_robot: the robot before, its open frames fitted.
        status: "converged", "not_converged" or "not_identifiable".
        parameters: every parameter of the robot.
        elastic: every elastic element.
        residuals: statistics of "nominal", "calibrated", "held_out_nominal" and "held_out" rows, the last two if any;
            without them "cross_validated", the error to expect on unseen poses: of every row under the fit without its
            pose.
        observability: of the fitted poses.
        gauge: which parameters were identified, which were not and why.
        names: the identified parameters: those that the gauge keeps, less those held at zero, and the searched
            transition torques of hinges.
        covariance: (names, names); of small rotations for frames.
        correlated: groups of identified parameters whose errors are correlated by more than 0.95.
        coordinates: how many were observed, three for a position.
        bootstrap: how many "fits" standard deviations and intervals come from, and how many "failed"; None where they
            come from the linear covariance.
        freedom: degrees of freedom: coordinates less what the parameters take of them.
        model_sigma: by kind of observation, what the model leaves unexplained, beyond the stated deviations [m or rad].
        chi2_reduced: sum of squares over degrees of freedom, with the weights used.
        errors: row by row.
        outliers: rows that do not fit the others, the worst first.
        iterations, seconds: what it took.
        search: how transition torques were found; None where there were none to find.
        prior: the fit with priors, of joint maps and geometry; None without them.
        streamed: what was read part by part; None where all rows are in memory. `errors` then have those of a sample
            and of the listed outliers.
        settings: what was asked for.
        verdict: one sentence.
        warnings: sentences with a remedy.
        notes: what the data cannot say, however good they are.
    """

    robot: Robot
    nominal_robot: Robot
    status: str
    parameters: tuple[IdentifiedParameter, ...]
    elastic: tuple[IdentifiedElement, ...]
    residuals: Mapping[str, Statistics]
    observability: Observability
    gauge: Gauge
    names: tuple[str, ...]
    covariance: Array
    coordinates: int
    model_sigma: Mapping[str, float]
    chi2_reduced: float
    errors: RowErrors
    iterations: int
    settings: Mapping[str, object]
    outliers: tuple[Outlier, ...] = ()
    search: Search | None = None
    prior: PriorFit | None = None
    streamed: Streamed | None = None
    seconds: float = 0.0
    verdict: str = ""
    warnings: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    correlated: tuple[tuple[str, ...], ...] = ()
    freedom: float = 0.0
    bootstrap: Mapping[str, int] | None = None

    @property
    def maps(self) -> MapFit | None:
        """How joint maps were found; None without them."""
        if self.prior is None or not self.prior.orders:
            return None
        return MapFit(self.prior.orders, self.prior.bands, self.prior.log_evidence)

    @property
    def tolerances(self) -> Mapping[str, float]:
        """Standard deviations of the kinds of geometry that had priors, given or estimated [m or rad]."""
        return {} if self.prior is None else self.prior.tolerances

    def __str__(self) -> str:
        """The verdict table, in millimetres."""
        lines = [
            f"{self.robot.name}: {self.status}",
            f"{'position error [mm]':24}{'rows':>8}{'mean':>10}{'max':>10}{'rms':>10}",
        ]
        for name, found in self.residuals.items():
            numbers = "".join(f"{1e3 * value:10.4f}" for value in (found.mean, found.max, found.rms))
            lines.append(f"{name.replace('_', ' '):24}{found.n:8d}{numbers}")
        return "\n".join([*lines, self.verdict])
