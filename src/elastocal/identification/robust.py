"""Losses that large residuals count less in: a fit of which a few wild rows cannot take hold.

A row counts as a whole, by its size u: the root of the sum of squares of all its coordinates, each over its standard
deviation. Iteratively reweighted least squares with weights w(u), the scale from the median of the rows' sizes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.errors import InputError, unknown_name
from elastocal.identification.solver import Solution, descend, fit
from elastocal.identification.sums import FLOOR, Variances, normal_sums, observation_variance
from elastocal.prediction import Model

LOSSES = ("linear", "huber", "cauchy")

TUNING: Mapping[str, Mapping[int, float]] = {
    "huber": {1: 1.345, 3: 1.628, 4: 1.731, 6: 1.869, 7: 1.897},
    "cauchy": {1: 2.385, 3: 2.666, 4: 2.752, 6: 2.862, 7: 2.896},
}
"""The size from which rows count less, by the number of a row's coordinates: with normal errors the variances of the
parameters grow by 1/0.95 (of one coordinate: Holland and Welsch, 1977; of several: the same condition, with the
efficiency of Maronna, 1976)."""

MEDIAN = {1: 0.4549, 3: 2.3660}
"""The median of the sum of squares of so many standard normal coordinates (chi-square)."""

MAX_ROUNDS, SETTLED = 50, 0.01
"""Reweightings at most, and the largest change of a weight after which they end."""


def require_loss(loss: str) -> None:
    """Check that there is such a loss.

    Raises:
        InputError: there is not.
    """
    if loss not in LOSSES:
        raise InputError(f"loss: {unknown_name('loss', loss, LOSSES)}")


def weights_of(loss: str, sizes: Array, coordinates: NDArray[np.intp]) -> Array:
    """How much rows count, (n,), by their sizes (n,) and the numbers of their coordinates (n,)."""
    known = TUNING[loss]
    limits = np.array([known.get(int(c), np.inf) for c in range(int(coordinates.max(initial=0)) + 1)])[coordinates]
    if loss == "huber":
        return np.minimum(1.0, limits / np.maximum(sizes, 1e-300))
    return 1.0 / (1.0 + (sizes / limits) ** 2)


def fit_robustly(model: Model, start: Array, loss: str) -> tuple[Model, Solution]:
    """Minimise Huber's or Cauchy's loss of the rows' sizes, from the fit of least squares on.

    Cauchy's loss has several minima, and begins where Huber's, which has one, ends.

    Args:
        model: predicts the data.
        start: displacements (parameters,) to start from.
        loss: "huber" or "cauchy".

    Returns:
        The model with the weights of its rows, and the fit with these weights.

    Raises:
        EquilibriumError: the robot at `start` does not settle under its load.
    """
    solution = fit(model, start)
    for each in dict.fromkeys(("huber", loss)):
        model, solution = _reweighed(model, solution, each)
    return model, solution


def _reweighed(model: Model, solution: Solution, loss: str) -> tuple[Model, Solution]:
    """Weights and fit in turn until they agree."""
    for _ in range(MAX_ROUNDS):
        before = model.weights
        model, weighed = with_weights(model, solution.displacements, loss)
        displacements, sums, steps, _ = descend(model, weighed.displacements, weighed.sums, weighed.variances)
        settled = same_weights(before, model.weights)
        solution = Solution(displacements, sums, weighed.variances, solution.steps + steps, settled)
        if settled:
            break
    return model, solution


def same_weights(before: Array | None, after: Array | None) -> bool:
    """Whether two sets of weights (n,) are the same but for trifles."""
    return before is not None and after is not None and float(np.abs(after - before).max(initial=0.0)) < SETTLED


def with_weights(model: Model, displacements: Array, loss: str) -> tuple[Model, Solution]:
    """The model with the weights that its residuals at displacements (parameters,) ask for, and its sums there."""
    seen = _Seen.of(model, displacements)
    variances = seen.variances(len(model.names))
    model = replace(model, weights=weights_of(loss, seen.sizes(variances), seen.coordinates))
    return model, Solution(displacements, normal_sums(model, displacements, variances), variances, 0, True)


@dataclass(frozen=True)
class _Seen:
    """Residuals of all rows at some displacements.

    Attributes:
        squares: by kind, (n, channels) residual^2; zero where nothing was observed.
        stated: by kind, (n, channels) stated variances, zero where none is stated.
        observed: by kind, (n,) whether there is an observation.
    """

    squares: dict[str, Array]
    stated: dict[str, Array]
    observed: dict[str, NDArray[np.bool_]]

    @classmethod
    def of(cls, model: Model, displacements: Array) -> _Seen:
        """The residuals of a model's data."""
        n = len(model.data)
        seen = cls({}, {}, {})
        for part in model.parts(displacements, derivatives=False):
            shape = (n, len(part.residual))
            for table in (seen.squares, seen.stated):
                table.setdefault(part.kind, np.zeros(shape))
            seen.observed.setdefault(part.kind, np.zeros(n, dtype=bool))[part.rows] = True
            seen.squares[part.kind][part.rows] = (part.residual**2).T
            variance = observation_variance(model.data, part, 0.0)[:, 0]
            seen.stated[part.kind][part.rows] = np.broadcast_to(variance, part.residual.shape).T
        return seen

    @property
    def coordinates(self) -> NDArray[np.intp]:
        """(n,) how many coordinates of each row were observed."""
        counts = [self.squares[kind].shape[1] * observed for kind, observed in self.observed.items()]
        return np.sum(counts, axis=0)

    def variances(self, parameters: int) -> Variances:
        """Model variances with which the median row has the size that its degrees of freedom let expect."""
        count = int(self.coordinates.sum())
        share = max(count - parameters, 1) / max(count, 1)
        found: dict[str, float] = {}
        for kind, observed in self.observed.items():
            squares, stated = self.squares[kind][observed], self.stated[kind][observed]
            found[kind] = _median_variance(squares, stated, share * MEDIAN[squares.shape[1]])
        return found

    def sizes(self, variances: Variances) -> Array:
        """(n,) root of the sum of squares of each row's coordinates over their variances."""
        each = [(squares / (self.stated[kind] + variances[kind])).sum(axis=1) for kind, squares in self.squares.items()]
        return np.sqrt(np.sum(each, axis=0))


def _median_variance(squares: Array, stated: Array, median: float) -> float:
    """The variance that must be added to the stated ones (n, channels) so that the rows' median is as expected."""

    def typical(variance: float) -> float:
        return float(np.median((squares / (stated + variance)).sum(axis=1)))

    low, high = FLOOR, max(float(np.median(squares.sum(axis=1))) / median, FLOOR)
    if not stated.max(initial=0.0) > FLOOR or typical(low) <= median:
        return high if not stated.max(initial=0.0) > FLOOR else low
    for _ in range(BISECTIONS):
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if typical(middle) > median else (low, middle)
    return high


BISECTIONS = 40
