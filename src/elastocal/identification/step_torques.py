"""Transition torques of steps, as all rows near them tell them.

A sample leaves a step's transition torque anywhere between two of its loads, where many other rows lie. Which torque is
best for these is found from their residuals on either side, as a running sum over their loads in order.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.identification.transition import STEP_RISE


class Near(NamedTuple):
    """Rows near a step's torque: their numbers in the part, loads, and sums of squares below and above the torque."""

    rows: NDArray[np.intp]
    loads: Array
    below: Array
    above: Array


@dataclass(frozen=True)
class StepTorque:
    """A step's transition torque as all rows near it tell it [N m or N].

    Attributes:
        torque: the middle of its gap.
        gap: the largest load below it and the smallest above it.
        spread: standard deviation, each torque weighed by its likelihood.
        torques: (k,) the middle of each gap between loads, `widths` (k,) of the gaps, and `rises` (k,), how much larger
            the sum of squares is there, in units of the variance that the fit leaves.
    """

    torque: float
    gap: tuple[float, float]
    spread: float
    torques: Array
    widths: Array
    rises: Array

    @property
    def interval(self) -> tuple[float, float]:
        """That covers the true torque with 95 % confidence: the gaps where the rise stays below STEP_RISE."""
        within = np.flatnonzero(self.rises <= STEP_RISE)
        first, last = within[0], within[-1]
        low, high = self.torques[first] - 0.5 * self.widths[first], self.torques[last] + 0.5 * self.widths[last]
        return float(low), float(high)


def best_torque(sampled: float, near: Sequence[Near], variance: float) -> StepTorque:
    """The torque for which the rows near it have the least sum of squares.

    Args:
        sampled: the torque that the sample tells.
        near: the rows of each part.
        variance: what the fit leaves of the variance that it was weighed by.
    """
    if not near:
        return StepTorque(sampled, (sampled, sampled), 0.0, np.array([sampled]), np.zeros(1), np.zeros(1))
    loads = np.concatenate([each.loads for each in near])
    order = np.argsort(loads, kind="stable")
    loads = loads[order]
    gained = np.concatenate([each.below - each.above for each in near])[order]  # by a row that is above, not below
    misfits = np.concatenate([[0.0], np.cumsum(gained)])[1:-1]  # of the torque after each row
    torques, widths = 0.5 * (loads[1:] + loads[:-1]), np.diff(loads)
    apart = widths > 0.0
    if not apart.any():
        return best_torque(sampled, [], variance)
    torques, widths, misfits = torques[apart], widths[apart], misfits[apart]
    rises = (misfits - misfits.min()) / max(variance, 1e-300)
    best = int(np.argmin(rises))
    weights = widths * np.exp(-0.5 * rises)
    weights /= weights.sum()
    spread = weights @ (torques - weights @ torques) ** 2 + max(weights @ widths**2, widths[best] ** 2) / 12.0
    gap = float(torques[best] - 0.5 * widths[best]), float(torques[best] + 0.5 * widths[best])
    return StepTorque(float(torques[best]), gap, float(np.sqrt(spread)), torques, widths, rises)
