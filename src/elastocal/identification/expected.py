"""What error to expect on poses that a fit has not seen: every pose predicted by the fit without it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.errors import EquilibriumError
from elastocal.identification.attempt import Attempt
from elastocal.identification.influence import Influence, influence
from elastocal.identification.solver import Normal
from elastocal.identification.statistics import Residuals, Statistics, residuals, statistics
from elastocal.identification.sums import normal_sums
from elastocal.identification.transition import Problem, Trial
from elastocal.measurements import SAME_POSE, Measurements
from elastocal.prediction import Model

MOST_ROWS = 5000
"""So many rows tell the error to 1 %; of more, some poses are chosen at random, and the rest is left alone."""


def expected_error(fitted: Attempt, model: Model, covariance: Array) -> Statistics | None:
    """Statistics of the residuals of each row under the fit without its pose.

    To first order, in which hinges' transition torques move with the other parameters. A step's torque lies in the
    middle of a gap between loads, and does not move but for the poses at the gap's edges: of these it is known only
    since they were fitted. Those that would find themselves on the other side are left out of a fit of their own.

    Args:
        fitted: the fit.
        model: what was fitted, with the transition torques of hinges among its parameters.
        covariance: (parameters of `model`,) squared, for unit variance: the inverse of the normal matrix.

    Returns:
        Of all rows, or of some poses if there are more than MOST_ROWS; None where a pose decides a parameter alone,
        so that there is no fit without it.

    Raises:
        EquilibriumError: a pose does not settle under its load.
    """
    solution, rows = fitted.solution, some_poses(model.data, MOST_ROWS)
    some = model if len(rows) == len(model.data) else of_rows(model, rows)
    displacements = np.append(solution.displacements, np.zeros(len(model.names) - len(solution.displacements)))
    found = influence(some, displacements, covariance, solution.variances)
    if any(np.isinf(values).any() for values in found.left_out.values()):
        return None
    if some is model and fitted.prior is None and fitted.search is not None and fitted.search.method != "given":
        problem = replace(fitted.problem.after(fitted.trial), variances=solution.variances)
        _refit_deciding(problem, fitted.trial, found)
    distance = found.left_out.get("distance")
    position, orientation = found.left_out.get("position"), found.left_out.get("orientation")
    return statistics(Residuals(len(rows), position, orientation, None if distance is None else distance[:, 0]))


def _refit_deciding(problem: Problem, trial: Trial, found: Influence) -> None:
    """Enter the residuals of poses that change sides when left out, after one step of a fit without them."""
    for number, torques in _deciding(trial, found.pose).items():
        kept, left = np.flatnonzero(found.pose != number), np.flatnonzero(found.pose == number)
        model = of_rows(problem.model(torques), kept)
        try:
            step = Normal.of(normal_sums(model, problem.start, problem.variances)).step(0.0)
            errors = residuals(model.displaced(problem.start + step), problem.data.take(left))
        except EquilibriumError:
            continue
        for kind, values in found.left_out.items():
            values[left] = getattr(errors, kind).reshape(len(left), -1)


def _deciding(trial: Trial, pose: NDArray[np.intp]) -> dict[int, dict[str, float]]:
    """Poses that lie on the other side of a step once it is in the middle of the gap without them, and all torques."""
    deciding: dict[int, dict[str, float]] = {}
    for element in trial.gaps:
        sizes = np.abs(trial.loads[element])
        high = sizes >= trial.torques[element]
        for edge in (np.where(high, -np.inf, sizes).argmax(), np.where(high, sizes, np.inf).argmin()):
            others = pose != pose[edge]
            if (others & high).any() and (others & ~high).any():
                middle = 0.5 * float(sizes[others & ~high].max() + sizes[others & high].min())
                if ((sizes[~others] >= middle) != high[~others]).any():
                    deciding.setdefault(int(pose[edge]), dict(trial.torques))[element] = middle
    return deciding


def of_rows(model: Model, rows: NDArray[np.intp]) -> Model:
    """The model of some of its rows."""
    sides: Mapping[str, Array] = {element: loads[rows] for element, loads in model.sides.items()}
    weights = None if model.weights is None else model.weights[rows]
    return replace(model, data=model.data.take(rows), sides=sides, weights=weights)


def some_poses(data: Measurements, most: int) -> NDArray[np.intp]:
    """All rows, ascending, or those of about as many poses, chosen at random, as have `most` rows.

    Only the poses of `most` rows are looked for, since to tell the poses of all rows apart takes longer than a fit.
    """
    n = len(data)
    if n <= most:
        return np.arange(n)
    from scipy.spatial import cKDTree  # imported late: it takes longer than a calibration

    drawn = np.random.default_rng(0).permutation(n)[:most]
    shared = cKDTree(data.q).query_ball_point(data.q[drawn], SAME_POSE, p=np.inf)
    rows_of: dict[int, list[int]] = {}
    if data.pose is not None:
        order = np.argsort(data.pose, kind="stable")
        first = np.searchsorted(data.pose[order], data.pose[drawn], side="left")
        last = np.searchsorted(data.pose[order], data.pose[drawn], side="right")
        numbered = zip(drawn.tolist(), data.pose[drawn], first, last, strict=True)
        rows_of = {row: order[start:end].tolist() for row, pose, start, end in numbered if pose >= 0}
    chosen: set[int] = set()
    for row, near in zip(drawn.tolist(), shared, strict=True):
        if len(chosen) >= most:
            break
        chosen.update(near, rows_of.get(row, ()))
    return np.array(sorted(chosen), dtype=np.intp)
