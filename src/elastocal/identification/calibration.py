"""Calibration from end to end: request, gauge, alignment, fit, uncertainty, verdict."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.errors import InputError
from elastocal.identification.advice import with_advice
from elastocal.identification.alignment import align
from elastocal.identification.attempt import Attempt
from elastocal.identification.bootstrap import Bootstrap, bootstrapped, require_samples
from elastocal.identification.evidence import PRIOR, with_prior_of
from elastocal.identification.expected import expected_error
from elastocal.identification.fitting import Fitting
from elastocal.identification.gauge import Gauge, choose_gauge
from elastocal.identification.intervals import correlated_groups, student, with_intervals
from elastocal.identification.observability import observability
from elastocal.identification.outliers import find_outliers, outliers_of
from elastocal.identification.plausibility import require_plausible
from elastocal.identification.priors import fit_with_priors, geometry_kinds, require_orders, with_maps
from elastocal.identification.request import requested, with_laws
from elastocal.identification.result import CalibrationResult
from elastocal.identification.robust import require_loss
from elastocal.identification.solver import Normal, fit
from elastocal.identification.sums import Sums, Variances, misfit_of, normal_sums
from elastocal.identification.table import Estimates, element_table, parameter_table
from elastocal.identification.tally import all_statistics, row_errors, with_all_rows
from elastocal.identification.threads import one_thread
from elastocal.identification.transition import (
    GeneticSearch,
    Transition,
    free_torques,
    given_torques,
    linear_model,
    searched_laws,
    transitions_of,
    with_known_torques,
    with_transition,
)
from elastocal.identification.whole import Data, few, on_all_rows, require_held, transitions_on_all_rows
from elastocal.measurements import Measurements, split
from elastocal.parameters import FRAME_GROUPS, parameters_of
from elastocal.partitions import Partitions
from elastocal.prediction import Model, kind_of
from elastocal.robot import Robot


@one_thread
def calibrate(
    robot: Robot,
    data: Data,
    *,
    held_out: Data | None = None,
    holdout: float | None = None,
    identify: Sequence[str] | None = None,
    fix: Sequence[str] = (),
    elastic: Mapping[str, str] | None = None,
    transition: Transition = "exact",
    non_negative: bool = False,
    loss: str = "linear",
    transmission: int | str = 0,
    prior: bool = False,
    bootstrap: int = 0,
    seed: int = 0,
    on_step: Callable[[int, float], None] | None = None,
    on_generation: Callable[[int, int], None] | None = None,
    on_sample: Callable[[int, int], None] | None = None,
    executor: Executor | None = None,
) -> CalibrationResult:
    """Identify a robot's geometry and compliance from measurements.

    Args:
        robot: nominal.
        data: what was measured; of partitions a sample decides what is searched for, and all rows are fitted.
        held_out: measurements that the fit does not see, to judge it by.
        holdout: instead, the fraction of `data` to hold out; rows of one pose stay together.
        identify: patterns of parameter names; None: all geometry. Frames that are not known are always identified.
        fix: patterns of parameter names to keep as they are.
        elastic: laws by element: {"2": "linear"} for the element that joint 2 drives, {"2.alpha": ...} for any other.
        transition: how the transition torques of step and hinge laws are found: "exact", "ga", a GeneticSearch, or the
            torques [N m or N] in the order of `elastic`.
        non_negative: whether compliances are kept from becoming negative.
        loss: "huber" or "cauchy" to find outliers by a robust fit and leave them out; with "linear" they are only
            named.
        transmission: orders of the joints' maps of transmission error, or "auto": as many as the evidence favours.
        prior: whether all geometry is identified at once, about its nominal values with the robot's tolerances or,
            where it states none, with such as the data favour; for few poses.
        bootstrap: how many fits to data that might have been measured tell standard deviations and intervals; 0: the
            linear covariance does.
        seed: of the choice of rows to hold out, of a genetic algorithm, and of a bootstrap.
        on_step: called with the number of steps and the sum of squares after each one.
        on_generation: called with the number of a genetic algorithm's generations done, and of all.
        on_sample: called with the number of a bootstrap's fits done, and of all.
        executor: where the fits of a bootstrap and of a genetic algorithm run, and partitions are worked through; None:
            here, one after the other. The result is the same.

    Raises:
        InputError: names, patterns or fractions that make no sense; data with a fault as a whole, as swapped axes.
        EquilibriumError: the nominal robot does not settle under its load.
    """
    began = time.perf_counter()
    require_loss(loss)
    orders = require_orders(transmission)
    require_samples(bootstrap, priors=prior or orders != 0)
    require_held(data, holdout, bootstrap)
    fitted, rest = _divided(few(data), None if held_out is None else few(held_out), holdout, seed)
    wished, springs = with_laws(robot, elastic or {})
    torqued = with_transition(springs, wished)
    given = given_torques(transition, torqued)
    gauge = choose_gauge(wished, fitted, requested(wished, springs, identify, fix))
    laws = searched_laws(torqued, wished, gauge)

    nominal = with_known_torques(wished, given)
    start = fit_frames(nominal, fitted, gauge)
    require_plausible(nominal, start, fitted)

    fitting = Fitting(gauge, laws, given, non_negative, seed)

    def attempt(rows: Measurements, weights: Array | None = None, how: Transition = "exact") -> Attempt:
        begin = start if rows is fitted else fit_frames(nominal, rows, gauge)
        return fitting.attempt(begin, rows, weights, how, on_step, on_generation, executor)

    good = np.ones(len(fitted), dtype=bool)
    if loss != "linear":
        good = find_outliers(attempt, linear_model(start, gauge.kept, fitted, laws), bool(laws), loss)
    found = attempt(fitted if good.all() else fitted.take(np.flatnonzero(good)), how=transition)
    if isinstance(data, Partitions):
        found = on_all_rows(found, data, loss != "linear", on_step, executor)
    if orders != 0 or prior:
        kinds = geometry_kinds(wished, gauge) if prior else {}
        found = replace(found, prior=fit_with_priors(found.summed, found.solution, orders, kinds, wished.tolerance))
    resampled = None
    if bootstrap:
        refit = partial(fitting.attempt, found.problem.robot)
        resampled = bootstrapped(found, refit, bootstrap, seed, on_sample, executor)
    settings = {
        "elastic": dict(elastic or {}),
        "transition": _told(transition),
        "non_negative": non_negative,
        "loss": loss,
        "transmission": transmission,
        "prior": prior,
        "bootstrap": bootstrap,
        "identify": None if identify is None else list(identify),
        "fix": list(fix),
        "holdout": holdout,
        "seed": seed,
    }
    result = _assess(wished, gauge, found, resampled, fitted, good, rest, settings)
    result = with_advice(with_all_rows(result, found, data, held_out, executor))
    return replace(result, seconds=time.perf_counter() - began)


def _told(transition: Transition) -> object:
    """What was asked for, as the result's settings have it."""
    if isinstance(transition, GeneticSearch):
        return {"method": "ga", "population": transition.population, "generations": transition.generations}
    return transition if isinstance(transition, str) else list(transition)


