"""Studentised deletion residuals: how far each row is from where the fit of the others predicts it.

A row is accused if it is so far off that, were all rows good, one such row would be found in one of a hundred data
sets: F test of its deletion residual, Bonferroni's level over the rows (Cook and Weisberg, 1982).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.identification.attempt import Attempt
from elastocal.identification.evidence import PRIOR
from elastocal.identification.influence import influence
from elastocal.identification.solver import Normal, Solution
from elastocal.identification.sums import misfit_of
from elastocal.measurements import Measurements
from elastocal.prediction import Model

LEVEL = 0.01
"""Probability of accusing any row of a data set without outliers."""

TRIFLE = 1e-5
"""A smaller residual is no gross error, however exact the others are [m or rad]."""

Rows = NDArray[np.bool_]


@dataclass(frozen=True)
class Scores:
    """How far rows are from where the fit of the others predicts them.

    Attributes:
        values: (n,) root of F: the deletion residual over its standard deviation, root mean square over the row's
            coordinates; about 1 for a good row, infinite where the row decides a parameter alone.
        accused: (n,) which rows are outliers by the rule.
        left_out: by kind, residuals (n, 3 or 1) under the fit without the row [m or rad].
    """

    values: Array
    accused: Rows
    left_out: dict[str, Array]


def scores_of(fitted: Attempt, data: Measurements, good: Rows) -> Scores:
    """The scores of all rows under a fit of the good ones.

    Raises:
        EquilibriumError: a row does not settle under its load.
    """
    searched = fitted.search is not None and fitted.search.method != "given"
    torques = len(fitted.trial.torques) if searched else 0
    if good.all():
        return scores(fitted.model, fitted.solution, torques)
    found = [
        scores(replace(fitted.model, data=data, sides=sides, weights=good.astype(float)), fitted.solution, torques)
        for sides in _possible_sides(fitted, data, good)
    ]
    best = np.argmin([one.values for one in found], axis=0)
    rows = np.arange(len(data))
    left_out = {kind: np.array([one.left_out[kind] for one in found])[best, rows] for kind in found[0].left_out}
    values, accused = (np.array([getattr(one, name) for one in found])[best, rows] for name in ("values", "accused"))
    return Scores(values, accused, left_out)


def _possible_sides(fitted: Attempt, data: Measurements, good: Rows) -> Iterator[dict[str, Array]]:
    """By element with a step, loads that decide the sides of all rows: of the good ones those of the fit.

    On which side a row lies that is left out is not known where its load lies in the gap between the good rows'.
    """
    trial = fitted.trial
    rest = Model(trial.model.robot, trial.model.names, data.take(np.flatnonzero(~good)))
    own = rest.undeflected_loads(trial.solution.displacements) if trial.model.sides else {}
    given = fitted.search is not None and fitted.search.method == "given"
    gaps = {} if given else trial.gaps
    between = {e: (np.abs(own[e]) > low) & (np.abs(own[e]) < high) for e, (low, high) in gaps.items()}
    open_gaps = [element for element, rows in between.items() if rows.any()]
    for edges in product((0, 1), repeat=len(open_gaps)):
        loads = dict(own)
        for element, edge in zip(open_gaps, edges, strict=True):
            loads[element] = np.where(between[element], gaps[element][edge], own[element])
        sides = {}
        for element, frozen in trial.model.sides.items():
            sides[element] = np.empty(len(data))
            sides[element][good], sides[element][~good] = frozen, loads[element]
        yield sides


def scores(model: Model, solution: Solution, torques: int = 0, exact_variance: bool = False) -> Scores:
    """The scores of all rows of a model under a fit with its weights.

    Args:
        model: of all rows.
        solution: its fit, or that of the rows with a weight.
        torques: how many parameters were searched beside those that were stepped along.
        exact_variance: whether the fit's variances are what the residuals are to be measured by; else what the good
            rows leave is.
    """
    n, sums = len(model.data), {kind: found for kind, found in solution.sums.items() if kind != PRIOR}
    covariance, misfit = Normal.of(solution.sums).covariance, misfit_of(sums)
    found = influence(model, solution.displacements, covariance, solution.variances, np.arange(n))
    gain, count = np.where(np.isfinite(found.gain), found.gain, misfit), found.coordinates
    inside = np.ones(n, dtype=bool) if model.weights is None else model.weights > 0.0
    told = sum(float((covariance * found.gram[:-1, :-1]).sum()) for found in sums.values())
    freedom = sum(found.count for found in sums.values()) - told - torques
    left = np.maximum(misfit - np.where(inside, gain, 0.0), 0.0) / np.maximum(freedom - np.where(inside, count, 0), 1.0)
    variance = np.ones(n) if exact_variance else left
    values = np.where(np.isfinite(found.gain), np.sqrt(gain / count / np.maximum(variance, 1e-300)), np.inf)
    least = np.full(int(count.max(initial=0)) + 1, np.inf)
    for c in np.unique(count).tolist():
        least[c] = least_score(c, freedom - c, LEVEL / n)
    sizes = np.max([np.nan_to_num(np.abs(r), posinf=0.0).max(axis=1) for r in found.left_out.values()], axis=0)
    beyond = (values > least[count]) & np.isfinite(values)
    return Scores(values, beyond & (sizes > TRIFLE), found.left_out)


def least_score(coordinates: int, freedom: float, tail: float) -> float:
    """The root of the F value that is exceeded with probability `tail`; infinite without degrees of freedom."""
    from scipy.special import fdtri  # imported late: it takes longer than a calibration

    return np.inf if freedom < 1.0 else float(np.sqrt(fdtri(coordinates, freedom, 1.0 - tail)))
