"""What the data say of the transition torques found."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from elastocal.elasticity import HINGE
from elastocal.identification.transition.grid import SAME, group_starts
from elastocal.identification.transition.likelihood import (
    Interval,
    Likelihood,
    TorqueCurve,
    TorqueMap,
    torque_likelihood,
)
from elastocal.identification.transition.profile import profile_of
from elastocal.identification.transition.search import Search
from elastocal.identification.transition.trial import Problem, Trial


@dataclass(frozen=True)
class TransitionData:
    """The data on both sides of a transition torque.

    Attributes:
        spread: standard deviation of the torque [N m or N] as the misfit at all others weighs them; 0 if it was given.
        gap: the largest load below it and the smallest above it [N m or N].
        below, above: how many different loads there are on each side.
        searched: whether the torque was searched; else it was given.
        interval: that covers the true torque with 95 % confidence; None if it was given.
        curve: the misfit at other torques; None if it was given.
    """

    spread: float
    gap: tuple[float, float]
    below: int
    above: int
    searched: bool
    interval: Interval | None = None
    curve: TorqueCurve | None = None


def transitions_of(
    problem: Problem, trial: Trial, search: Search | None, reach: float = 1.96
) -> tuple[dict[str, TransitionData], TorqueMap | None]:
    """The data on both sides of a fit's transition torques, by element; the misfit at all pairs of two such torques.

    Args:
        problem: that was fitted.
        trial: the fit.
        search: how the torques were found.
        reach: so many standard deviations an interval reaches to both sides.
    """
    searched = search is not None and search.method != "given"
    fitted = replace(problem.after(trial), variances=trial.solution.variances)
    spreads = _spreads(fitted, trial) if searched else dict.fromkeys(trial.torques, 0.0)
    told = torque_likelihood(fitted, trial, reach) if searched else Likelihood({}, {})
    found = {}
    for element, torque in trial.torques.items():
        sizes = np.sort(np.abs(trial.loads[element]))
        below, above, least = sizes[sizes < torque], sizes[sizes >= torque], SAME * float(sizes[-1])
        gap = float(below[-1]) if len(below) else 0.0, float(above[0]) if len(above) else float("inf")
        found[element] = TransitionData(
            spreads[element],
            gap,
            len(group_starts(below, least)),
            len(group_starts(above, least)),
            searched,
            told.intervals.get(element),
            told.curves.get(element),
        )
    return found, told.pair


def _spreads(problem: Problem, trial: Trial) -> dict[str, float]:
    """Standard deviations of transition torques: each weighed by its likelihood, the other elements' as they are.

    The misfit is in units of the variance that the best fit leaves, and each torque stands for its gap between loads.
    """
    profile = profile_of(problem.model(problem.torques), problem.start, problem.variances, problem.laws, problem.grids)
    grids = list(problem.grids.values())
    at = [int(np.argmin(np.abs(g.torques - t))) for g, t in zip(grids, trial.torques.values(), strict=True)]
    freedom = sum(found.count for found in trial.solution.sums.values()) - len(trial.model.names)
    spreads = {}
    for e, (element, grid) in enumerate(problem.grids.items()):
        tried = np.repeat([at], len(grid.torques), axis=0)
        tried[:, e] = np.arange(len(grid.torques))
        misfits = profile.misfits(tried)
        rise = (misfits - misfits.min()) / (max(float(misfits.min()), 1e-300) / max(freedom, 1))
        low, high = trial.gaps.get(element, (0.0, 0.0))
        only = np.array([(high - low) or float(np.ptp(grid.loads)) or 1.0])
        width = np.gradient(grid.torques) if len(grid.torques) > 1 else only
        weights = width * np.exp(-0.5 * rise)
        weights /= weights.sum()
        mean = weights @ grid.torques
        within = max(float(weights @ width**2), (high - low) ** 2) / 12.0
        spreads[element] = float(np.sqrt(weights @ (grid.torques - mean) ** 2 + within))
    return spreads


def free_torques(trial: Trial, search: Search | None) -> tuple[str, ...]:
    """Names of the transition torques that the misfit follows smoothly: those of hinges, unless they are given."""
    if search is None or search.method == "given":
        return ()
    elastic = trial.model.robot.elastic
    return tuple(f"{element}.transition_torque" for element in trial.torques if elastic[element].law == HINGE.name)
