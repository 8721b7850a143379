"""One simulated calibration of a study, and what is told of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from elastocal.chain import Array
from elastocal.comparison import MODELS, compare
from elastocal.errors import ElastocalError
from elastocal.identification import CalibrationResult, calibrate
from elastocal.identification.threads import one_thread
from elastocal.identification.words import orders_of
from elastocal.io.study_values import Setting, Study, cell_key
from elastocal.measurements import Measurements, concatenate
from elastocal.prediction import Model, predict
from elastocal.robot import Robot
from elastocal.simulation import random_poses, reach_of, read
from elastocal.studies.simulation import (
    Poses,
    drawn_robot,
    exactly,
    instrument_of,
    laws_of,
    patterns_of,
    shared_poses,
    springs_of,
)
from elastocal.uncertainty import position_uncertainty

FAILED = "failed"
"""Status of a calibration that led to no result."""

Row = dict[str, Any]


@dataclass(frozen=True)
class Lot:
    """Repeats of one point of a grid that go together.

    Attributes:
        planned: the poses, if they are not drawn for each repeat.
    """

    setting: Setting
    repeats: tuple[int, ...]
    planned: tuple[Poses, ...] = ()


@dataclass(frozen=True)
class Simulated:
    """One repeat: the actual robot, and what was measured of it.

    Attributes:
        data: with noise and outliers.
        wrong: rows of data that are outliers.
        held_out: without noise, at other poses.
        exact: data without noise and outliers.
    """

    actual: Robot
    data: Measurements
    wrong: Array
    held_out: Measurements
    exact: Measurements


@dataclass(frozen=True)
class Calibrated:
    """One repeat, calibrated."""

    study: Study
    setting: Setting
    made: Simulated
    result: CalibrationResult


@dataclass(frozen=True)
class Calibrations:
    """In a worker: the rows that a lot adds to a study's results.

    Attributes:
        reach: of the nominal robot [m].
    """

    study: Study
    reach: float

    @classmethod
    def of(cls, study: Study) -> Calibrations:
        """Those of a study."""
        return cls(study, reach_of(study.robot))

    @one_thread
    def __call__(self, lot: Lot) -> list[Row]:
        """Calibrate all repeats of a lot."""
        return [self.row(lot, repeat) for repeat in lot.repeats]

    def row(self, lot: Lot, repeat: int) -> Row:
        """One calibration; nothing that goes wrong in it stops others."""
        head = {"cell": cell_key(lot.setting), "repeat": repeat, **vars(lot.setting)}
        try:
            return head | _told(self.study, lot.setting, simulated(self.study, lot, repeat, self.reach))
        except ElastocalError as error:
            return head | {"status": FAILED, "reason": str(error)}
        except Exception as error:  # of numbers that nobody has thought of, for one
            return head | {"status": FAILED, "reason": f"{type(error).__name__}: {error}"}


def simulated(study: Study, lot: Lot, repeat: int, reach: float) -> Simulated:
    """One repeat. Robot, poses and noise have streams of their own, which the point of the grid has no part in."""
    setting = lot.setting
    streams = np.random.SeedSequence((study.seed, repeat)).spawn(4)
    for_robot, for_poses, for_noise, for_rest = map(np.random.default_rng, streams)
    actual = drawn_robot(study, setting.law, reach, for_robot)
    poses = list(lot.planned)
    if not poses:
        poses = shared_poses(study.robot, setting.payload, random_poses(study.robot, setting.poses, for_poses))
    others = shared_poses(study.robot, setting.payload, random_poses(study.robot, study.held_out, for_rest))
    parts = exactly(actual, [*poses, *others], setting.kinds)
    exact, held_out = concatenate(parts[: len(poses)]), concatenate(parts[len(poses) :])
    data = read(instrument_of(setting, setting.outliers), exact, for_noise)
    wrong = np.empty(0, dtype=int)
    if setting.outliers and data.position is not None:
        # the same numbers are drawn for the noise, so that only the outliers differ
        clean = read(instrument_of(setting, 0.0), exact, np.random.default_rng(streams[2]))
        wrong = np.flatnonzero((clean.observed("position") != data.position).any(axis=1))
    return Simulated(actual, data, wrong, held_out, exact)


def options_of(study: Study, setting: Setting, actual: Robot) -> dict[str, Any]:
    """What `calibrate` is asked for."""
    torques = (
        [actual.elastic[name].transition_torque for name in springs_of(study.actual, actual)] if actual.elastic else []
    )
    return {
        "elastic": laws_of(study, setting.fitted),
        "transition": torques if setting.transition == "true" else setting.transition,
        "identify": patterns_of(setting.identify),
        "fix": patterns_of(setting.fix) or (),
        "loss": setting.loss,
        "transmission": orders_of("transmission", setting.transmission),
        "prior": setting.prior,
        "non_negative": setting.non_negative,
    }


def _told(study: Study, setting: Setting, made: Simulated) -> Row:
    """The figures of one calibration, SI."""
    options = options_of(study, setting, made.actual)
    result = calibrate(
        study.robot, made.data, held_out=made.held_out, bootstrap=setting.bootstrap, seed=study.seed, **options
    )
    before, after = result.residuals["held_out_nominal"], result.residuals["held_out"]
    identified = [p for p in result.parameters if p.std is not None]
    row: Row = {
        "status": result.status,
        "nominal_mean": before.mean,
        "nominal_max": before.max,
        "held_out_mean": after.mean,
        "held_out_max": after.max,
        "held_out_rms": after.rms,
        "fitted_mean": result.residuals["calibrated"].mean,
        "parameters": len(result.names),
        "condition": result.observability.condition,
        "chi2_reduced": result.chi2_reduced,
        "iterations": result.iterations,
        "seconds": result.seconds,
        "name": [p.name for p in identified],
        "identified": [p.identified for p in identified],
        "std": [p.std for p in identified],
    }
    for measure in study.measures:
        row |= MEASURED[measure](Calibrated(study, setting, made, result))
    return row


def _coverage(one: Calibrated) -> Row:
    """Whether intervals cover the truth: the fit to the same poses without noise, in the same gauge."""
    study, setting, made, result = one.study, one.setting, one.made, one.result
    true = calibrate(study.robot, made.exact, **options_of(study, replace(setting, loss="linear"), made.actual))
    values = {p.name: p.identified for p in true.parameters}
    told = [(p.name, p.interval) for p in result.parameters if p.interval is not None]
    q = made.held_out.q
    moved = predict(result.robot, q)[0] - predict(true.robot, q)[0]
    row: Row = {
        "interval_name": [name for name, _ in told],
        "covered": [low <= values[name] <= high for name, (low, high) in told],
        "position_square": float((moved**2).sum(axis=1).mean()),
        "position_variance": float((position_uncertainty(result, q).from_parameters ** 2).mean()),
    }
    residual = result.errors.calibrated.position
    if setting.noise and residual is not None:
        squares = float(np.nansum(residual[~result.errors.held_out] ** 2))
        row["chi2_true"] = squares / setting.noise**2 / result.freedom
    return row


def _recommendation(one: Calibrated) -> Row:
    """Whether the law that the actual robot has is the one that `compare` recommends."""
    given = options_of(one.study, one.setting, one.made.actual)
    found = compare(
        one.study.robot,
        one.made.data,
        elastic=one.study.elements,
        models=MODELS,
        folds=None,
        identify=given["identify"],
        fix=given["fix"],
    )
    return {
        "recommended": found.recommended or "",
        "right": found.recommended == one.setting.law,
        "compared": [m.name for m in found.models],
        "compared_parameters": [m.parameters for m in found.models],
        "compared_coordinates": [m.coordinates for m in found.models],
        "deviance": [m.deviance for m in found.models],
        "criterion": [m.criterion for m in found.models],
    }


def _transition(one: Calibrated) -> Row:
    """How far off transition torques are, and whether each row is on the side that it is on in truth."""
    study, made, result = one.study, one.made, one.result
    names = springs_of(study.actual, study.robot)
    true = [made.actual.elastic[name].transition_torque or np.nan for name in names]
    found = {e.element: e for e in result.elastic}
    torques = [found[name].transition_torque or np.nan for name in names]
    stds = [found[name].transition_std or np.nan for name in names]
    fitted = made.data.take(np.flatnonzero(~np.isin(np.arange(len(made.data)), made.wrong)))
    loads = [_loads(robot, fitted, names) for robot in (made.actual, result.robot)]
    pairs = zip(loads[0], true, loads[1], torques, strict=True)
    return {
        "torque": torques,
        "torque_error": [t / x - 1.0 for t, x in zip(torques, true, strict=True)],
        "torque_score": [(t - x) / s for t, x, s in zip(torques, true, stds, strict=True)],
        "same_sides": all(bool(((a >= x) == (b >= t)).all()) for a, x, b, t in pairs),
        "search_seconds": result.search.seconds if result.search else None,
    }


def _loads(robot: Robot, data: Measurements, names: Sequence[str]) -> list[Array]:
    """Sizes of the loads of the undeflected robot on elements."""
    found: Mapping[str, Array] = Model(robot, (), data).undeflected_loads(np.zeros(0))
    return [np.abs(found[name]) for name in names]


def _outliers(one: Calibrated) -> Row:
    """How many outliers are named, and how many good rows are."""
    result, wrong = one.result, set(one.made.wrong.tolist())
    named = {outlier.index for outlier in result.outliers if not result.errors.held_out[outlier.index]}
    return {"outliers_wrong": len(wrong), "outliers_named": len(named & wrong), "outliers_accused": len(named - wrong)}


MEASURED = {
    "coverage": _coverage,
    "recommendation": _recommendation,
    "transition": _transition,
    "outliers": _outliers,
}
"""What is told beyond held-out errors, by name."""
