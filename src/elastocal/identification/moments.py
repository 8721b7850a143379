"""Statistics of values that come in parts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.chain import Array
from elastocal.identification.statistics import Residuals, Statistics


@dataclass(frozen=True)
class Moments:
    """Of n values: their mean, the largest, the mean of their squares, and the sum of squares about the mean."""

    n: int = 0
    mean: float = 0.0
    largest: float = 0.0
    square: float = 0.0
    spread: float = 0.0

    @classmethod
    def of(cls, values: Array) -> Moments:
        """The moments of values (n,), NaN left out."""
        values = values[np.isfinite(values)]
        if not len(values):
            return cls()
        mean = float(values.mean())
        squares = float((values**2).mean()), float(((values - mean) ** 2).sum())
        return cls(len(values), mean, float(values.max()), *squares)

    def plus(self, more: Moments) -> Moments:
        """The moments of the values of both (Chan, Golub and LeVeque, 1983)."""
        if not self.n or not more.n:
            return more if more.n else self
        n, change = self.n + more.n, more.mean - self.mean
        share = more.n / n
        return Moments(
            n,
            self.mean + change * share,
            max(self.largest, more.largest),
            self.square + (more.square - self.square) * share,
            self.spread + more.spread + change**2 * self.n * share,
        )

    def statistics(self, angle: Statistics | None = None) -> Statistics:
        """What `statistics_of` finds."""
        std = float(np.sqrt(self.spread / self.n)) if self.n else 0.0
        return Statistics(self.n, self.mean, self.largest, float(np.sqrt(self.square)), std, angle)


@dataclass(frozen=True)
class ErrorMoments:
    """Moments of rows' distances [m] and angles [rad]."""

    norms: Moments = Moments()
    angles: Moments = Moments()

    @classmethod
    def of(cls, found: Residuals) -> ErrorMoments:
        """The moments of residuals."""
        return cls(Moments.of(found.norms), Moments() if found.angles is None else Moments.of(found.angles))

    def plus(self, more: ErrorMoments) -> ErrorMoments:
        """The moments of the rows of both."""
        return ErrorMoments(self.norms.plus(more.norms), self.angles.plus(more.angles))

    @property
    def statistics(self) -> Statistics:
        """What `statistics` finds."""
        return self.norms.statistics(self.angles.statistics() if self.angles.n else None)
