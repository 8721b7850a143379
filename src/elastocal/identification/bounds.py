"""Compliances kept from becoming negative: an active set of those held at zero."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from elastocal.identification.solver import Normal
from elastocal.identification.sums import normal_sums
from elastocal.identification.transition import Problem, Trial
from elastocal.parameters import Group, parameters_of

Fit = Callable[[Problem], Trial]


def fit_non_negative(problem: Problem, fit: Fit) -> tuple[Trial, tuple[str, ...]]:
    """Fit with all compliances at least zero; the cubic's c3, which is the change of one, is left free.

    While a compliance comes out negative, the most significantly negative one is held at zero; one that would rise if
    it were let go is let go (Lawson and Hanson's conditions for non-negative least squares).

    Args:
        problem: to be fitted.
        fit: fits it.

    Returns:
        The fit, and the names of the parameters held at zero.
    """
    parameters = parameters_of(problem.robot)
    bounded = [n for n in problem.names if parameters[n].group == Group.COMPLIANCE and parameters[n].power == 1]
    held: tuple[str, ...] = ()
    for _ in range(3 * len(bounded) + 1):
        trial = fit(_holding(problem, held))
        negative = _most_negative(trial, [name for name in bounded if name not in held])
        if negative is not None:
            held = (*held, negative)
            continue
        rising = _steepest(trial, held)
        if rising is None:
            break
        held = tuple(name for name in held if name != rising)
    return trial, held


def _holding(problem: Problem, held: tuple[str, ...]) -> Problem:
    """The problem with some compliances at zero and not identified."""
    values = {
        name: parameter.nominal or 0.0 for name, parameter in parameters_of(problem.robot).items() if name in held
    }
    kept = [i for i, name in enumerate(problem.names) if name not in held]
    return replace(
        problem,
        robot=problem.robot.displaced({name: -value for name, value in values.items()}),
        names=tuple(problem.names[i] for i in kept),
        start=problem.start[kept],
    )


def _most_negative(trial: Trial, names: list[str]) -> str | None:
    """The compliance that is the most of its standard deviations below zero; None if none is."""
    values = parameters_of(trial.model.displaced(trial.solution.displacements))
    spread = np.sqrt(np.diag(Normal.of(trial.solution.sums).covariance))
    below = {
        name: (values[name].nominal or 0.0) / max(float(spread[trial.model.names.index(name)]), 1e-300)
        for name in names
        if (values[name].nominal or 0.0) < 0.0
    }
    return min(below, key=lambda name: below[name]) if below else None


def _steepest(trial: Trial, held: tuple[str, ...]) -> str | None:
    """The held compliance whose rise would lower the misfit most; None if none would."""
    model = replace(trial.model, names=(*trial.model.names, *held))
    displacements = np.append(trial.solution.displacements, np.zeros(len(held)))
    gram = np.sum([s.gram for s in normal_sums(model, displacements, trial.solution.variances).values()], axis=0)
    first = len(trial.model.names)
    slopes = gram[-1, first:-1] / np.sqrt(np.maximum(np.diag(gram)[first:-1], 1e-300))
    rising = {name: slope for name, slope in zip(held, slopes.tolist(), strict=True) if slope > RISING}
    return max(rising, key=lambda name: rising[name]) if rising else None


RISING = 1e-3
"""A slope of the misfit, per standard deviation of the compliance if all else were known, below which it is level."""
