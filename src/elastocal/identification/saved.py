"""What is left of a calibration once it was saved and read again: all that reports and comparisons need."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from elastocal.chain import Array
from elastocal.identification.observability import Observability
from elastocal.identification.outliers import Outlier
from elastocal.identification.priors import MapFit
from elastocal.identification.result import CalibrationResult, IdentifiedElement, IdentifiedParameter, RowErrors
from elastocal.identification.statistics import Statistics
from elastocal.identification.transition import Search
from elastocal.robot import Robot


@dataclass(frozen=True)
class SavedResult:
    """What robot.toml, result.json and residuals.csv say of a calibration.

    Attributes:
        robot: the identified robot, its frames known.
        status: "converged", "not_converged" or "not_identifiable".
        parameters: every parameter of the robot.
        names: the identified parameters.
        covariance: (names, names); of small rotations for frames.
        model_sigma: by kind of observation, what the model leaves unexplained [m or rad].
        freedom: degrees of freedom that the covariance rests on.
        errors: row by row; None where residuals.csv was not read or is not there. Of its data, what was measured is
            left out: joint positions, names and wrenches are there.
        data_sha256: hashes of the data files.
        version: of the program that saved it.

    All else is as in CalibrationResult; what an earlier version did not save is empty.
    """

    robot: Robot
    status: str
    parameters: tuple[IdentifiedParameter, ...]
    names: tuple[str, ...]
    covariance: Array
    model_sigma: Mapping[str, float]
    freedom: float
    elastic: tuple[IdentifiedElement, ...] = ()
    residuals: Mapping[str, Statistics] = field(default_factory=dict)
    observability: Observability | None = None
    outliers: tuple[Outlier, ...] = ()
    search: Search | None = None
    maps: MapFit | None = None
    tolerances: Mapping[str, float] = field(default_factory=dict)
    chi2_reduced: float = float("nan")
    errors: RowErrors | None = None
    correlated: tuple[tuple[str, ...], ...] = ()
    bootstrap: Mapping[str, int] | None = None
    iterations: int = 0
    seconds: float = 0.0
    settings: Mapping[str, object] = field(default_factory=dict)
    verdict: str = ""
    warnings: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    data_sha256: tuple[str, ...] = ()
    version: str = ""


AnyResult = CalibrationResult | SavedResult
"""A calibration, as it was returned or as it was read."""
