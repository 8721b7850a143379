"""Confidence intervals of transition torques, by profile likelihood.

The misfit as a function of one torque, the others and all else at their best beside it, rises by less than so many
times the variance within the interval: of a hinge by the square of Student's quantile, of a step by more. It has kinks
where a torque passes a load, so a parabola about the best torque, which is what a covariance says, would be too narrow.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.elasticity import STEP
from elastocal.identification.transition.grid import Grid
from elastocal.identification.transition.profile import Profile, profile_of
from elastocal.identification.transition.trial import Problem, Trial

STEP_RISE = 7.35
"""Of many loads, the sum of squares at a step's true torque is in 95 of 100 cases less than this above the least: to
both sides it is a random walk, whose highest points are exponential (Hansen, 2000)."""

MANY = 1.96
"""Student's quantile with any number of degrees of freedom."""

FINE = 60
"""Torques across the interval of a hinge, to look closer."""

OTHERS = 40
"""Torques of each other element that are tried beside one's where all pairs would be too many."""

KEPT, KEPT_NEAR, KEPT_OF_PAIR = 120, 40, 60
"""Torques of a curve that are kept: over its whole range, and to both sides of the best one; and of each of a pair."""

Interval = tuple[float, float]


@dataclass(frozen=True)
class TorqueCurve:
    """The misfit at transition torques of one element, all else at its best beside each.

    Attributes:
        torques: (k,) ascending [N m or N], some of those that were compared.
        rises: (k,) above the least, in units of the variance that the best fit leaves: what chi-square rises by.
    """

    torques: tuple[float, ...]
    rises: tuple[float, ...]


@dataclass(frozen=True)
class TorqueMap:
    """The same at pairs of transition torques of two elements.

    Attributes:
        elements: the two.
        torques: of each, ascending [N m or N].
        rises: (first's torques, second's torques).
    """

    elements: tuple[str, str]
    torques: tuple[tuple[float, ...], tuple[float, ...]]
    rises: tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class Likelihood:
    """What the data say of transition torques.

    Attributes:
        intervals: by element; they end at 0 or at infinity where the data do not end them.
        curves: by element.
        pair: of two elements; None of any other number.
    """

    intervals: Mapping[str, Interval]
    curves: Mapping[str, TorqueCurve]
    pair: TorqueMap | None = None


def allowed_rise(law: str, reach: float) -> float:
    """How far the misfit rises, in units of the variance, within a 95 % interval of a law's torque.

    Args:
        law: step or hinge.
        reach: Student's quantile.
    """
    return STEP_RISE * (reach / MANY) ** 2 if law == STEP.name else reach**2


def torque_likelihood(problem: Problem, trial: Trial, reach: float) -> Likelihood:
    """Intervals of transition torques, and the misfit that they come from.

    Args:
        problem: at the fit.
        trial: the fit.
        reach: Student's quantile.
    """
    variance = _variance(trial)
    limits = {element: allowed_rise(law, reach) * variance for element, law in problem.laws.items()}
    closer = replace(problem, grids=_closer(problem, trial, limits))
    profile = _profile(closer)
    rises = _rises(profile, closer, trial)
    return Likelihood(
        intervals={e: _interval(grid, rises[e], limits[e]) for e, grid in closer.grids.items()},
        curves={e: _curve(grid.torques, rises[e] / variance) for e, grid in closer.grids.items()},
        pair=_pair(profile, closer, variance) if len(closer.grids) == 2 else None,
    )


def _profile(problem: Problem) -> Profile:
    model = problem.model(problem.torques)
    return profile_of(model, problem.start, problem.variances, problem.laws, problem.grids)


def _curve(torques: Array, rises: Array) -> TorqueCurve:
    """A curve thinned to what can be seen of it."""
    best = int(np.argmin(rises))
    near = np.arange(max(best - KEPT_NEAR, 0), min(best + KEPT_NEAR + 1, len(torques)))
    kept = np.unique(np.append(np.linspace(0, len(torques) - 1, KEPT).astype(int), near))
    return TorqueCurve(tuple(torques[kept].tolist()), tuple(rises[kept].tolist()))


