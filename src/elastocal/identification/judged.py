"""Rows of a part judged by themselves: their residuals, and which are outliers.

Of very many rows each has so little influence on the fit that its deletion residual is its residual, so that the rule
of `studentised` needs no Jacobian.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.identification.evidence import PRIOR
from elastocal.identification.outliers import Outlier
from elastocal.identification.partitioned import channels_of
from elastocal.identification.solver import Normal, Solution
from elastocal.identification.statistics import Residuals, residuals_of
from elastocal.identification.studentised import LEVEL, TRIFLE, Rows, least_score
from elastocal.identification.sums import Variances, misfit_of, observation_variance, variance_of
from elastocal.measurements import Measurements
from elastocal.prediction import Model
from elastocal.robot import Robot


@dataclass(frozen=True)
class Judged:
    """Residuals of rows, and what they are in units of their standard deviations.

    Attributes:
        residuals: measured - predicted.
        squares: by kind, (n,) sum of residual^2 / variance; zero where nothing was observed.
        coordinates: (n,) how many were observed.
    """

    residuals: Residuals
    squares: dict[str, Array]
    coordinates: NDArray[np.intp]

    @classmethod
    def of(cls, model: Model, variances: Variances, several: bool) -> Judged:
        """The rows of a model at zero displacements, as measured by the model variances.

        Args:
            model: of some rows.
            variances: by channel.
            several: whether all data are from several stations.
        """
        n, channel = len(model.data), channels_of(model.data, several)
        squares: dict[str, Array] = {}
        coordinates = np.zeros(n, dtype=np.intp)
        parts = list(model.parts(np.zeros(len(model.names)), derivatives=False))
        for part in parts:
            named = part._replace(channel=channel.get(part.kind, part.channel))
            variance = observation_variance(model.data, part, variance_of(variances, named))[:, 0]
            squares.setdefault(part.kind, np.zeros(n))[part.rows] = (part.residual**2 / variance).sum(axis=0)
            coordinates[part.rows] += len(part.residual)
        return cls(residuals_of(n, parts), squares, coordinates)

    @property
    def gain(self) -> Array:
        """(n,) sum of residual^2 / variance of each row."""
        return np.sum(list(self.squares.values()), axis=0)

    def sizes(self, kind: str) -> Array:
        """(n,) sizes of the residuals of a kind [m or rad]."""
        values: Array = getattr(self.residuals, kind)
        return np.linalg.norm(values.reshape(len(values), -1), axis=1)

    def outlier(self, data: Measurements, row: int, score: float, rejected: bool) -> Outlier:
        """A row as an outlier, of the kind of observation that is furthest off."""
        kind = max(self.squares, key=lambda kind: float(self.squares[kind][row]))
        return Outlier(row, *data.origin(row), kind, float(self.sizes(kind)[row]), score, rejected)


@dataclass(frozen=True)
class Rule:
    """From which residual on a row is an outlier under a fit; see `studentised`.

    Attributes:
        variances: that residuals are measured by.
        misfit: of the rows that were fitted, and `freedom`, the degrees of freedom of the fit.
        rows: how many are judged.
        several: whether they are from several stations.
    """

    variances: Variances
    misfit: float
    freedom: float
    rows: int
    several: bool

    @classmethod
    def of(cls, solution: Solution, torques: int, rows: int, several: bool) -> Rule:
        """The rule under a fit.

        Args:
            solution: the fit.
            torques: how many transition torques were searched.
            rows: how many are judged.
            several: whether they are from several stations.
        """
        sums = {kind: found for kind, found in solution.sums.items() if kind != PRIOR}
        covariance = Normal.of(solution.sums).covariance
        told = sum(float((covariance * found.gram[:-1, :-1]).sum()) for found in sums.values())
        freedom = sum(found.count for found in sums.values()) - told - torques
        return cls(solution.variances, misfit_of(sums), freedom, rows, several)

    @property
    def variance(self) -> float:
        """What the fit leaves of the variance that residuals are measured by; about 1."""
        return self.misfit / max(self.freedom, 1.0)

    def judge(self, robot: Robot, data: Measurements) -> Judged:
        """The residuals of rows with a robot."""
        return Judged.of(Model(robot, (), data), self.variances, self.several)

    def scores(self, judged: Judged, fitted: Rows) -> Array:
        """(n,) root of F of each row, about 1 for a good one; `fitted` (n,): whether the fit contains it."""
        count = np.maximum(judged.coordinates, 1)
        left = np.maximum(self.misfit - np.where(fitted, judged.gain, 0.0), 0.0)
        variance = left / np.maximum(self.freedom - np.where(fitted, count, 0), 1.0)
        return np.sqrt(judged.gain / count / np.maximum(variance, 1e-300))

    def accused(self, judged: Judged, scores: Array) -> Rows:
        """(n,) which rows are outliers."""
        least = np.full(int(judged.coordinates.max(initial=0)) + 1, np.inf)
        for count in np.unique(judged.coordinates).tolist():
            if count:
                least[count] = least_score(count, self.freedom - count, LEVEL / self.rows)
        sizes = np.max([_largest(getattr(judged.residuals, kind)) for kind in judged.squares], axis=0)
        return (scores > least[judged.coordinates]) & (sizes > TRIFLE)


def _largest(values: Array) -> Array:
    """(n,) the largest coordinate of residuals (n,) or (n, 3), zero where nothing was observed."""
    return np.nan_to_num(np.abs(values.reshape(len(values), -1))).max(axis=1)
