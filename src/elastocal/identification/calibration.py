"""Calibration from end to end: request, gauge, alignment, fit, uncertainty, verdict."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from elastocal.errors import InputError
from elastocal.identification.advice import with_advice
from elastocal.identification.alignment import align
from elastocal.identification.gauge import Gauge, choose_gauge
from elastocal.identification.observability import observability
from elastocal.identification.request import requested, with_laws
from elastocal.identification.result import CalibrationResult, RowErrors
from elastocal.identification.solver import Normal, Solution, fit
from elastocal.identification.statistics import Statistics, residuals, statistics
from elastocal.identification.table import element_table, parameter_table
from elastocal.measurements import Measurements, concatenate, split
from elastocal.parameters import FRAME_GROUPS, parameters_of
from elastocal.prediction import Model
from elastocal.robot import Robot


def calibrate(
    robot: Robot,
    data: Measurements,
    *,
    held_out: Measurements | None = None,
    holdout: float | None = None,
    identify: Sequence[str] | None = None,
    fix: Sequence[str] = (),
    elastic: Mapping[str, str] | None = None,
    seed: int = 0,
    on_step: Callable[[int, float], None] | None = None,
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
        seed: of the choice of rows to hold out.
        on_step: called with the number of steps and the sum of squares after each one.

    Raises:
        InputError: names, patterns or fractions that make no sense.
        EquilibriumError: the nominal robot does not settle under its load.
    """
    began = time.perf_counter()
    fitted, rest = _divided(data, held_out, holdout, seed)
    wished, springs = with_laws(robot, elastic or {})
    gauge = choose_gauge(wished, fitted, requested(wished, springs, identify, fix))
    nominal = fit_frames(wished, fitted, gauge)
    model = Model(nominal, gauge.kept, fitted)
    solution = fit(model, np.zeros(len(gauge.kept)), on_step)
    settings = {
        "elastic": dict(elastic or {}),
        "identify": None if identify is None else list(identify),
        "fix": list(fix),
        "holdout": holdout,
        "seed": seed,
    }
    result = with_advice(_assess(wished, gauge, model, solution, rest, settings))
    return replace(result, seconds=time.perf_counter() - began)


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
    model: Model,
    solution: Solution,
    rest: Measurements | None,
    settings: Mapping[str, object],
) -> CalibrationResult:
    """Uncertainty, residuals and verdicts of a fit."""
    identified = _with_known_frames(model.displaced(solution.displacements), model.data)
    normal = Normal.of(solution.sums)
    coordinates = sum(found.count for found in solution.sums.values())
    misfit = sum(found.misfit for found in solution.sums.values())
    chi2 = misfit / max(coordinates - int(normal.seen.sum()), 1)
    stated = any(found.stated for found in solution.sums.values())
    covariance = normal.covariance * (max(chi2, 1.0) if stated else chi2)
    table = parameter_table(wished, identified, gauge, solution.displacements, covariance, _unseen(normal, gauge))

    seen = observability(solution.sums, np.array(list(gauge.effects.values())), len(model.data))
    errors = _row_errors(model.robot, identified, model.data, rest)
    status = "converged" if solution.converged else "not_converged"
    return CalibrationResult(
        robot=identified,
        nominal_robot=model.robot,
        status=status if seen.rank == seen.parameters else "not_identifiable",
        parameters=table,
        elastic=element_table(identified, table),
        residuals=_all_statistics(errors),
        observability=seen,
        gauge=gauge,
        covariance=covariance,
        coordinates=coordinates,
        model_sigma={kind: float(np.sqrt(variance)) for kind, variance in solution.variances.items()},
        chi2_reduced=chi2,
        errors=errors,
        iterations=solution.steps,
        settings=settings,
    )


def _unseen(normal: Normal, gauge: Gauge) -> dict[str, str]:
    """The kept parameters that the data at hand do not tell."""
    share = (normal.vectors[:, ~normal.seen] ** 2).sum(axis=1)
    reason = "the measured poses do not tell it"
    return {name: reason for name, part in zip(gauge.kept, share, strict=True) if part > UNSEEN_SHARE}


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


def _all_statistics(errors: RowErrors) -> dict[str, Statistics]:
    fitted, held = ~errors.held_out, errors.held_out
    found = {"nominal": statistics(errors.nominal, fitted), "calibrated": statistics(errors.calibrated, fitted)}
    if held.any():
        found["held_out_nominal"] = statistics(errors.nominal, held)
        found["held_out"] = statistics(errors.calibrated, held)
    return found
