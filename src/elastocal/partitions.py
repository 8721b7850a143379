"""Partitions: measurements too many to hold at once, read part by part."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from elastocal.measurements import Measurements

SAMPLE = 50_000
"""Rows of the sample that alignment, searches and outliers are decided on: it tells a parameter to a two-hundredth of
what the noise of one row does, and is worked through in a second."""

FEWEST = 20
"""Rows that each station, target and payload has at least in the sample of a part, if the part has as many."""


class Part(Protocol):
    """Some rows, read when they are asked for. It can be pickled: a worker elsewhere reads them itself."""

    @property
    def rows(self) -> int:
        """How many there are."""

    def read(self) -> Measurements:
        """The rows, with their places in `source` and `row`."""


@dataclass(frozen=True)
class Partitions:
    """Measurements in parts, of which few are in memory at a time.

    Attributes:
        parts: one after the other.
        sample: rows drawn at random from all parts, in order; all rows where they are no more than SAMPLE.
    """

    parts: tuple[Part, ...]
    sample: Measurements

    def __len__(self) -> int:
        return sum(part.rows for part in self.parts)

    @property
    def several_stations(self) -> bool:
        """Whether they are from several stations, each of which the sample has rows of."""
        return len({found.station for found in self.sample.combinations}) > 1


def drawn(data: Measurements, share: float, number: int) -> NDArray[np.intp]:
    """Rows of a part for the sample, ascending: a share of each combination of what is observed, at least FEWEST.

    Args:
        data: the part.
        share: of all rows, 1 or more for all of them.
        number: of the part, which the choice depends on.
    """
    if share >= 1.0:
        return np.arange(len(data))
    rng = np.random.default_rng(number)
    chosen = []
    for found in data.combinations:
        count = min(len(found.rows), max(FEWEST, round(share * len(found.rows))))
        chosen.append(rng.choice(found.rows, count, replace=False, shuffle=False))
    return np.sort(np.concatenate(chosen))
