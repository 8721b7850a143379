"""Marginal likelihood: variances of observations and of groups of parameters, estimated together with the parameters.

A group's parameters have a normal prior about zero displacement. With C the posterior covariance, the data tell
gamma = n - sum C_ii / s^2 of its n parameters, and its variance is s^2 = sum x_i^2 / gamma; a kind of observation has
the variance misfit / (N - trace of its share in the hat matrix) (MacKay 1992, Bayesian interpolation). Between two
passes over the data the model is taken as linear, so that all this is algebra of small matrices.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.identification.partitioned import Partitioned
from elastocal.identification.solver import Solution
from elastocal.identification.sums import FLOOR, KindSums, Sums, Variances, normal_sums
from elastocal.prediction import Model

NOTHING = 1e-20
"""A group's variance [its unit squared] below this is zero."""

LARGEST_CHANGE = 100.0
"""The factor by which a variance may change at once."""

MAX_ROUNDS, MAX_ITERATIONS = 10, 100

SHORT = 0.03
"""Root mean square of a step, in standard deviations, that changes nothing: the variances move it by more."""

LEAST_GAIN = 6.0
"""Log evidence that all groups together must gain: with eight groups of nothing but noise they gain about two."""

SETTLED = 0.01
"""Variances that change by less than this share have come to rest."""


@dataclass(frozen=True)
class Prior:
    """Normal priors about zero displacement, one variance for each group of parameters.

    Attributes:
        groups: names of the groups.
        member: (parameters,) group of each parameter; -1 for none.
        variances: (groups,) in the parameters' units squared.
        given: (groups,) which of the variances are not to be estimated.
        optional: (groups,) which of them are only there if the data show them.
        least: (groups,) variances that estimates do not go below.
    """

    groups: tuple[str, ...]
    member: NDArray[np.intp]
    variances: Array
    given: NDArray[np.bool_]
    optional: NDArray[np.bool_]
    least: Array

    @property
    def precision(self) -> Array:
        """(parameters,) inverse variance, zero without a prior."""
        return np.where(self.member >= 0, 1.0 / np.append(self.variances, 1.0)[self.member], 0.0)

    def take(self, chosen: NDArray[np.intp]) -> Prior:
        """The prior of some of the parameters."""
        return replace(self, member=self.member[chosen])

    def as_sums(self, displacements: Array) -> KindSums:
        """The prior as if each parameter had been observed to be where it started."""
        precision = self.precision
        gram = np.diag(np.append(precision, precision @ displacements**2))
        gram[-1, :-1] = gram[:-1, -1] = -precision * displacements
        return KindSums(gram, 0, 0.0, False)


@dataclass(frozen=True)
class Posterior:
    """The most likely variances of linearised observations, and the parameters with them.

    Attributes:
        step: (parameters,) to the most likely parameters.
        covariance: (parameters, parameters).
        factors: of the variance of each kind of observation.
        prior: with its variances.
        log_evidence: up to what is the same for all priors that leave the same parameters flat.
    """

    step: Array
    covariance: Array
    factors: Mapping[str, float]
    prior: Prior
    log_evidence: float


def most_likely(sums: Sums, displacements: Array, prior: Prior, iterations: int = MAX_ITERATIONS) -> Posterior:
    """Maximise the marginal likelihood of linearised observations.

    Args:
        sums: of the data at `displacements`. Kinds with stated deviations stay weighed as they are.
        displacements: (parameters,).
        prior: to start from.
        iterations: at most so many.
    """
    factors = dict.fromkeys(sums, 1.0)
    for _ in range(iterations):
        solved = _solved(sums, displacements, prior, factors)
        step, covariance, _ = solved
        new_factors = {kind: _new_factor(found, step, covariance, factors[kind]) for kind, found in sums.items()}
        new_prior = _with_variances(prior, displacements + step, covariance.diagonal())
        live = new_prior.variances > prior.least
        changes = np.abs(np.log(new_prior.variances / prior.variances))[live].tolist()
        changes += [abs(np.log(new_factors[kind] / factors[kind])) for kind in sums]
        factors, prior = new_factors, new_prior
        if max(changes, default=0.0) < SETTLED:
            break
    step, covariance, log_determinant = _solved(sums, displacements, prior, factors)
    at = displacements + step
    cost = sum(found.count * np.log(factors[k]) + _misfit(found, step) / factors[k] for k, found in sums.items())
    weights = prior.precision
    log_prior = np.log(weights[weights > 0.0]).sum() - weights @ at**2
    return Posterior(step, covariance, factors, prior, float(0.5 * (log_prior - cost - log_determinant)))


