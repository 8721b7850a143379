"""Uncertainty by bootstrap: the same fit to many data sets that might have been measured at the same poses.

The wild bootstrap by pose (Wu, 1986; Davidson and Flachaire, 2008): every pose keeps its prediction, and its residuals,
made as large as errors are, with a sign by chance for the whole pose. Poses are not drawn again with replacement, since
a calibration has few of them for its many parameters: with 20 poses and 29 parameters such draws tell standard
deviations three times too large, and often not all parameters.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.errors import EquilibriumError, InputError
from elastocal.identification.attempt import Attempt
from elastocal.identification.influence import influence
from elastocal.identification.solver import Normal
from elastocal.identification.statistics import residuals
from elastocal.identification.sums import observation_variance, variance_of
from elastocal.identification.table import Estimates
from elastocal.identification.threads import one_thread
from elastocal.identification.transition import Trial
from elastocal.measurements import Measurements
from elastocal.parallel import in_order
from elastocal.parameters import parameters_of

FEWEST = 20
"""Fits, of which fewer tell no interval."""

Interval = tuple[float, float]


@dataclass(frozen=True)
class Bootstrap:
    """What fits to data sets that might have been measured say of parameters.

    Attributes:
        samples: how many there are.
        failed: how many came to no rest, which tell nothing.
        deviations: (fits, names) of the fits' parameters from the estimate; of small rotations for frames.
        names: the identified parameters, then the searched transition torques.
    """

    samples: int
    failed: int
    names: tuple[str, ...]
    deviations: Array

    @property
    def counts(self) -> dict[str, int]:
        """How many fits there are, and how many of them failed."""
        return {"fits": self.samples, "failed": self.failed}

    def estimates(self, linear: Estimates, trial: Trial) -> Estimates:
        """What a fit says of parameters, with these standard deviations instead of the linear ones.

        A step's torque is anywhere in its gap between loads, of which the fits know the middle only.

        Args:
            linear: the same by the linear covariance.
            trial: the fit.
        """
        transitions = dict(linear.transitions)
        for element, told in linear.transitions.items():
            name = f"{element}.transition_torque"
            if told.searched:
                low, high = (trial.torques[element] + end for end in self.interval(name))
                gap = trial.gaps.get(element, (low, low))
                spread = float(np.hypot(self.std(name), (gap[1] - gap[0]) / np.sqrt(12.0)))
                transitions[element] = replace(told, spread=spread, interval=(min(low, gap[0]), max(high, gap[1])))
        return replace(linear, covariance=self.covariance(linear.names), transitions=transitions)

    def covariance(self, names: tuple[str, ...]) -> Array:
        """The covariance (names, names) of some of the parameters."""
        chosen = self.deviations[:, [self.names.index(name) for name in names]]
        return np.atleast_2d(np.cov(chosen, rowvar=False))

    def interval(self, name: str) -> Interval:
        """From where to where a parameter's deviations reach in 95 % of the fits, about the estimate."""
        low, high = np.quantile(self.deviations[:, self.names.index(name)], [0.025, 0.975])
        return float(low), float(high)

    def std(self, name: str) -> float:
        """The standard deviation of a parameter."""
        return float(self.deviations[:, self.names.index(name)].std(ddof=1))


def require_samples(count: int, priors: bool) -> None:
    """Check that there are fits enough, or none, and no priors, which a bootstrap knows nothing of.

    Raises:
        InputError: there are too few, or joint maps or geometry are to be fitted with priors.
    """
    if count and count < FEWEST:
        raise InputError(f"bootstrap is {count}: expected 0 (none) or at least {FEWEST}, better 200 or more")
    if count and priors:
        raise InputError(
            "bootstrap: joint maps and --prior have priors, which a bootstrap knows nothing of: leave one of them out"
        )


