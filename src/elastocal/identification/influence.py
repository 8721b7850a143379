"""What each pose does to a fit: the fit without it, to first order, from one pass over the data.

With whitened residuals r and the hat matrix H = J C J^T, the residuals of a pose under the fit without it are
(1 - H_ii)^-1 r_i, and to leave it out lowers the sum of squares by r_i . (1 - H_ii)^-1 r_i (Cook and Weisberg, 1982).
That is also the square of these residuals over their variance. Of a pose with weight w in the fit they are
(1 - w H_ii)^-1 r_i and the square is r_i . ((1 - w H_ii) (1 + (1 - w) H_ii))^-1 r_i.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.identification.sums import Variances, observation_variance, variance_of
from elastocal.measurements import repeats
from elastocal.prediction import Model

LEVERAGE = 1e-9
"""A pose whose own share in its prediction is all but this decides some parameter alone: without it there is no fit."""

WIDTHS = {"position": 3, "orientation": 3, "distance": 1}


@dataclass(frozen=True)
class Influence:
    """Of each pose; the rows of one pose are left out together.

    Attributes:
        pose: (n,) number of each row's pose.
        coordinates: (poses,) how many were observed.
        gain: (poses,) by how much the sum of squares falls without the pose, or, of a pose that has no weight in the
            fit, would rise with it; inf where it decides a parameter alone.
        left_out: by kind, residuals (n, 3 or 1) under the fit without the row's pose [m or rad]; NaN where nothing was
            observed, inf where the pose decides a parameter alone.
    """

    pose: NDArray[np.intp]
    coordinates: NDArray[np.intp]
    gain: Array
    left_out: dict[str, Array]


@dataclass(frozen=True)
class _Rows:
    """Some rows that observe the same kinds: Jacobian with residual (n, channels, parameters + 1), whitened."""

    rows: NDArray[np.intp]
    kinds: tuple[str, ...]
    deviation: Array
    jacobian: Array

    def take(self, chosen: NDArray[np.intp]) -> _Rows:
        return _Rows(self.rows[chosen], self.kinds, self.deviation[chosen], self.jacobian[chosen])


def influence(
    model: Model,
    displacements: Array,
    covariance: Array,
    variances: Variances,
    pose: NDArray[np.intp] | None = None,
) -> Influence:
    """The influence of each pose on a fit.

    Args:
        model: that was fitted; the rows of one pose have the same weight.
        displacements: (parameters,) of the fit.
        covariance: (parameters, parameters) for unit variance, the inverse of the normal matrix.
        variances: the model variances that it is weighed by.
        pose: (n,) number of each row's pose; None: as the data have it.

    Raises:
        EquilibriumError: a pose does not settle under its load.
    """
    pose = repeats(model.data) if pose is None else pose
    weights = np.ones(len(pose)) if model.weights is None else model.weights
    count = int(pose.max(initial=-1)) + 1
    found = Influence(pose, np.zeros(count, dtype=int), np.zeros(count), {})
    for kind in dict.fromkeys(kind for setup in model.setups for kind in setup.kinds):
        found.left_out[kind] = np.full((len(pose), WIDTHS[kind]), np.nan)
    several = np.greater(np.bincount(pose, minlength=count), 1)[pose]
    waiting: dict[int, list[_Rows]] = {}
    for block in _blocks(model, displacements, variances):
        alone = block.take(np.flatnonzero(~several[block.rows]))
        gain, without = _left_out(alone.jacobian, covariance, weights[alone.rows])
        found.gain[pose[alone.rows]] = gain
        _enter(found, alone, without)
        for i in np.flatnonzero(several[block.rows]):
            waiting.setdefault(int(pose[block.rows[i]]), []).append(block.take(np.array([i])))
    for number, parts in waiting.items():
        together = np.concatenate([part.jacobian for part in parts], axis=1)
        gain, without = _left_out(together, covariance, weights[parts[0].rows])
        found.gain[number] = gain[0]
        ends = np.cumsum([part.jacobian.shape[1] for part in parts])[:-1]
        for part, piece in zip(parts, np.split(without, ends, axis=1), strict=True):
            _enter(found, part, piece)
    return found


def _blocks(model: Model, displacements: Array, variances: Variances) -> Iterator[_Rows]:
    """All rows, block by block, the kinds of a row together."""
    for _, group in groupby(model.parts(displacements), key=lambda part: id(part.rows)):
        parts = list(group)
        deviations, jacobians = [], []
        for part in parts:
            variance = observation_variance(model.data, part, variance_of(variances, part))
            deviations.append(np.broadcast_to(np.sqrt(variance[:, 0]), part.residual.shape).T)
            jacobians.append((part.jacobian / np.sqrt(variance)).transpose(2, 0, 1))
        kinds = tuple(part.kind for part in parts)
        yield _Rows(parts[0].rows, kinds, np.concatenate(deviations, axis=1), np.concatenate(jacobians, axis=1))


def _left_out(jacobian: Array, covariance: Array, weights: Array) -> tuple[Array, Array]:
    """Gain (m,) and whitened residuals (m, channels) without each of m poses; their Jacobians have residuals last."""
    own, residual = jacobian[:, :, :-1], jacobian[:, :, -1]
    shares, vectors = np.linalg.eigh((own @ covariance) @ own.swapaxes(1, 2))
    remaining = 1.0 - weights[:, None] * shares
    decides = remaining[:, -1] < LEVERAGE
    remaining = np.maximum(remaining, LEVERAGE)
    along = np.einsum("mij,mi->mj", vectors, residual)
    without = np.einsum("mij,mj->mi", vectors, along / remaining)
    gain = (along**2 / (remaining * (1.0 + (1.0 - weights[:, None]) * shares))).sum(axis=1)
    return np.where(decides, np.inf, gain), np.where(decides[:, None], np.inf, without)


def _enter(found: Influence, rows: _Rows, without: Array) -> None:
    """Enter the residuals without their poses, in metres and radians."""
    start = 0
    for kind in rows.kinds:
        end = start + WIDTHS[kind]
        found.left_out[kind][rows.rows] = (without * rows.deviation)[:, start:end]
        start = end
    np.add.at(found.coordinates, found.pose[rows.rows], start)
