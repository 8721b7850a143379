"""Robots with steps and hinges, the problem of finding their transition torques, and slow ways to solve it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from threadpoolctl import ThreadpoolController

from elastocal.identification import choose_gauge, fit_frames
from elastocal.identification.request import requested, with_laws
from elastocal.identification.sums import observation_variance
from elastocal.identification.transition import (
    Problem,
    problem_of,
    searched_laws,
    with_known_torques,
    with_transition,
)
from elastocal.measurements import Measurements
from elastocal.prediction import Model
from elastocal.robot import Compliance, Robot
from support.calibrations import actual_in_gauge, gauge_of

Array = NDArray[np.float64]

SPRINGS = {
    "2": ((5e-6, 2e-6), 222.0),
    "3": ((1e-5, 4e-6), 80.0),
    "5": ((5e-5, 2e-5), 9.0),
}
"""Compliances below and above the transition torques of three joints of the arm."""


CONTROLLER = ThreadpoolController()


@pytest.fixture(autouse=True)
def one_blas_thread() -> Iterator[None]:
    """One thread of BLAS, as in calibrate(): for many small fits, on a busy machine, several times faster."""
    with CONTROLLER.limit(limits=1, user_api="blas"):
        yield


def springs(laws: Mapping[str, str]) -> dict[str, Compliance]:
    """These laws on these joints."""
    return {f"{joint}.theta": Compliance(law, *SPRINGS[joint]) for joint, law in laws.items()}


def actual_arm(nominal: Robot, laws: Mapping[str, str], seed: int = 0, kinds: Sequence[str] = ("position",)) -> Robot:
    """An arm that differs from the nominal one in what can be identified, with steps or hinges on some joints."""
    gauge = gauge_of(nominal, tuple(kinds))
    return replace(actual_in_gauge(nominal, gauge, np.random.default_rng(seed)), elastic=springs(laws))


def problem(nominal: Robot, data: Measurements, laws: Mapping[str, str]) -> Problem:
    """The problem of finding the transition torques, as calibrate() poses it."""
    wished, names = with_laws(nominal, laws)
    gauge = choose_gauge(wished, data, requested(wished, names))
    start = with_known_torques(fit_frames(wished, data, gauge), {})
    return problem_of(start, gauge.kept, data, searched_laws(with_transition(names, wished), wished, gauge))


def whitened(model: Model, displacements: Array, variances: Mapping[str, float]) -> tuple[Array, Array, Array]:
    """Jacobian (coordinates, parameters) and residual, each over its standard deviation, and the rows they are of."""
    jacobians, residuals, rows = [], [], []
    for part in model.parts(displacements):
        deviation = np.sqrt(
            np.broadcast_to(observation_variance(model.data, part, variances[part.kind])[:, 0], part.residual.shape)
        )
        jacobians.append((part.jacobian[:, :-1] / deviation[:, None]).transpose(0, 2, 1).reshape(-1, len(model.names)))
        residuals.append((part.residual / deviation).ravel())
        rows.append(np.tile(part.rows, len(part.residual)))
    return np.concatenate(jacobians), np.concatenate(residuals), np.concatenate(rows)


def dense_misfit(problem: Problem, torques: Mapping[str, float]) -> float:
    """The misfit to first order about the problem's fit, by dense least squares with the columns of a combination."""
    model = problem.model(problem.torques)
    jacobian, residual, rows = whitened(model, problem.start, problem.variances)
    column = dict(zip(model.names, jacobian.T, strict=True))
    coefficients = dict(zip(model.names, problem.start, strict=True))
    for element, torque in torques.items():
        low, high = f"{element}.c_low", f"{element}.c_high"
        values = [problem.robot.elastic[element].coefficients[i] + coefficients[n] for i, n in enumerate((low, high))]
        linear = column[low] + column[high]
        residual = residual + column[low] * values[0] + column[high] * values[1]
        size = np.abs(problem.loads[element])[rows]
        above = (size >= torque).astype(float)
        if problem.laws[element] == "hinge":
            above *= 1.0 - torque / np.maximum(size, torque)
        column[low], column[high] = linear * (1.0 - above), linear * above
    dense = np.stack(list(column.values()), axis=1)
    dense = dense / np.maximum(np.linalg.norm(dense, axis=0), 1e-300)
    found = np.linalg.lstsq(dense, residual, rcond=1e-10)[0]
    return float(((residual - dense @ found) ** 2).sum())