def _solved(sums: Sums, displacements: Array, prior: Prior, factors: Mapping[str, float]) -> tuple[Array, Array, float]:
    """Step, posterior covariance and ln det of its inverse, with given variances."""
    from scipy.linalg import cho_factor, cho_solve  # imported late: only fits with priors need it

    precision = prior.precision
    matrix = np.diag(precision) + sum(found.gram[:-1, :-1] / factors[kind] for kind, found in sums.items())
    right = sum(found.gram[:-1, -1] / factors[kind] for kind, found in sums.items()) - precision * displacements
    scale = np.sqrt(matrix.diagonal())
    factor = cho_factor(matrix / np.outer(scale, scale) + RIDGE * np.eye(len(scale)), lower=True)
    inverse = cho_solve(factor, np.eye(len(scale))) / np.outer(scale, scale)
    log_determinant = 2.0 * float(np.log(factor[0].diagonal()).sum() + np.log(scale).sum())
    return inverse @ right, inverse, log_determinant


RIDGE = 1e-13
"""Keeps the factorisation from failing where a flat parameter is hardly seen; of the scaled diagonal, which is one."""


def _misfit(found: KindSums, step: Array) -> float:
    """Sum of squares after a step, by the linear model."""
    gram = found.gram
    return float(gram[-1, -1] - 2.0 * gram[:-1, -1] @ step + step @ gram[:-1, :-1] @ step)


def _new_factor(found: KindSums, step: Array, covariance: Array, factor: float) -> float:
    freedom = found.count - float((covariance * found.gram[:-1, :-1]).sum()) / factor
    if found.stated or freedom < 0.5:
        return factor
    return float(np.clip(_misfit(found, step) / freedom, factor / LARGEST_CHANGE, factor * LARGEST_CHANGE))


def _with_variances(prior: Prior, at: Array, spread: Array) -> Prior:
    """The prior with the variances that parameters (n,) and their posterior variances (n,) ask for."""
    variances = prior.variances.copy()
    for group in np.flatnonzero(~prior.given):
        mine = prior.member == group
        told = mine.sum() - spread[mine].sum() / variances[group]
        wanted = (at[mine] ** 2).sum() / told if told > 1e-6 else 0.0
        wanted = np.clip(wanted, variances[group] / LARGEST_CHANGE, variances[group] * LARGEST_CHANGE)
        variances[group] = max(float(wanted), float(prior.least[group]))
    return replace(prior, variances=variances)


def fit_by_evidence(
    model: Model | Partitioned, start: Array, prior: Prior, variances: Variances
) -> tuple[Solution, Posterior]:
    """Fit parameters, the variances of observations and those of the prior's groups.

    Args:
        model: predicts the data.
        start: displacements (parameters,) from which the model is all but linear.
        prior: to start from.
        variances: model variances to start from.

    Returns:
        The fit, with the prior among its sums, and the most likely variances about it.

    Raises:
        EquilibriumError: the robot does not settle under its load.
    """
    displacements, rounds, converged = start, 0, False
    sums = normal_sums(model, displacements, variances)
    while rounds < MAX_ROUNDS and not converged:
        found = most_likely(sums, displacements, prior)
        if not rounds:
            found = _if_worth_it(sums, displacements, found)
        converged = bool(np.mean(found.step**2 / found.covariance.diagonal()) < SHORT**2)
        displacements, prior, rounds = displacements + found.step, found.prior, rounds + 1
        variances = {**variances, **{kind: _next_variance(variances[kind], sums[kind], kind, found) for kind in sums}}
        sums = normal_sums(model, displacements, variances)
    with_prior = {**sums, PRIOR: prior.as_sums(displacements)}
    return Solution(displacements, with_prior, variances, rounds, converged), found


def _if_worth_it(sums: Sums, displacements: Array, found: Posterior) -> Posterior:
    """The posterior, or the one with all optional groups at zero if they gain no more evidence than noise does."""
    prior = found.prior
    if not prior.optional.any():
        return found
    variances = np.where(prior.optional, NOTHING, prior.variances)
    without = replace(prior, variances=variances, given=prior.given | prior.optional)
    nothing = most_likely(sums, displacements, without)
    return found if found.log_evidence - nothing.log_evidence > LEAST_GAIN else nothing


PRIOR = "prior"
"""Its key among the sums of a fit."""


def with_prior_of(before: Sums, sums: Sums) -> Sums:
    """Sums of more parameters, with the prior that was among those of the first ones."""
    if PRIOR not in before:
        return sums
    gram = before[PRIOR].gram
    more = len(next(iter(sums.values())).gram) - len(gram)
    widened = np.insert(np.insert(gram, [len(gram) - 1] * more, 0.0, axis=0), [len(gram) - 1] * more, 0.0, axis=1)
    return {**sums, PRIOR: replace(before[PRIOR], gram=widened)}


def _next_variance(variance: float, found: KindSums, kind: str, posterior: Posterior) -> float:
    """The model variance of a kind: beside stated deviations by the moment estimator, else by its factor."""
    if not found.stated:
        return max(variance, FLOOR) * posterior.factors[kind]
    freedom = found.count - float((posterior.covariance * found.gram[:-1, :-1]).sum())
    excess = _misfit(found, posterior.step) / freedom - 1.0 if freedom > 0.5 else 0.0
    return max(variance + found.variance * excess, 0.0)
