"""Cross-validation: what a calibration's error is on poses that it has not seen, without measuring more."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from functools import partial

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.errors import EquilibriumError, InputError
from elastocal.identification import Statistics, residuals, statistics_of
from elastocal.identification.threads import one_thread
from elastocal.measurements import Measurements, folded
from elastocal.parallel import in_order
from elastocal.robot import Robot


def cross_validate(
    identify: Callable[[Measurements], Robot],
    data: Measurements,
    folds: int = 10,
    seed: int = 0,
    *,
    on_fold: Callable[[int, int], None] | None = None,
    executor: Executor | None = None,
) -> Statistics:
    """Identify a robot as often as there are folds, each time without one of them, and judge it by that one.

    Args:
        identify: from measurements to the identified robot.
        data: what was measured; the rows of one pose are never divided.
        folds: into how many parts the rows are divided.
        seed: of the division.
        on_fold: called with the number of folds done, and of all.
        executor: where they run, which `identify` must be picklable for; None: here, one after the other.

    Returns:
        Statistics of the errors of all rows, each predicted by the robot that was identified without it; infinite
        where a robot does not settle.

    Raises:
        InputError: fewer than two folds, or fewer poses than folds.
    """
    part = folded(data, folds, seed) if folds >= 2 else np.zeros(len(data), dtype=int)
    if folds < 2 or len(np.unique(part)) < folds:
        raise InputError(f"folds is {folds}: expected at least 2, and at most as many as there are poses")
    errors, angles = np.full(len(data), np.inf), np.full(len(data), np.nan)
    for fold, found in enumerate(in_order(partial(_left_out, identify, data, part), range(folds), executor, chunk=1)):
        if found is not None:
            errors[part == fold], angles[part == fold] = found
        if on_fold is not None:
            on_fold(fold + 1, folds)
    if np.isinf(errors).any():
        return Statistics(len(data), *(np.inf,) * 4)
    return statistics_of(errors, statistics_of(angles) if np.isfinite(angles).any() else None)


@one_thread
def _left_out(
    identify: Callable[[Measurements], Robot], data: Measurements, part: NDArray[np.integer], fold: int
) -> tuple[Array, Array] | None:
    """Errors and angles of a fold's rows under the robot identified without them; None if it does not settle."""
    rows = np.flatnonzero(part == fold)
    try:
        found = residuals(identify(data.take(np.flatnonzero(part != fold))), data.take(rows))
    except EquilibriumError:
        return None
    return found.norms, np.full(len(rows), np.nan) if found.angles is None else found.angles
