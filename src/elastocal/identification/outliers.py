"""Rows that are grossly wrong: found, listed, and left out of the fit if a robust loss is asked for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.identification.attempt import Attempt
from elastocal.identification.robust import fit_robustly, same_weights, with_weights
from elastocal.identification.solver import Normal, Solution
from elastocal.identification.statistics import Residuals, residuals
from elastocal.identification.studentised import TRIFLE, Rows, Scores, scores, scores_of
from elastocal.identification.sums import FLOOR, normal_sums
from elastocal.measurements import Labels, Measurements
from elastocal.prediction import Model, kind_of
from elastocal.robot import Robot

MOST = 0.4
"""The largest share of rows that are left out: where more do not fit, it is not for the others to say what is right."""

TOGETHER = 0.5
"""Of several outliers in a fit those go at once whose scores are this share of the largest or more; the others may only
be drawn in by these."""

MAX_ROUNDS, MAX_SEARCHES = 40, 5


@dataclass(frozen=True)
class Outlier:
    """A row that does not fit the others.

    Attributes:
        index: of the row among the fitted ones, from 0.
        file: where it comes from; "" if not from a file.
        row: its number there, from 1.
        kind: the observation that is furthest off, of KINDS.
        residual: measured - predicted by the fit of the others, of that observation [m or rad].
        score: root of F, about 1 for a good row.
        rejected: whether it was left out of the fit.
        hint: the name that it fits, if it bears a wrong one: "target 'nest2'".
    """

    index: int
    file: str
    row: int
    kind: str
    residual: float
    score: float
    rejected: bool
    hint: str = ""


def outliers_of(fitted: Attempt, data: Measurements, good: Rows) -> tuple[Outlier, ...]:
    """The outliers under a fit of the good rows, the worst first: those left out, and those that should be."""
    found = scores_of(fitted, data, good)
    listed = np.flatnonzero(found.accused | ~good)
    listed = listed[np.argsort(-found.values[listed], kind="stable")]
    if not len(listed):
        return ()
    hints = better_names(fitted, data, listed, good & ~found.accused)
    outliers = []
    for index in listed.tolist():
        kind, residual = _furthest_off(fitted, found, index)
        place, score = data.origin(index), float(found.values[index])
        outliers.append(Outlier(index, *place, kind, residual, score, not good[index], hints.get(index, "")))
    return tuple(outliers)


def _furthest_off(fitted: Attempt, found: Scores, row: int) -> tuple[str, float]:
    """The kind of a row's observations that is furthest off in units of its standard deviation, and by how much."""
    sizes = {kind: float(np.linalg.norm(left[row])) for kind, left in found.left_out.items()}
    sizes = {kind: size for kind, size in sizes.items() if not np.isnan(size)}
    sums = fitted.solution.sums
    variance = {kind: max(s.variance for c, s in sums.items() if kind_of(c) == kind) for kind in sizes}
    kind = max(sizes, key=lambda kind: sizes[kind] ** 2 / max(variance[kind], FLOOR))
    return kind, sizes[kind]


BETTER = 3.0
"""A row bears a wrong name if another brings it this many times nearer, and no further off than the good rows are."""


def _robot_of(fitted: Attempt, data: Measurements, rows: Rows) -> Robot:
    """The robot that was fitted, after a step of the fit of these rows where outliers were fitted too."""
    displacements = fitted.solution.displacements
    others = fitted.whole is not None or len(fitted.model.data) > rows.sum()
    if fitted.prior is None and others:
        model = replace(fitted.model, data=data, sides={}, weights=rows.astype(float))
        sums = normal_sums(model, displacements, fitted.solution.variances)
        displacements = displacements + Normal.of(sums).step(0.0)
    return fitted.model.displaced(displacements)


