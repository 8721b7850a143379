"""Normal equations, block by block: all that a step and a covariance need of the data, whatever their number."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from elastocal.chain import Array
from elastocal.measurements import KINDS, Measurements
from elastocal.prediction import Model, Part, kind_of

if TYPE_CHECKING:
    from elastocal.identification.partitioned import Partitioned

Variances = Mapping[str, float]
"""Model variance [m2 or rad2] by channel, or by kind of observation: what adds to the stated variances."""

FLOOR = 1e-9**2
"""No observation is better than a nanometre or a nanoradian; keeps weights finite on data without noise."""


@dataclass(frozen=True)
class KindSums:
    """Sums over the observed coordinates of one kind, each divided by its standard deviation.

    Attributes:
        gram: (parameters + 1, parameters + 1) of the Jacobian with the residual as its last row.
        count: number of coordinates, each as often as its row's weight says.
        curvature: sum of residual^2 / variance^2.
        stated: whether any of them has a standard deviation of its own.
    """

    gram: Array
    count: float
    curvature: float
    stated: bool

    @property
    def misfit(self) -> float:
        """Sum of residual^2 / variance."""
        return float(self.gram[-1, -1])

    @property
    def variance(self) -> float:
        """The observations' mean variance, stated and model's together, as the residuals weigh it."""
        return self.misfit / self.curvature if self.curvature > 0.0 else 0.0

    def plus(self, more: KindSums) -> KindSums:
        """The sums over the coordinates of both."""
        gram, count, curvature = self.gram + more.gram, self.count + more.count, self.curvature + more.curvature
        return KindSums(gram, count, curvature, self.stated or more.stated)


Sums = Mapping[str, KindSums]


def misfit_of(sums: Sums) -> float:
    """Sum of residual^2 / variance over all kinds."""
    return sum(found.misfit for found in sums.values())


def normal_sums(model: Model | Partitioned, displacements: Array, variances: Variances, held: bool = False) -> Sums:
    """Sum over all data at displacements (parameters,).

    Args:
        model: predicts the data, in memory or in parts.
        displacements: of its parameters.
        variances: the model variances.
        held: whether deflections are held at zero.

    Raises:
        EquilibriumError: a pose does not settle under its load.
    """
    if not isinstance(model, Model):
        return model.normal_sums(displacements, variances, held)
    size = len(model.names) + 1
    grams: dict[str, Array] = defaultdict(lambda: np.zeros((size, size)))
    counts: dict[str, float] = defaultdict(float)
    curvatures: dict[str, float] = defaultdict(float)
    stated: dict[str, bool] = defaultdict(bool)
    for part in model.parts(displacements, held=held):
        kind, rows = part.channel, part.jacobian
        variance = observation_variance(model.data, part, variance_of(variances, part))
        stated[kind] = stated[kind] or variance.size > 1
        if variance.size == 1 and model.weights is None:  # divide the small sum instead of the large Jacobian
            gram = (rows @ rows.swapaxes(1, 2)).sum(axis=0) / variance[0, 0]
            grams[kind] += gram
            counts[kind] += part.residual.size
            curvatures[kind] += float(gram[-1, -1] / variance[0, 0, 0])
            continue
        weights = np.ones(1) if model.weights is None else model.weights[part.rows]
        curvatures[kind] += float((weights * (part.residual / variance[:, 0]) ** 2).sum())
        counts[kind] += float(np.broadcast_to(weights, part.residual.shape).sum())
        rows *= np.sqrt(weights / variance)
        grams[kind] += (rows @ rows.swapaxes(1, 2)).sum(axis=0)
    found = sorted((channel for channel in grams if counts[channel]), key=_rank)
    return {c: KindSums(grams[c], counts[c], curvatures[c], stated[c]) for c in found}


def added(parts: Iterable[Sums]) -> Sums:
    """The sums of several parts of the data together, added in their order."""
    total: dict[str, KindSums] = {}
    for part in parts:
        for channel, more in part.items():
            total[channel] = total[channel].plus(more) if channel in total else more
    return {channel: total[channel] for channel in sorted(total, key=_rank)}


def _rank(channel: str) -> tuple[int, str]:
    """Positions before orientations before distances, whatever comes first in the data."""
    return KINDS.index(kind_of(channel)), channel


def variance_of(variances: Variances, part: Part) -> float:
    """The model variance of a part's channel, or of its kind where that is all that is known."""
    return variances.get(part.channel, variances.get(part.kind, 0.0))


def observation_variance(data: Measurements, part: Part, model_variance: float) -> Array:
    """Variance of a part's coordinates, (1 or coordinates, 1, 1 or n): stated variance plus the model's."""
    sigma = data.sigma_angle if part.kind == "orientation" else data.sigma
    if sigma is None:
        return np.full((1, 1, 1), max(model_variance, FLOOR))
    stated = np.nan_to_num(sigma[part.rows].reshape(len(part.rows), -1).T[: len(part.residual)])
    return np.maximum(stated**2 + model_variance, FLOOR)[:, None]


def reweighed(
    model: Model | Partitioned, displacements: Array, sums: Sums, before: Variances, after: Variances
) -> Sums:
    """The sums with other model variances: rescaled where the data state none, summed again where they do."""
    if any(found.stated for found in sums.values()):
        return normal_sums(model, displacements, after)
    rescaled = {}
    for kind, found in sums.items():
        factor = max(before[kind], FLOOR) / max(after[kind], FLOOR)
        rescaled[kind] = replace(found, gram=factor * found.gram, curvature=factor**2 * found.curvature)
    return rescaled
