"""What a choice of poses leads to: standard deviations of the parameters, accuracy of the predicted position."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.design.criteria import Criterion
from elastocal.design.exchange import Pool, exchange, greedy_choice
from elastocal.design.result import CurvePoint, PlannedParameter
from elastocal.design.rules import Chosen
from elastocal.design.task import Task
from elastocal.identification.calibration import UNSEEN_SHARE
from elastocal.identification.solver import Normal
from elastocal.identification.table import standard_deviations
from elastocal.parameters import parameters_of
from elastocal.robot import Robot

CURVE_STEP, CURVE_FIRST, CURVE_LAST = 5, 10, 60
"""The curve is of every fifth number of poses, at least this far."""

CURVE_GAIN = 1e-4
"""Exchanges for the curve end at this gain of the score: it is read to a per cent."""

DRAWS = 25
"""Random choices whose median a plan is compared with."""

FLAT = 0.05
"""Enough poses are those from which five more improve the accuracy by less than this."""


@dataclass(frozen=True)
class Precision:
    """What poses tell of a task's parameters, in metres.

    Attributes:
        covariance: (names, names), along the directions that are seen.
        unseen: (names,) which parameters are not told.
    """

    covariance: Array
    unseen: NDArray[np.bool_]

    @classmethod
    def of(cls, gram: Array) -> Precision:
        """Of a normal matrix (names, names)."""
        normal = Normal.of_gram(np.pad(gram, (0, 1)))
        share = (normal.vectors[:, ~normal.seen] ** 2).sum(axis=1)
        return cls(normal.covariance, share > UNSEEN_SHARE)

    def accuracy(self, wanted: Array) -> float | None:
        """Root mean square deviation of the position over the workspace [m]; None where a parameter is not told."""
        return None if self.unseen.any() else float(np.sqrt((self.covariance * wanted).sum()))


def gram_of(pool: Pool, chosen: Chosen) -> Array:
    """Normal matrix (names, names) of a choice and of what is known, nothing taken for granted, in the first view."""
    first = pool.first
    rows = first.rows[:, :, chosen].transpose(1, 0, 2).reshape(len(first.known), -1)
    return first.known + rows @ rows.T


def accuracy_of(pool: Pool, wanted: Array, chosen: Chosen) -> float | None:
    """Root mean square deviation of the position over workspace and views [m]; None where a parameter is not told.

    Args:
        pool: what there is to choose from.
        wanted: (views, p, p) mean of JᵀJ over the workspace.
        chosen: of the candidates.
    """
    found = [Precision.of(gram_of(view, chosen)).accuracy(each) for view, each in zip(pool.views, wanted, strict=True)]
    told = [value for value in found if value is not None]
    return float(np.sqrt(np.mean(np.square(told)))) if len(told) == len(found) else None


def planned_parameters(nominal: Robot, task: Task, precision: Precision) -> tuple[PlannedParameter, ...]:
    """Standard deviations to expect, frames' as roll, pitch and yaw."""
    covariance = precision.covariance / np.outer(task.scale, task.scale)
    deviations = standard_deviations(task.robot, task.names, covariance)
    unseen = dict(zip(task.names, precision.unseen.tolist(), strict=True))
    before, told = parameters_of(nominal), parameters_of(task.robot)
    return tuple(
        PlannedParameter(
            name=name,
            unit=told[name].unit,
            nominal=before[name].nominal if name in before else None,
            std=None if unseen[name] else deviations[name],
        )
        for name in task.names
        if name not in task.unmeant
    )


def accuracy_curve(
    pool: Pool,
    criterion: Criterion,
    wanted: Array,
    chosen: Chosen,
    rng: np.random.Generator,
) -> tuple[CurvePoint, ...]:
    """The accuracy of 10, 15, 20, … poses: chosen by the criterion, each more from the one before, and at random.

    Args:
        pool: what there is to choose from.
        criterion: to choose by.
        wanted: (views, p, p) mean of JᵀJ over the workspace.
        chosen: the plan's own poses.
        rng: draws the random ones.
    """
    most = min(max(CURVE_LAST, len(chosen) + 3 * CURVE_STEP), len(pool.rules.free))
    numbers = sorted({*range(CURVE_FIRST, most + 1, CURVE_STEP), len(chosen)})
    points, current = [], np.empty(0, dtype=np.intp)
    for number in numbers:
        planned = None
        if number == len(chosen):
            current = chosen
        elif _may_tell(pool, number):
            current = exchange(pool, criterion, greedy_choice(pool, number, rng, current), CURVE_GAIN)
        if len(current) == number:
            planned = accuracy_of(pool, wanted, current)
        points.append(CurvePoint(number, planned, _at_random(pool, wanted, number, rng)))
    return tuple(points)


def _may_tell(pool: Pool, number: int) -> bool:
    """Whether so many poses give enough equations, with what is known."""
    return number >= fewest(pool)


def fewest(pool: Pool) -> int:
    """The fewest poses that can give as many equations as there are parameters left."""
    first = pool.first
    channels, p, _ = first.rows.shape
    known = int(Normal.of_gram(np.pad(first.known, (0, 1))).seen.sum()) if first.known.any() else 0
    return -(-(p - known) // channels)


def _at_random(pool: Pool, wanted: Array, number: int, rng: np.random.Generator) -> float | None:
    """The median accuracy of random choices."""
    if not _may_tell(pool, number):
        return None
    draws = (rng.choice(pool.rules.free, number, replace=False) for _ in range(DRAWS))
    found = [accuracy_of(pool, wanted, draw) for draw in draws]
    told = [value for value in found if value is not None]
    return float(np.median(told)) if len(told) > DRAWS // 2 else None


def enough(curve: Sequence[CurvePoint]) -> int | None:
    """The fewest poses of a curve from which five more improve the accuracy by less than FLAT, to its end."""
    found = None
    for here, following in reversed(list(pairwise(curve))):
        if here.planned is None or following.planned is None:
            break
        gain = 1.0 - (following.planned / here.planned) ** (CURVE_STEP / (following.poses - here.poses))
        if gain >= FLAT:
            break
        found = here.poses
    return found