def fit_frames(robot: Robot, data: Measurements, gauge: Gauge) -> Robot:
    """The robot with its open frames where they fit the data best, all else as it is."""
    parameters = parameters_of(robot)
    frames = tuple(name for name in gauge.kept if parameters[name].group in FRAME_GROUPS)
    model = Model(align(robot, data), frames, data)
    return model.displaced(fit(model, np.zeros(len(frames))).displacements)


def _divided(
    data: Measurements, held_out: Measurements | None, holdout: float | None, seed: int
) -> tuple[Measurements, Measurements | None]:
    """Rows to fit and rows held out."""
    if holdout is None:
        return data, held_out
    if held_out is not None:
        raise InputError("held-out rows are given and asked for (held_out and holdout): give one of the two")
    if not 0.0 < holdout < 1.0:
        raise InputError(f"holdout is {holdout:g}: expected a fraction between 0 and 1, as 0.3")
    fit_rows, held_rows = split(data, holdout, seed)
    if not len(fit_rows) or not len(held_rows):
        raise InputError(f"holdout {holdout:g} of {len(data)} rows leaves none to fit or none to hold out")
    return data.take(fit_rows), data.take(held_rows)


def _assess(
    wished: Robot,
    gauge: Gauge,
    found: Attempt,
    resampled: Bootstrap | None,
    data: Measurements,
    good: NDArray[np.bool_],
    rest: Measurements | None,
    settings: Mapping[str, object],
) -> CalibrationResult:
    """Uncertainty, residuals and verdicts of a fit of the good rows of data."""
    trial, search, solution = found.trial, found.search, found.solution
    identified = _with_known_frames(found.model.displaced(solution.displacements), data)
    effects = np.array([gauge.effects[name] for name in trial.model.names])
    rows = int(good.sum()) if found.whole is None else found.whole.model.fitted
    seen = observability(trial.solution.sums, effects, rows, trial.model.names)
    names, sums = _with_free_torques(found)
    normal = Normal.of(sums)
    observed = {kind: one for kind, one in sums.items() if kind != PRIOR}
    coordinates = round(sum(one.count for one in observed.values()))
    told = sum(float((normal.covariance * one.gram[:-1, :-1]).sum()) for one in observed.values())
    chi2 = misfit_of(observed) / max(coordinates - told, 1.0)
    stated = any(one.stated for one in observed.values())
    covariance, reach = normal.covariance * (max(chi2, 1.0) if stated else chi2), student(coordinates - told)
    transitions, pair = transitions_of(found.problem, found.searched, search, reach)
    if found.whole is not None:
        transitions = transitions_on_all_rows(transitions, found.whole, names, covariance, reach)
    estimates = Estimates(
        names=names,
        displacements=dict(zip(found.model.names, solution.displacements.tolist(), strict=True)),
        covariance=covariance,
        unseen=_unseen(normal, names),
        held=found.held,
        transitions=transitions,
    )
    if resampled is not None:
        estimates = resampled.estimates(estimates, trial)
    before = with_maps(wished, found.prior.orders) if found.prior and found.prior.orders else wished
    shares = found.prior.shares if found.prior else {}
    table = parameter_table(before, identified, gauge, estimates)
    table = tuple(replace(row, data_share=shares.get(row.name)) for row in table)
    errors = row_errors(found.nominal, identified, data, rest)
    expected, told_all = None, seen.rank == seen.parameters or bool(found.prior and found.prior.tolerances)
    if rest is None and told_all:
        expected = expected_error(found, replace(found.model, names=names), normal.covariance)
    status = "converged" if solution.converged else "not_converged"
    return CalibrationResult(
        robot=identified,
        nominal_robot=found.nominal,
        status=status if told_all else "not_identifiable",
        parameters=with_intervals(table, coordinates - told, estimates.transitions, resampled),
        elastic=element_table(identified, table, estimates.transitions),
        residuals=all_statistics(errors, expected),
        observability=seen,
        gauge=gauge,
        names=names,
        covariance=estimates.covariance,
        correlated=correlated_groups(names, estimates.covariance),
        coordinates=coordinates,
        freedom=coordinates - told,
        bootstrap=None if resampled is None else resampled.counts,
        model_sigma=model_sigma(solution.variances, observed),
        chi2_reduced=chi2,
        errors=errors,
        outliers=() if found.whole is not None else outliers_of(found, data, good),
        iterations=solution.steps,
        settings=settings,
        search=search and replace(search, pair=pair),
        prior=found.prior,
    )


