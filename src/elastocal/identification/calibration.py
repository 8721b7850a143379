"""Calibration from end to end: request, gauge, alignment, fit, uncertainty, verdict."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.errors import InputError
from elastocal.identification.advice import with_advice
from elastocal.identification.alignment import align
from elastocal.identification.attempt import Attempt
from elastocal.identification.bootstrap import Bootstrap, bootstrapped, require_samples
from elastocal.identification.bounds import fit_non_negative
from elastocal.identification.evidence import PRIOR, with_prior_of
from elastocal.identification.expected import expected_error
from elastocal.identification.gauge import Gauge, choose_gauge
from elastocal.identification.intervals import correlated_groups, student, with_intervals
from elastocal.identification.observability import observability
from elastocal.identification.outliers import find_outliers, outliers_of
from elastocal.identification.plausibility import require_plausible
from elastocal.identification.priors import fit_with_priors, geometry_kinds, require_orders, with_maps
from elastocal.identification.request import requested, with_laws
from elastocal.identification.result import CalibrationResult, RowErrors
from elastocal.identification.robust import require_loss
from elastocal.identification.solver import Normal, fit
from elastocal.identification.statistics import Statistics, residuals, statistics
from elastocal.identification.sums import Sums, Variances, misfit_of, normal_sums
from elastocal.identification.table import Estimates, element_table, parameter_table
from elastocal.identification.threads import one_thread
from elastocal.identification.transition import (
    GeneticSearch,
    Problem,
    Transition,
    Trial,
    find_torques,
    fit_anew,
    free_torques,
    given_torques,
    linear_model,
    problem_of,
    searched_laws,
    transitions_of,
    with_known_torques,
    with_transition,
)
from elastocal.measurements import Measurements, concatenate, split
from elastocal.parameters import FRAME_GROUPS, parameters_of
from elastocal.prediction import Model, kind_of
from elastocal.robot import Robot


@one_thread
def calibrate(
    robot: Robot,
    data: Measurements,
    *,
    held_out: Measurements | None = None,
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
) -> CalibrationResult:
    """Identify a robot's geometry and compliance from measurements.

    Args:
        robot: nominal.
        data: what was measured.
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

    Raises:
        InputError: names, patterns or fractions that make no sense; data with a fault as a whole, as swapped axes.
        EquilibriumError: the nominal robot does not settle under its load.
    """
    began = time.perf_counter()
    require_loss(loss)
    orders = require_orders(transmission)
    require_samples(bootstrap, priors=prior or orders != 0)
    fitted, rest = _divided(data, held_out, holdout, seed)
    wished, springs = with_laws(robot, elastic or {})
    torqued = with_transition(springs, wished)
    given = given_torques(transition, torqued)
    gauge = choose_gauge(wished, fitted, requested(wished, springs, identify, fix))
    laws = searched_laws(torqued, wished, gauge)

    nominal = with_known_torques(wished, given)
    start = fit_frames(nominal, fitted, gauge)
    require_plausible(nominal, start, fitted)

    def attempt(
        rows: Measurements, weights: Array | None = None, how: Transition = "exact", begin: Robot | None = None
    ) -> Attempt:
        begin = begin or (start if rows is fitted else fit_frames(nominal, rows, gauge))
        problem = problem_of(begin, gauge.kept, rows, laws, weights)
        problem, search = find_torques(problem, how, given, seed, on_generation)
        trial, held = fit_non_negative(problem, fit_all) if non_negative else (fit_all(problem), ())
        return Attempt(problem, search, trial, held)

    def fit_all(problem: Problem) -> Trial:
        return fit_anew(problem, on_step, given=bool(given))

    good = np.ones(len(fitted), dtype=bool)
    if loss != "linear":
        good = find_outliers(attempt, linear_model(start, gauge.kept, fitted, laws), bool(laws), loss)
    found = attempt(fitted if good.all() else fitted.take(np.flatnonzero(good)), how=transition)
    if orders != 0 or prior:
        kinds = geometry_kinds(wished, gauge) if prior else {}
        found = replace(found, prior=fit_with_priors(found.model, found.solution, orders, kinds, wished.tolerance))
    resampled = None
    if bootstrap:
        begin = found.problem.robot
        resampled = bootstrapped(found, lambda rows: attempt(rows, begin=begin), bootstrap, seed, on_sample)
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
    result = with_advice(_assess(wished, gauge, found, resampled, fitted, good, rest, settings))
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
    seen = observability(trial.solution.sums, effects, int(good.sum()))
    model, sums, hinges = found.model, solution.sums, free_torques(trial, search)
    if hinges:
        model = replace(model, names=(*model.names, *hinges))
        extended = np.append(solution.displacements, np.zeros(len(hinges)))
        sums = with_prior_of(sums, normal_sums(model, extended, solution.variances))
    normal, names = Normal.of(sums), model.names
    observed = {kind: one for kind, one in sums.items() if kind != PRIOR}
    coordinates = round(sum(one.count for one in observed.values()))
    told = sum(float((normal.covariance * one.gram[:-1, :-1]).sum()) for one in observed.values())
    chi2 = misfit_of(observed) / max(coordinates - told, 1.0)
    stated = any(one.stated for one in observed.values())
    estimates = Estimates(
        names=names,
        displacements=dict(zip(found.model.names, solution.displacements.tolist(), strict=True)),
        covariance=normal.covariance * (max(chi2, 1.0) if stated else chi2),
        unseen=_unseen(normal, names),
        held=found.held,
        transitions=transitions_of(found.problem, trial, search, student(coordinates - told)),
    )
    if resampled is not None:
        estimates = resampled.estimates(estimates, trial)
    before = with_maps(wished, found.prior.orders) if found.prior and found.prior.orders else wished
    shares = found.prior.shares if found.prior else {}
    table = parameter_table(before, identified, gauge, estimates)
    table = tuple(replace(row, data_share=shares.get(row.name)) for row in table)
    errors = _row_errors(trial.model.robot, identified, data, rest)
    expected, told_all = None, seen.rank == seen.parameters or bool(found.prior and found.prior.tolerances)
    if rest is None and told_all:
        expected = expected_error(found, model, normal.covariance)
    status = "converged" if solution.converged else "not_converged"
    return CalibrationResult(
        robot=identified,
        nominal_robot=trial.model.robot,
        status=status if told_all else "not_identifiable",
        parameters=with_intervals(table, coordinates - told, estimates.transitions, resampled),
        elastic=element_table(identified, table, estimates.transitions),
        residuals=_all_statistics(errors, expected),
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
        outliers=outliers_of(found, data, good),
        iterations=solution.steps,
        settings=settings,
        search=search,
        prior=found.prior,
    )


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


def _row_errors(nominal: Robot, identified: Robot, data: Measurements, rest: Measurements | None) -> RowErrors:
    everything = data if rest is None else concatenate([data, rest])
    held_out = np.arange(len(everything)) >= len(data)
    return RowErrors(everything, held_out, residuals(nominal, everything), residuals(identified, everything))


def _all_statistics(errors: RowErrors, expected: Statistics | None) -> dict[str, Statistics]:
    fitted, held = ~errors.held_out, errors.held_out
    found = {"nominal": statistics(errors.nominal, fitted), "calibrated": statistics(errors.calibrated, fitted)}
    if expected is not None:
        found["cross_validated"] = expected
    if held.any():
        found["held_out_nominal"] = statistics(errors.nominal, held)
        found["held_out"] = statistics(errors.calibrated, held)
    return found
