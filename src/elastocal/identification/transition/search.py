"""The search for the transition torques of steps and hinges."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from elastocal.chain import Array
from elastocal.errors import EquilibriumError
from elastocal.identification.solver import fit
from elastocal.identification.sums import misfit_of, normal_sums
from elastocal.identification.transition.candidates import best_combinations
from elastocal.identification.transition.grid import grids_of
from elastocal.identification.transition.likelihood import TorqueMap
from elastocal.identification.transition.profile import Profile, profile_of
from elastocal.identification.transition.trial import Problem, Trial, fit_at, polished
from elastocal.measurements import Measurements
from elastocal.prediction import Model
from elastocal.robot import Compliance, Robot

BEST = 3
"""Combinations of a profile that are fitted with the full iteration, and how much more than the best one's misfit their
misfit may be."""
WORTH = 1.05

MAX_ROUNDS = 5

WORTHLESS = 1e-4
"""A misfit that is lower by less than this share is no better."""

ZOOMS = 2
"""How often the neighbourhood of a torque is looked at more closely."""


@dataclass(frozen=True)
class Search:
    """How transition torques were found.

    Attributes:
        method: "exact", "ga" or "given".
        proven: whether all allowed combinations were compared; else it is the best one found.
        fits: how many combinations were fitted with the full iteration.
        history: the best fitness of each generation of a genetic algorithm: root mean square of the weighed residuals,
            in units of that of the fit with linear laws.
        seconds: what it took after the fit with linear laws.
        pair: the misfit at pairs of torques, where two were searched.
    """

    method: str
    proven: bool
    fits: int
    history: tuple[float, ...] = ()
    seconds: float = 0.0
    pair: TorqueMap | None = None


def problem_of(
    robot: Robot, names: tuple[str, ...], data: Measurements, laws: Mapping[str, str], weights: Array | None = None
) -> Problem:
    """The start of all fits: the fit with linear laws on the elements of `laws`; the robot as it is if there are none.

    Args:
        robot: with the laws of `laws` on its elements.
        names: the identified parameters, both coefficients of each of these elements among them.
        data: the rows to fit.
        laws: step or hinge, by element.
        weights: (n,) how much each row counts; None: all one.

    Raises:
        EquilibriumError: the robot does not settle.
    """
    if not laws:
        return Problem(robot, names, data, {}, {}, 0.0, np.zeros(len(names)), {}, {}, {}, weights)
    model = replace(linear_model(robot, names, data, laws), weights=weights)
    solution = fit(model, np.zeros(len(model.names)))
    found = dict(zip(model.names, solution.displacements.tolist(), strict=True))
    for element in laws:
        for key, known in zip(("c_low", "c_high"), robot.elastic[element].coefficients, strict=True):
            found[f"{element}.{key}"] = found[f"{element}.c"] - known
    loads = model.undeflected_loads(solution.displacements)
    grids = grids_of(loads, laws)
    middle = {element: float(np.median(grid.torques)) for element, grid in grids.items()}
    start = np.array([found[name] for name in names])
    misfit = misfit_of(normal_sums(model, solution.displacements, solution.variances))
    return Problem(robot, names, data, laws, solution.variances, misfit, start, middle, loads, grids, weights)


def linear_model(robot: Robot, names: tuple[str, ...], data: Measurements, laws: Mapping[str, str]) -> Model:
    """The model with linear laws on the elements of `laws`; see `problem_of`."""
    elastic = {**robot.elastic, **{element: Compliance.rigid("linear") for element in laws}}
    kept = [name for name in names if name.rpartition(".")[0] not in laws] + [f"{element}.c" for element in laws]
    return Model(replace(robot, elastic=elastic), tuple(kept), data)


def search_exactly(problem: Problem, seed: int = 0) -> tuple[Trial, Search]:
    """The combination of transition torques that fits best.

    All combinations are compared to first order about the fit with linear laws, and the best few fitted; then about the
    best of these, and so on until nothing improves.

    Args:
        problem: at the fit with linear laws.
        seed: of the starts, where there are more than two elements.

    Raises:
        EquilibriumError: the robot does not settle with the best combinations.
    """
    began = time.perf_counter()
    trials = _first_trials(problem, seed)
    best = min(trials, key=_misfit)
    for _ in range(MAX_ROUNDS):
        around = problem.after(best)
        found = fit_at(around, _closer(around, best_combinations(_profile(around), 1, seed)[0]))
        trials.append(found)
        if found.misfit > best.misfit * (1.0 - WORTHLESS):
            break
        best = found
    best = polished(problem, min(trials, key=_misfit))
    return best, Search("exact", len(problem.laws) <= 2, len(trials), seconds=time.perf_counter() - began)


def _misfit(trial: Trial) -> float:
    return trial.misfit


def _first_trials(problem: Problem, seed: int) -> list[Trial]:
    """The best combinations by their profile about the last fit, fitted; those that cannot become the best are not."""
    profile = _profile(problem)
    trials: list[Trial] = []
    failure = None
    for combination in best_combinations(profile, BEST, seed):
        expected = float(profile.misfits(np.array([combination]))[0])
        if trials and expected > WORTH * min(map(_misfit, trials)):
            break
        try:
            trials.append(fit_at(problem, problem.torques_of(combination)))
        except EquilibriumError as error:
            failure = error
    if failure and not trials:
        raise failure
    return trials


def _closer(problem: Problem, combination: Sequence[int]) -> dict[str, float]:
    """The best torques near a combination, where more lie between those of the grids."""
    for _ in range(ZOOMS):
        grids = {e: grid.zoomed(i) for (e, grid), i in zip(problem.grids.items(), combination, strict=True)}
        if all(grids[element] is problem.grids[element] for element in grids):
            break
        problem = replace(problem, grids=grids)
        combination = best_combinations(_profile(problem), 1)[0]
    return problem.torques_of(combination)


def _profile(problem: Problem) -> Profile:
    model = problem.model(problem.torques)
    return profile_of(model, problem.start, problem.variances, problem.laws, problem.grids)
