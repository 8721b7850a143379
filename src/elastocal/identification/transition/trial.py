"""One choice of transition torques, fitted with the full iteration."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from elastocal.chain import Array
from elastocal.elasticity import STEP
from elastocal.errors import EquilibriumError
from elastocal.identification.solver import Solution, descend, fit
from elastocal.identification.sums import Variances, misfit_of, normal_sums
from elastocal.identification.transition.grid import Grid, grids_of
from elastocal.measurements import Measurements
from elastocal.parameters import parameters_of
from elastocal.prediction import Model
from elastocal.robot import Robot

MAX_PASSES = 5
"""Fits of one choice, each with the sides that the one before has led to."""

HINGE_STEPS = 6
"""Steps with the torques of hinges free: enough where the misfit is smooth, few where they stall on a kink."""


@dataclass(frozen=True)
class Problem:
    """What is fitted, and the fit that the next one starts from.

    Attributes:
        robot: with the laws on its elements.
        names: the identified parameters.
        data: the rows to fit.
        laws: step or hinge, by element whose transition torque is searched.
        variances: the model variances that the search weighs by.
        misfit: the sum of squares so weighed of the fit with linear laws.
        start: displacements (names,) of the last fit.
        torques: its transition torques, by element.
        loads: its loads of the undeflected configuration, (n,) by element: they decide the sides of the next one.
        grids: the transition torques that these loads allow, by element.
        weights: (n,) how much each row counts; None: all one.
    """

    robot: Robot
    names: tuple[str, ...]
    data: Measurements
    laws: Mapping[str, str]
    variances: Variances
    misfit: float
    start: Array
    torques: Mapping[str, float]
    loads: Mapping[str, Array]
    grids: Mapping[str, Grid]
    weights: Array | None = None

    def model(self, torques: Mapping[str, float]) -> Model:
        """The robot with these transition torques, the sides of steps frozen."""
        elastic = dict(self.robot.elastic)
        for element, torque in torques.items():
            elastic[element] = replace(elastic[element], transition_torque=torque)
        steps = [e for e, found in elastic.items() if found.law == STEP.name and e in self.loads]
        robot = replace(self.robot, elastic=elastic)
        return Model(robot, self.names, self.data, {element: self.loads[element] for element in steps}, self.weights)

    def torques_of(self, combination: Iterable[int]) -> dict[str, float]:
        """The transition torques by element, from their numbers in the grids."""
        return {e: float(grid.torques[int(i)]) for (e, grid), i in zip(self.grids.items(), combination, strict=True)}

    def after(self, trial: Trial) -> Problem:
        """The problem with a trial as the fit that the next one starts from."""
        moved = dict(zip(trial.model.names, trial.solution.displacements.tolist(), strict=True))
        parameters = parameters_of(self.robot)
        at_zero = {name: -(parameters[name].nominal or 0.0) for name in self.names if name not in moved}  # held there
        start, grids = np.array([{**moved, **at_zero}[name] for name in self.names]), grids_of(trial.loads, self.laws)
        return replace(self, start=start, torques=trial.torques, loads=trial.loads, grids=grids)


@dataclass(frozen=True)
class Trial:
    """The fit at one choice of transition torques.

    Attributes:
        model: what was fitted, with these transition torques and its sides frozen.
        solution: where the fit ended.
        torques: by element; of a step the middle of its gap, unless the torque was given.
        gaps: by element with a step, the largest load on the low side and the smallest on the high side.
        loads: of the undeflected configuration of the fitted robot, (n,) by element.
    """

    model: Model
    solution: Solution
    torques: Mapping[str, float]
    gaps: Mapping[str, tuple[float, float]]
    loads: Mapping[str, Array]

    @property
    def misfit(self) -> float:
        """Sum of residual^2 / variance."""
        return misfit_of(self.solution.sums)


def fit_at(problem: Problem, torques: Mapping[str, float], given: bool = False) -> Trial:
    """Fit at transition torques, by element, with the problem's weights; see `settled`.

    Raises:
        EquilibriumError: the robot does not settle with these torques.
    """

    def solve(model: Model, start: Array) -> Solution:
        sums = normal_sums(model, start, problem.variances)
        displacements, sums, steps, converged = descend(model, start, sums, problem.variances)
        return Solution(displacements, sums, problem.variances, steps, converged)

    return _with_its_own_sides(problem, torques, solve, given)


def fit_anew(problem: Problem, on_step: Callable[[int, float], None] | None = None, given: bool = False) -> Trial:
    """Fit at the problem's transition torques, and the model variances to the residuals; see `settled`.

    Raises:
        EquilibriumError: the robot does not settle with these torques.
    """
    return _with_its_own_sides(problem, problem.torques, lambda model, start: fit(model, start, on_step), given)


def _with_its_own_sides(
    problem: Problem, torques: Mapping[str, float], solve: Callable[[Model, Array], Solution], given: bool
) -> Trial:
    """Fit with frozen sides, until they are the sides of the fitted robot.

    Where loads have changed places across a transition torque, the fit runs again with as many rows on each side as
    before. The torques of steps move to the middle of their gaps, unless they are given.
    """
    if not problem.laws:
        model = problem.model(torques)
        return Trial(model, solve(model, problem.start), torques, {}, {})
    for _ in range(MAX_PASSES):
        model = problem.model(torques)
        solution = solve(model, problem.start)
        loads = model.undeflected_loads(solution.displacements)
        steps = [element for element, law in problem.laws.items() if law == STEP.name]
        gaps = {element: _gap(problem.loads[element], loads[element], torques[element]) for element in steps}
        fitted = dict(torques) if given else {**torques, **{e: 0.5 * (low + up) for e, (low, up) in gaps.items()}}
        same = all(_same_sides(problem.loads[e], torques[e], loads[e], fitted[e]) for e in steps)
        trial = Trial(model, solution, fitted, gaps, loads)
        problem, torques = problem.after(trial), fitted
        if same:
            break
    return replace(trial, model=problem.model(fitted))


def _gap(sides: Array, loads: Array, torque: float) -> tuple[float, float]:
    """The neighbouring loads between as many rows as `sides` has below the torque, and the others."""
    ordered = np.sort(np.abs(loads))
    below = int((np.abs(sides) < torque).sum())
    low = float(ordered[below - 1]) if below else 0.0
    return low, float(ordered[below]) if below < len(ordered) else low


def _same_sides(sides: Array, torque: float, loads: Array, fitted: float) -> bool:
    return bool(((np.abs(sides) >= torque) == (np.abs(loads) >= fitted)).all())


def polished(problem: Problem, trial: Trial) -> Trial:
    """The trial with the transition torques of its hinges among the parameters for a few steps.

    The misfit has kinks where a hinge's transition torque passes a load, and the iteration stalls on them; so it is
    given few steps, the torques that it ends at are held, and the rest is fitted.
    """
    hinges = [element for element, law in problem.laws.items() if law != STEP.name]
    if not hinges:
        return trial
    names = (*problem.names, *(f"{element}.transition_torque" for element in hinges))
    model, start = replace(trial.model, names=names), np.append(trial.solution.displacements, np.zeros(len(hinges)))
    try:
        sums = normal_sums(model, start, problem.variances)
        found, *_ = descend(model, start, sums, problem.variances, most=HINGE_STEPS)
        moved = dict(trial.torques)
        for element, change in zip(hinges, found[len(problem.names) :].tolist(), strict=True):
            allowed = problem.grids[element].torques
            moved[element] = float(np.clip(moved[element] + change, allowed[0], allowed[-1]))
        better = fit_at(replace(problem.after(trial), start=found[: len(problem.names)]), moved)
    except EquilibriumError:
        return trial
    return better if better.misfit < trial.misfit else trial