def bootstrapped(
    found: Attempt,
    refit: Callable[[Measurements], Attempt],
    count: int,
    seed: int = 0,
    on_sample: Callable[[int, int], None] | None = None,
    executor: Executor | None = None,
) -> Bootstrap | None:
    """Fit as many data sets that might have been measured.

    Args:
        found: the fit.
        refit: from measurements to the fit to them, from the same robot as `found`.
        count: how many.
        seed: of the signs.
        on_sample: called with the number of fits done, and of all.
        executor: where the fits run; None: here, one after the other.

    Returns:
        None if not all parameters are identifiable, or hardly any fit came to rest.

    Raises:
        EquilibriumError: the robot found does not settle.
    """
    if not Normal.of(found.solution.sums).seen.all():
        return None
    rng = np.random.default_rng(seed)
    pose, size = _error_sizes(found)
    estimate = _values(found, found)
    signs = [rng.choice([-1.0, 1.0], len(size)).astype(np.int8) for _ in range(count)]
    fits = []
    for done, values in enumerate(in_order(partial(_refitted, found, refit, pose, size), signs, executor), start=1):
        if values is not None:
            fits.append([values[name] - estimate[name] for name in estimate])
        if on_sample is not None:
            on_sample(done, count)
    if len(fits) < FEWEST:
        return None
    return Bootstrap(count, count - len(fits), tuple(estimate), np.array(fits))


@one_thread
def _refitted(
    found: Attempt,
    refit: Callable[[Measurements], Attempt],
    pose: NDArray[np.intp],
    size: Array,
    signs: NDArray[np.int8],
) -> dict[str, float] | None:
    """What a fit to the predictions with errors of these signs by pose identifies; None if it comes to no rest."""
    try:
        fit = refit(_with_errors(found, found.model.data, (signs * size)[pose]))
    except EquilibriumError:
        return None
    return _values(found, fit) if fit.solution.converged else None


def _error_sizes(found: Attempt) -> tuple[NDArray[np.intp], Array]:
    """The pose of each row, and by how much the residuals of each pose are smaller than its errors.

    r . (1 - H)^-1 r is on average the sum of squares that a pose's errors have.
    """
    solution = found.solution
    of_pose = influence(found.model, solution.displacements, Normal.of(solution.sums).covariance, solution.variances)
    square = np.zeros(len(of_pose.gain))
    for part in found.model.parts(solution.displacements, derivatives=False):
        variance = observation_variance(found.model.data, part, variance_of(solution.variances, part))[:, 0]
        np.add.at(square, of_pose.pose[part.rows], (part.residual**2 / variance).sum(axis=0))
    known = np.isfinite(of_pose.gain) & (square > 0.0)
    return of_pose.pose, np.sqrt(np.where(known, of_pose.gain, 1.0) / np.where(known, square, 1.0))


def _with_errors(found: Attempt, data: Measurements, factor: Array) -> Measurements:
    """The predictions with `factor` (n,) times the residuals for errors."""
    errors = residuals(found.model.displaced(found.solution.displacements), data)
    more = factor - 1.0  # the observations have the residuals once
    position, orientation, distance = data.position, data.orientation, data.distance
    if position is not None and errors.position is not None:
        position = position + more[:, None] * errors.position
    if distance is not None and errors.distance is not None:
        distance = distance + more * errors.distance
    if orientation is not None and errors.orientation is not None:
        from scipy.spatial.transform import Rotation  # imported late: it takes longer than a calibration

        turns = Rotation.from_rotvec(np.nan_to_num(more[:, None] * errors.orientation)).as_matrix()
        orientation = turns @ orientation
    return replace(data, position=position, orientation=orientation, distance=distance)


def _values(found: Attempt, fit: Attempt) -> dict[str, float]:
    """Displacements of a fit from the robot that all begin with, and its transition torques, by name.

    A compliance that the fit holds at zero is there, since others may not.
    """
    own = dict(zip(fit.model.names, fit.solution.displacements.tolist(), strict=True))
    nominal = parameters_of(found.problem.robot)
    values = {name: own.get(name, -(nominal[name].nominal or 0.0)) for name in found.model.names}
    torques: Mapping[str, float] = fit.trial.torques
    return values | {f"{element}.transition_torque": torque for element, torque in torques.items()}