def _pair(profile: Profile, problem: Problem, variance: float) -> TorqueMap:
    """The misfit at pairs of torques, at the best pair and so many others."""
    misfits = profile.all_misfits()
    best = np.unravel_index(int(np.argmin(misfits)), misfits.shape)
    kept = [
        np.unique(np.append(np.linspace(0, count - 1, KEPT_OF_PAIR).astype(int), at))
        for count, at in zip(misfits.shape, best, strict=True)
    ]
    first, second = (tuple(g.torques[k].tolist()) for g, k in zip(problem.grids.values(), kept, strict=True))
    one, other = problem.grids
    rises = (misfits[np.ix_(*kept)] - misfits[best]) / variance
    return TorqueMap((one, other), (first, second), tuple(map(tuple, rises.tolist())))


def _variance(trial: Trial) -> float:
    """What the fit leaves of the variance that it was weighed by."""
    sums = trial.solution.sums
    freedom = sum(found.count for found in sums.values()) - len(trial.model.names) - len(trial.torques)
    left = trial.misfit / max(freedom, 1.0)
    return max(left, 1.0) if any(found.stated for found in sums.values()) else left


def _closer(problem: Problem, trial: Trial, limits: Mapping[str, float]) -> Mapping[str, Grid]:
    """The grids, of hinges with more torques where the coarse ones rise to the limit."""
    if not any(grid.smooth for grid in problem.grids.values()):
        return problem.grids
    rises, found = _rises(_profile(problem), problem, trial), dict(problem.grids)
    for element, grid in problem.grids.items():
        if grid.smooth:
            within = np.flatnonzero(rises[element] <= limits[element])
            low, high = max(int(within[0]) - 1, 0), min(int(within[-1]) + 1, len(grid.torques) - 1)
            fine = np.linspace(grid.torques[low], grid.torques[high], FINE + 1)
            outer = grid.torques[[0, -1]]
            found[element] = replace(grid, torques=np.unique(np.concatenate([outer, fine])), whole=False)
    return found


def _rises(profile: Profile, problem: Problem, trial: Trial) -> dict[str, Array]:
    """The misfit above its least at each torque of each element, the others at their best beside it."""
    best = [int(np.argmin(np.abs(g.torques - trial.torques[e]))) for e, g in problem.grids.items()]
    found = [_profiled(profile, e, np.array(best)) for e in range(len(best))]
    least = min(float(misfits.min()) for misfits in found)
    return {element: misfits - least for element, misfits in zip(problem.grids, found, strict=True)}


def _profiled(profile: Profile, element: int, best: NDArray[np.intp]) -> Array:
    """The least misfit at each torque of one element; of more than two, the others are exchanged one by one."""
    if len(profile.counts) <= 2:
        misfits = profile.all_misfits()
        return misfits if misfits.ndim == 1 else misfits.min(axis=1 - element)
    count = profile.counts[element]
    chosen = np.repeat(best[None], count, axis=0)
    chosen[:, element] = np.arange(count)
    for other, most in enumerate(profile.counts):
        if other == element:
            continue
        tried = np.unique(np.append(np.linspace(0, most - 1, OTHERS).astype(int), best[other]))
        combinations = np.repeat(chosen, len(tried), axis=0)
        combinations[:, other] = np.tile(tried, count)
        chosen[:, other] = tried[profile.misfits(combinations).reshape(count, -1).argmin(axis=1)]
    return profile.misfits(chosen)


def _interval(grid: Grid, rise: Array, limit: float) -> Interval:
    """Where the rise stays below the limit: to the edges of a step's gaps, between the torques of a hinge."""
    within = np.flatnonzero(rise <= limit)
    first, last = int(within[0]), int(within[-1])
    torques, sizes = grid.torques, np.sort(grid.loads)
    if not grid.smooth:
        low, high = sizes[sizes < torques[first]], sizes[sizes >= torques[last]]
        ends = float(low[-1]) if len(low) else 0.0, float(high[0]) if len(high) else np.inf
    else:
        ends = _crossing(torques, rise, first, -1, limit), _crossing(torques, rise, last, 1, limit)
    return 0.0 if first == 0 else ends[0], np.inf if last == len(torques) - 1 else ends[1]


def _crossing(torques: Array, rise: Array, inner: int, step: int, limit: float) -> float:
    """Where the rise crosses the limit between a torque and its neighbour."""
    outer = inner + step
    if not 0 <= outer < len(torques):
        return float(torques[inner])
    share = (limit - rise[inner]) / (rise[outer] - rise[inner])
    return float(torques[inner] + share * (torques[outer] - torques[inner]))