def better_names(fitted: Attempt, data: Measurements, rows: NDArray[np.intp], good: Rows) -> dict[int, str]:
    """Of rows (k,), those that fit another target, payload or station that good rows name, and which."""
    others = list(_other_names(data, good))
    if not others:
        return {}
    robot, named = _robot_of(fitted, data, good), data.take(rows)
    usual = [max(float(sizes.max()), TRIFLE) for sizes in _sizes(residuals(robot, data.take(np.flatnonzero(good))))]
    best, hints = _furthest(residuals(robot, named), usual) / BETTER, {}
    for kind, code, name in others:
        labels: Labels = getattr(named, kind)
        changed: dict[str, Any] = {kind: replace(labels, codes=np.full(len(rows), code, dtype=np.int32))}
        size = _furthest(residuals(robot, replace(named, **changed)), usual)
        for i in np.flatnonzero((size < best) & (size <= 1.0)).tolist():
            best[i], hints[int(rows[i])] = size[i], f"{kind} {name!r}"
    return hints


def _other_names(data: Measurements, good: Rows) -> Iterator[tuple[str, int, str]]:
    """Names that good rows bear, where there are several: what of, their codes, the names."""
    for kind in ("target", "load", "station"):
        labels: Labels | None = getattr(data, kind)
        codes = [] if labels is None else np.unique(labels.codes[good]).tolist()
        if labels is not None and len(codes) > 1:
            yield from ((kind, code, labels.names[code]) for code in codes if code >= 0)


def _furthest(found: Residuals, usual: Sequence[float]) -> Array:
    """(n,) residuals in units of usual ones, of the kind that is furthest off."""
    return np.max([sizes / unit for sizes, unit in zip(_sizes(found), usual, strict=True)], axis=0)


def _sizes(found: Residuals) -> tuple[Array, Array]:
    """(n,) sizes of residuals of positions (or distances) and of orientations; zero where there are none."""
    return np.nan_to_num(found.norms), np.zeros(found.n) if found.angles is None else np.nan_to_num(found.angles)


class Fit(Protocol):
    """Fits rows with the final laws, each counting as its weight says."""

    def __call__(self, rows: Measurements, weights: Array | None = None) -> Attempt:
        """The fit."""


def find_outliers(fit: Fit, model: Model, searched: bool, loss: str) -> Rows:
    """Which rows fit one another, (n,).

    First those that a robust fit does not call outliers; then outliers go, the worst first, and rows come back that the
    fit of the others predicts, until nothing changes.

    Args:
        fit: with the final laws.
        model: of all rows with linear laws; its displacements are zero at the aligned nominal robot.
        searched: whether the final laws are others.
        loss: of the first fit, "huber" or "cauchy".

    Raises:
        EquilibriumError: the robot does not settle under its load.
    """
    data = model.data
    weighed, solution = fit_robustly(model, np.zeros(len(model.names)), loss)
    if searched:
        weighed, solution = _with_final_laws(fit, weighed, loss)
    found = scores(weighed, solution, exact_variance=True)
    good = ~_most_accused(found.accused, found)
    seen: set[bytes] = set()
    while len(seen) < MAX_ROUNDS and good.tobytes() not in seen:
        seen.add(good.tobytes())
        found = scores_of(fit(data.take(np.flatnonzero(good))), data, good)
        good = ~_most_accused(_still_out(found, good), found)
    return good


def _with_final_laws(fit: Fit, weighed: Model, loss: str) -> tuple[Model, Solution]:
    """The robust fit with the final laws, from the weights of that with linear laws.

    Rows beyond a transition torque that few rows are beyond look like outliers to linear laws. A small weight lets the
    search see them, and the torque that it finds gives them their full weight.
    """
    for _ in range(MAX_SEARCHES):
        before, trial = weighed.weights, fit(weighed.data, weighed.weights).trial
        weighed, solution = with_weights(trial.model, trial.solution.displacements, loss)
        if same_weights(before, weighed.weights):
            break
    return weighed, solution


def _still_out(found: Scores, good: Rows) -> Rows:
    """Which rows the next fit leaves out: more while there are outliers in it, else only those that stay outliers."""
    worse = good & found.accused
    if not worse.any():
        return ~good & found.accused
    return ~good | (worse & (found.values >= TOGETHER * found.values[worse].max()))


def _most_accused(out: Rows, found: Scores) -> Rows:
    """Of the rows to leave out no more than may be, the worst ones."""
    most = int(MOST * len(out))
    if out.sum() <= most:
        return out
    ranks = np.argsort(np.argsort(-np.where(out, found.values, -np.inf), kind="stable"), kind="stable")
    return out & (ranks < most)
