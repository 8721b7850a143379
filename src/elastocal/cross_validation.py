"""Cross-validation: what a calibration's error is on poses that it has not seen, without measuring more."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from elastocal.errors import EquilibriumError, InputError
from elastocal.identification import Statistics, residuals, statistics_of
from elastocal.measurements import Measurements, folded
from elastocal.robot import Robot


def cross_validate(
    identify: Callable[[Measurements], Robot], data: Measurements, folds: int = 10, seed: int = 0
) -> Statistics:
    """Identify a robot as often as there are folds, each time without one of them, and judge it by that one.

    Args:
        identify: from measurements to the identified robot.
        data: what was measured; the rows of one pose are never divided.
        folds: into how many parts the rows are divided.
        seed: of the division.

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
    for fold in range(folds):
        left_out = np.flatnonzero(part == fold)
        try:
            found = residuals(identify(data.take(np.flatnonzero(part != fold))), data.take(left_out))
        except EquilibriumError:
            continue
        errors[left_out] = found.norms
        if found.angles is not None:
            angles[left_out] = found.angles
    if np.isinf(errors).any():
        return Statistics(len(data), *(np.inf,) * 4)
    return statistics_of(errors, statistics_of(angles) if np.isfinite(angles).any() else None)
