"""What a fit leaves of all rows of partitions: statistics, and the rows that do not fit the others."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial, reduce

import numpy as np

from elastocal.identification.attempt import Attempt
from elastocal.identification.judged import Rule
from elastocal.identification.moments import ErrorMoments
from elastocal.identification.outliers import Outlier, better_names
from elastocal.identification.partitioned import Marked, Marks, over_parts
from elastocal.identification.result import CalibrationResult, RowErrors, Streamed
from elastocal.identification.statistics import Statistics, residuals, statistics
from elastocal.identification.threads import one_thread
from elastocal.measurements import Measurements, concatenate
from elastocal.partitions import Partitions
from elastocal.robot import Robot

LISTED = 1000
"""Outliers that are told one by one, the worst ones."""


@dataclass(frozen=True)
class Errors:
    """Of some rows: errors of the nominal and of the identified robot."""

    nominal: ErrorMoments
    calibrated: ErrorMoments

    def plus(self, more: Errors) -> Errors:
        """The errors of the rows of both."""
        return Errors(self.nominal.plus(more.nominal), self.calibrated.plus(more.calibrated))


@dataclass(frozen=True)
class Outlying:
    """Rows that do not fit the others: how many, how many of them were left out, and the worst.

    Attributes:
        rows: the LISTED worst, the worst first.
        outliers: the same as outliers, their indices without meaning.
        accused, rejected: how many there are in all.
    """

    rows: Measurements
    outliers: tuple[Outlier, ...]
    accused: int
    rejected: int

    def plus(self, more: Outlying) -> Outlying:
        """The outliers of both."""
        outliers = (*self.outliers, *more.outliers)
        scores = np.array([outlier.score for outlier in outliers])
        worst = np.argsort(-scores, kind="stable")[:LISTED]
        rows = concatenate([self.rows, more.rows]).take(worst)
        chosen = tuple(outliers[i] for i in worst.tolist())
        return Outlying(rows, chosen, self.accused + more.accused, self.rejected + more.rejected)


@dataclass(frozen=True)
class Tally:
    """Of all rows of partitions that were fitted.

    Attributes:
        nominal, calibrated: statistics of their errors.
        outlying: those that do not fit the others.
    """

    nominal: Statistics
    calibrated: Statistics
    outlying: Outlying


def tally(found: Attempt, identified: Robot, data: Partitions) -> Tally:
    """What a fit of all rows leaves of them.

    Args:
        found: the fit.
        identified: the robot that it led to.
        data: all rows.
    """
    if found.whole is None:
        raise ValueError("expected a fit of partitions")
    model = found.whole.model
    searched = found.search is not None and found.search.method != "given"
    rule = Rule.of(found.solution, len(found.trial.torques) if searched else 0, len(data), data.several_stations)
    parts = list(model.each(partial(_tally_of, found.nominal, identified, rule)))
    errors = reduce(Errors.plus, (each for each, _ in parts))
    outlying = reduce(Outlying.plus, (each for _, each in parts))
    outlying = _with_hints(found, data.sample, outlying)
    return Tally(errors.nominal.statistics, errors.calibrated.statistics, outlying)


@one_thread
def _tally_of(nominal: Robot, identified: Robot, rule: Rule, marked: Marked) -> tuple[Errors, Outlying]:
    data, weights = marked.part.read(), marked.marks.weights(marked.part.rows)
    judged, before = rule.judge(identified, data), residuals(nominal, data)
    good = np.ones(len(data), dtype=bool) if weights is None else weights > 0.0
    scores = rule.scores(judged, good)
    listed = np.flatnonzero(rule.accused(judged, scores) | ~good)
    worst = listed[np.argsort(-scores[listed], kind="stable")[:LISTED]]
    outliers = tuple(judged.outlier(data, row, float(scores[row]), not good[row]) for row in worst.tolist())
    errors = Errors(ErrorMoments.of(before), ErrorMoments.of(judged.residuals))
    return errors, Outlying(data.take(worst), outliers, len(listed), int((~good).sum()))


def _with_hints(found: Attempt, sample: Measurements, outlying: Outlying) -> Outlying:
    """The outliers with the names that they fit, if they bear wrong ones."""
    if not outlying.outliers:
        return outlying
    n = len(sample)
    listed = n + np.arange(len(outlying.outliers))
    bad = {(outlier.file, outlier.row) for outlier in outlying.outliers}
    good = np.array([sample.origin(row) not in bad for row in range(n)] + [False] * len(listed))
    hints = better_names(found, concatenate([sample, outlying.rows]), listed, good)
    told = [replace(each, hint=hints.get(n + i, "")) for i, each in enumerate(outlying.outliers)]
    return replace(outlying, outliers=tuple(told))


def with_outliers(sample: Measurements, outlying: Outlying) -> tuple[Measurements, tuple[Outlier, ...]]:
    """The sample with the outliers that it lacks, and all outliers with their indices in it."""
    places = {sample.origin(row): row for row in range(len(sample))} if outlying.outliers else {}
    added: list[int] = []
    outliers = []
    for i, outlier in enumerate(outlying.outliers):
        index = places.get((outlier.file, outlier.row))
        if index is None:
            index = len(sample) + len(added)
            added.append(i)
        outliers.append(replace(outlier, index=index))
    whole = concatenate([sample, outlying.rows.take(np.array(added))]) if added else sample
    return whole, tuple(outliers)


def row_errors(nominal: Robot, identified: Robot, data: Measurements, rest: Measurements | None) -> RowErrors:
    """The residuals of rows that were fitted, and of others that were held out."""
    everything = data if rest is None else concatenate([data, rest])
    held_out = np.arange(len(everything)) >= len(data)
    return RowErrors(everything, held_out, residuals(nominal, everything), residuals(identified, everything))


def all_statistics(errors: RowErrors, expected: Statistics | None) -> dict[str, Statistics]:
    """Statistics of rows that were fitted, of those held out if there are any, and what to `expected` of others."""
    fitted, held = ~errors.held_out, errors.held_out
    found = {"nominal": statistics(errors.nominal, fitted), "calibrated": statistics(errors.calibrated, fitted)}
    if expected is not None:
        found["cross_validated"] = expected
    if held.any():
        found["held_out_nominal"] = statistics(errors.nominal, held)
        found["held_out"] = statistics(errors.calibrated, held)
    return found


def with_all_rows(
    result: CalibrationResult,
    found: Attempt,
    data: Measurements | Partitions,
    held_out: Measurements | Partitions | None,
    executor: Executor | None,
) -> CalibrationResult:
    """The result with what all rows of partitions say, where it has what their samples say.

    Args:
        result: of the rows in memory.
        found: the fit.
        data: all rows that were fitted.
        held_out: all that were not.
        executor: where parts are worked through.
    """
    nominal, identified, told_of = result.nominal_robot, result.robot, dict(result.residuals)
    if isinstance(held_out, Partitions):
        robots = {"held_out_nominal": nominal, "held_out": identified}
        told_of |= errors_of(held_out, robots, executor)
    if not isinstance(data, Partitions):
        return replace(result, residuals=told_of)
    told = tally(found, identified, data)
    told_of |= {"nominal": told.nominal, "calibrated": told.calibrated}
    sample, outliers = with_outliers(data.sample, told.outlying)
    errors = result.errors
    if len(sample) > len(data.sample):
        rest = errors.data.take(np.flatnonzero(errors.held_out)) if errors.held_out.any() else None
        errors = row_errors(nominal, identified, sample, rest)
    found_all = told.outlying
    streamed = Streamed(len(data), len(data.parts), len(data.sample), found_all.accused, found_all.rejected)
    return replace(result, residuals=told_of, errors=errors, outliers=outliers, streamed=streamed)


def errors_of(data: Partitions, robots: Mapping[str, Robot], executor: Executor | None) -> dict[str, Statistics]:
    """Statistics of the errors of robots on rows that no fit has seen, by name."""
    look = partial(_errors_of, tuple(robots.values()))
    parts: Iterable[list[ErrorMoments]] = over_parts(look, data, (Marks(),) * len(data.parts), executor)
    totals = [reduce(ErrorMoments.plus, each) for each in zip(*parts, strict=True)]
    return {name: total.statistics for name, total in zip(robots, totals, strict=True)}


@one_thread
def _errors_of(robots: tuple[Robot, ...], marked: Marked) -> list[ErrorMoments]:
    data = marked.part.read()
    return [ErrorMoments.of(residuals(robot, data)) for robot in robots]
