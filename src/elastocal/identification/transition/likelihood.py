"""Confidence intervals of transition torques, by profile likelihood.

The misfit as a function of one torque, the others and all else at their best beside it, rises by less than the square
of Student's quantile times the variance within the interval. It has kinks where a torque passes a load, so a parabola
about the best torque, which is what a covariance says, would be too narrow.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.identification.transition.grid import Grid
from elastocal.identification.transition.profile import Profile, profile_of
from elastocal.identification.transition.trial import Problem, Trial

FINE = 60
"""Torques across the interval of a hinge, to look closer."""

OTHERS = 40
"""Torques of each other element that are tried beside one's where all pairs would be too many."""

Interval = tuple[float, float]


def torque_intervals(problem: Problem, trial: Trial, reach: float) -> dict[str, Interval]:
    """Intervals of transition torques by element; they end at 0 or at infinity where the data do not end them.

    Args:
        problem: at the fit.
        trial: the fit.
        reach: Student's quantile.
    """
    limit = reach**2 * _variance(trial)
    closer = replace(problem, grids=_closer(problem, trial, limit))
    rises = _rises(closer, trial)
    return {e: _interval(grid, rises[e], limit) for e, grid in closer.grids.items()}


def _variance(trial: Trial) -> float:
    """What the fit leaves of the variance that it was weighed by."""
    sums = trial.solution.sums
    freedom = sum(found.count for found in sums.values()) - len(trial.model.names) - len(trial.torques)
    left = trial.misfit / max(freedom, 1.0)
    return max(left, 1.0) if any(found.stated for found in sums.values()) else left


def _closer(problem: Problem, trial: Trial, limit: float) -> Mapping[str, Grid]:
    """The grids, of hinges with more torques where the coarse ones rise to the limit."""
    if not any(grid.smooth for grid in problem.grids.values()):
        return problem.grids
    rises, found = _rises(problem, trial), dict(problem.grids)
    for element, grid in problem.grids.items():
        if grid.smooth:
            within = np.flatnonzero(rises[element] <= limit)
            low, high = max(int(within[0]) - 1, 0), min(int(within[-1]) + 1, len(grid.torques) - 1)
            fine = np.linspace(grid.torques[low], grid.torques[high], FINE + 1)
            outer = grid.torques[[0, -1]]
            found[element] = replace(grid, torques=np.unique(np.concatenate([outer, fine])), whole=False)
    return found


def _rises(problem: Problem, trial: Trial) -> dict[str, Array]:
    """The misfit above its least at each torque of each element, the others at their best beside it."""
    model = problem.model(problem.torques)
    profile = profile_of(model, problem.start, problem.variances, problem.laws, problem.grids)
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