def _with_free_torques(found: Attempt) -> tuple[tuple[str, ...], Sums]:
    """The parameters of a fit with the transition torques of hinges among them, and the sums of all rows for these."""
    model, solution, hinges = found.summed, found.solution, free_torques(found.trial, found.search)
    if not hinges:
        return model.names, solution.sums
    model = replace(model, names=(*model.names, *hinges))
    extended = np.append(solution.displacements, np.zeros(len(hinges)))
    return model.names, with_prior_of(solution.sums, normal_sums(model, extended, solution.variances))


def model_sigma(variances: Variances, observed: Sums) -> dict[str, float]:
    """What the model leaves unexplained by kind of observation, and by channel where there are several of a kind."""
    found: dict[str, float] = {}
    for kind in dict.fromkeys(map(kind_of, observed)):
        channels = [channel for channel in observed if kind_of(channel) == kind]
        counts = [observed[channel].count for channel in channels]
        found[kind] = float(np.sqrt(np.average([variances[channel] for channel in channels], weights=counts)))
        found |= {channel: float(np.sqrt(variances[channel])) for channel in channels}
    return found


def _unseen(normal: Normal, names: Sequence[str]) -> dict[str, str]:
    """The identified parameters that the data at hand do not tell."""
    share = (normal.vectors[:, ~normal.seen] ** 2).sum(axis=1)
    reason = "the measured poses do not tell it"
    return {name: reason for name, part in zip(names, share, strict=True) if part > UNSEEN_SHARE}


UNSEEN_SHARE = 1e-3
"""Square of the part of a parameter along directions that the data do not see, from which on it is not told."""


def _with_known_frames(robot: Robot, data: Measurements) -> Robot:
    """The robot with the frames that the data involve known."""
    used = {"tool"}
    for found in data.combinations:
        used.add("base" if found.station is None else f"station.{found.station}")
        used.add("tool" if found.target is None else f"target.{found.target}")
    return robot.with_frames({prefix: replace(robot.frames[prefix], known=True) for prefix in used})
