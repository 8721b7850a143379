"""What the calibrations of a study say together, point by point of its grid."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from elastocal.io.study_values import Setting, Study

Rows = Sequence[Mapping[str, Any]]


@dataclass(frozen=True)
class Share:
    """How often something was so, with an interval that covers the probability with 95 % confidence (Wilson, 1927)."""

    count: int
    of: int

    @property
    def value(self) -> float:
        """The share."""
        return self.count / self.of if self.of else float("nan")

    @property
    def interval(self) -> tuple[float, float]:
        """Of the probability."""
        if not self.of:
            return 0.0, 1.0
        z, n, p = 1.959964, self.of, self.value
        middle, half = p + z * z / (2 * n), z * float(np.sqrt(p * (1 - p) / n + z * z / (4 * n * n)))
        return (middle - half) / (1 + z * z / n), (middle + half) / (1 + z * z / n)


@dataclass(frozen=True)
class Coverage:
    """How often intervals that should cover 95 % did.

    Attributes:
        pooled: over all parameters.
        least, most: the parameter that is covered least and most often, and how often.
        position: scatter of the predicted position about the true fit's, over what its standard deviation says.
        chi2: mean reduced chi-square with the true noise; NaN without positions or noise.
    """

    pooled: Share
    least: tuple[str, float]
    most: tuple[str, float]
    position: float
    chi2: float


@dataclass(frozen=True)
class Torques:
    """How well transition torques were found.

    Attributes:
        error: root mean square of found / true − 1.
        score: root mean square of the errors in their standard deviations.
        same_sides: how often all rows were on their true sides.
    """

    error: float
    score: float
    same_sides: Share


@dataclass(frozen=True)
class CellSummary:
    """One point of a grid; SI.

    Attributes:
        setting: of the point.
        count: calibrations.
        sound: those that converged, of which all else is told.
        nominal_mean: held-out error before calibration, mean over the calibrations.
        held_out_mean: after it; with the standard error of that mean, and the median and 95 % quantile.
        held_out_max: the largest of all.
        seconds: of a calibration, median.
        coverage, right, torques, outliers, accused: what was asked for.
    """

    setting: Setting
    count: int
    sound: int
    nominal_mean: float
    held_out_mean: float
    held_out_error: float
    held_out_median: float
    held_out_q95: float
    held_out_max: float
    seconds: float
    coverage: Coverage | None = None
    right: Share | None = None
    torques: Torques | None = None
    outliers: Share | None = None
    accused: int | None = None


@dataclass(frozen=True)
class StudySummary:
    """A study's results, point by point of its grid."""

    study: Study
    cells: tuple[CellSummary, ...]

    @property
    def count(self) -> int:
        """Calibrations."""
        return sum(cell.count for cell in self.cells)

    @property
    def sound(self) -> int:
        """Those that converged."""
        return sum(cell.sound for cell in self.cells)


def summarised(study: Study, rows: Iterable[Rows]) -> StudySummary:
    """What the rows of each point of a study's grid say."""
    cells = tuple(_cell(study, setting, found) for setting, found in zip(study.settings, rows, strict=True))
    return StudySummary(study, cells)


def _cell(study: Study, setting: Setting, rows: Rows) -> CellSummary:
    sound = [row for row in rows if row["status"] == "converged"]
    means = np.array([row["held_out_mean"] for row in sound])
    some = len(means) > 0
    asked = study.measures if some else ()
    return CellSummary(
        setting=setting,
        count=len(rows),
        sound=len(sound),
        nominal_mean=float(np.mean([row["nominal_mean"] for row in sound])) if some else float("nan"),
        held_out_mean=float(means.mean()) if some else float("nan"),
        held_out_error=float(means.std(ddof=1) / np.sqrt(len(means))) if len(means) > 1 else float("nan"),
        held_out_median=float(np.median(means)) if some else float("nan"),
        held_out_q95=float(np.quantile(means, 0.95)) if some else float("nan"),
        held_out_max=max((row["held_out_max"] for row in sound), default=float("nan")),
        seconds=float(np.median([row["seconds"] for row in sound])) if some else float("nan"),
        coverage=_coverage(sound) if "coverage" in asked else None,
        right=Share(sum(row["right"] for row in sound), len(sound)) if "recommendation" in asked else None,
        torques=_torques(sound) if "transition" in asked else None,
        outliers=_sum_of(sound, "outliers_named", "outliers_wrong") if "outliers" in asked else None,
        accused=sum(row["outliers_accused"] for row in sound) if "outliers" in asked else None,
    )


def _sum_of(rows: Rows, count: str, of: str) -> Share:
    return Share(sum(row[count] for row in rows), sum(row[of] for row in rows))


def _coverage(rows: Rows) -> Coverage:
    hits: dict[str, list[bool]] = defaultdict(list)
    for row in rows:
        for name, covered in zip(row["interval_name"], row["covered"], strict=True):
            hits[name].append(covered)
    shares = {name: float(np.mean(found)) for name, found in hits.items()} or {"": float("nan")}
    least, most = min(shares, key=lambda name: shares[name]), max(shares, key=lambda name: shares[name])
    everything = [hit for found in hits.values() for hit in found]
    squares = [np.mean([row[key] for row in rows]) for key in ("position_square", "position_variance")]
    chi2 = [row["chi2_true"] for row in rows if row["chi2_true"] is not None]
    return Coverage(
        pooled=Share(sum(everything), len(everything)),
        least=(least, shares[least]),
        most=(most, shares[most]),
        position=float(np.sqrt(squares[0] / squares[1])) if squares[1] else float("nan"),
        chi2=float(np.mean(chi2)) if chi2 else float("nan"),
    )


def _torques(rows: Rows) -> Torques:
    errors = np.array([error for row in rows for error in row["torque_error"]], dtype=float)
    scores = np.array([score for row in rows for score in row["torque_score"]], dtype=float)
    told = scores[np.isfinite(scores)]
    return Torques(
        error=float(np.sqrt(np.nanmean(errors**2))) if np.isfinite(errors).any() else float("nan"),
        score=float(np.sqrt((told**2).mean())) if len(told) else float("nan"),
        same_sides=Share(sum(row["same_sides"] for row in rows), len(rows)),
    )
