"""Damped, weighted least squares over named parameters, with the weights estimated along the way."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from elastocal.chain import Array
from elastocal.errors import EquilibriumError
from elastocal.identification.partitioned import Partitioned
from elastocal.identification.sums import FLOOR, Sums, Variances, misfit_of, normal_sums, reweighed
from elastocal.measurements import KINDS
from elastocal.prediction import Model

SEEN = 1e-6
"""Directions whose singular value is below this, relative to the largest one of the scaled Jacobian, are not seen by
the data: a change along them would have to be a million times larger than elsewhere to show."""

STEP_LEFT = 1e-8
"""A step that would lower the sum of squares by less than this is no step: the parameters would move by less than 1e-4
of their standard deviations."""

MAX_STEPS = 100
MAX_REWEIGHTINGS = 30


@dataclass(frozen=True)
class Solution:
    """Where a fit ended.

    Attributes:
        displacements: (parameters,) from the model's robot.
        sums: of the data there, weighed by the stated variances and `variances`.
        variances: the model variances that the residuals ask for.
        steps: how many were tried.
        converged: whether steps and weights came to rest.
    """

    displacements: Array
    sums: Sums
    variances: Variances
    steps: int
    converged: bool


@dataclass(frozen=True)
class Normal:
    """The normal equations of all kinds together, scaled to a unit diagonal, in their eigenvectors.

    Attributes:
        scale: (parameters,) column norms of the whitened Jacobian.
        values: (parameters,) eigenvalues, ascending, and `vectors` (parameters, parameters), as columns.
        slope: (parameters,) the right-hand side along the eigenvectors.
        seen: (parameters,) which of them the data see.
    """

    scale: Array
    values: Array
    vectors: Array
    slope: Array
    seen: np.ndarray

    @classmethod
    def of(cls, sums: Sums) -> Normal:
        """The normal equations of sums."""
        return cls.of_gram(np.sum([kind.gram for kind in sums.values()], axis=0))

    @classmethod
    def of_gram(cls, gram: Array) -> Normal:
        """The normal equations of a whitened Jacobian's Gram matrix, the residual as its last row."""
        scale = np.sqrt(np.diag(gram)[:-1])
        scale = np.where(scale > 0.0, scale, 1.0)
        values, vectors = np.linalg.eigh(gram[:-1, :-1] / np.outer(scale, scale))
        seen = values > SEEN**2 * values[-1:]
        return cls(scale, values, vectors, vectors.T @ (gram[:-1, -1] / scale), seen)

    def step(self, damping: float) -> Array:
        """The damped step (parameters,), nothing along what is not seen."""
        along = np.where(self.seen, self.slope / np.where(self.seen, self.values + damping, 1.0), 0.0)
        return self.vectors @ along / self.scale

    @property
    def gain(self) -> float:
        """How much the undamped step would lower the sum of squares if all were linear."""
        return float((self.slope[self.seen] ** 2 / self.values[self.seen]).sum())

    @property
    def covariance(self) -> Array:
        """(parameters, parameters) of what is seen."""
        vectors = self.vectors[:, self.seen] / self.scale[:, None]
        return vectors / self.values[self.seen] @ vectors.T


def fit(
    model: Model | Partitioned,
    start: Array,
    on_step: Callable[[int, float], None] | None = None,
) -> Solution:
    """Minimise the sum of squared residuals, each over its variance, and fit the variances to the residuals, in turn.

    Args:
        model: predicts the data, in memory or in parts.
        start: displacements (parameters,) to start from.
        on_step: called with the number of steps and the sum of squares after each one.

    Raises:
        EquilibriumError: the robot at `start` does not settle under its load.
    """
    displacements, steps = start, 0
    sums = normal_sums(model, displacements, dict.fromkeys(KINDS, 1.0))
    variances: Variances = dict.fromkeys(sums, 1.0)
    weighed: Variances = {kind: found.misfit / found.count for kind, found in sums.items()}
    for _ in range(MAX_REWEIGHTINGS):
        sums = reweighed(model, displacements, sums, variances, weighed)
        variances = weighed
        displacements, sums, taken, converged = descend(model, displacements, sums, variances, on_step)
        steps += taken
        weighed = estimate_variances(sums, variances)
        if not converged or (taken == 0 and _same_weights(sums, variances, weighed)):
            break
    else:
        converged = False
    return Solution(displacements, reweighed(model, displacements, sums, variances, weighed), weighed, steps, converged)


def descend(
    model: Model | Partitioned,
    displacements: Array,
    sums: Sums,
    variances: Variances,
    on_step: Callable[[int, float], None] | None = None,
    most: int = MAX_STEPS,
) -> tuple[Array, Sums, int, bool]:
    """Levenberg's and Marquardt's method on fixed weights; undamped as long as that goes down; at most `most` steps.

    Returns:
        Displacements, the sums there, how many steps were tried, and whether they came to rest.
    """
    normal, misfit, damping = Normal.of(sums), misfit_of(sums), 0.0
    for step in range(most):
        if normal.gain <= max(STEP_LEFT, 1e-13 * misfit):
            return displacements, sums, step, True
        trial = displacements + normal.step(damping)
        try:
            found = normal_sums(model, trial, variances)
            better = misfit_of(found) < misfit * (1.0 + 1e-13)
        except EquilibriumError:
            better = False
        if better:
            displacements, sums, normal, misfit = trial, found, Normal.of(found), misfit_of(found)
            damping = damping / 10.0 if damping > 1e-6 else 0.0
            if on_step is not None:
                on_step(step + 1, misfit)
        else:
            damping = max(10.0 * damping, 1e-3)
            if damping > 1e12:
                return displacements, sums, step, False
    return displacements, sums, most, False


def estimate_variances(sums: Sums, variances: Variances) -> Variances:
    """Model variances with which each kind's sum of squares is what its degrees of freedom let expect.

    With the mean variance v of a kind, s2 + v (misfit / freedom - 1) is exact where no standard deviations are stated,
    and a fixed-point step of the moment estimator otherwise; never below zero. Freedom: the number of coordinates less
    the trace of their share in the hat matrix.
    """
    covariance = Normal.of(sums).covariance
    estimated = {}
    for kind, found in sums.items():
        freedom = found.count - float(np.einsum("ij,ji->", covariance, found.gram[:-1, :-1]))
        if freedom < 0.5:
            estimated[kind] = variances[kind]
            continue
        estimated[kind] = max(variances[kind] + found.variance * (found.misfit / freedom - 1.0), 0.0)
    return estimated


def _same_weights(sums: Sums, old: Variances, new: Variances) -> bool:
    """Whether the weights kept their proportions to 1 %; where none are stated, a common factor changes nothing."""
    changes = [np.log((s.variance + new[k] - old[k] + FLOOR) / (s.variance + FLOOR)) for k, s in sums.items()]
    if any(found.stated for found in sums.values()):
        return max(abs(change) for change in changes) < 0.01
    return max(changes) - min(changes) < 0.01
