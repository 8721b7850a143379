"""Transition torques worth trying: one between every two neighbouring loads of the data.

Between two neighbouring loads a step's fit does not change, so that nothing is lost.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.elasticity import HINGE

FEWEST = 3
"""Distinct loads that each side keeps: fewer would fit a coefficient to noise."""

SAME = 1e-4
"""Loads that differ by less than this, relative to the largest, are one: a pose measured again."""


DENSE = 20.0
"""Loads without a gap over so many times SAME are not one pose, but many."""

MOST, MOST_OF_MANY = 1000, 300
"""Torques of one element that are compared at once, of up to two elements and of more; where there are more gaps
between loads, some are left out at first."""

ZOOM = 30
"""Torques between the two neighbours of a hinge's best one, to look closer."""


@dataclass(frozen=True)
class Grid:
    """Transition torques of one element that are compared with one another.

    Attributes:
        loads: (n,) size of the load on the element in each row [N m or N].
        torques: (k,) ascending.
        smooth: whether the fit changes between neighbouring loads, as a hinge's does.
        whole: whether there is one in every gap between neighbouring loads.
    """

    loads: Array
    torques: Array
    smooth: bool
    whole: bool

    @cached_property
    def bins(self) -> NDArray[np.intp]:
        """(n,) how many of the torques put a row on the high side; these are the first ones."""
        return np.searchsorted(self.torques, self.loads, side="right")

    def zoomed(self, index: int) -> Grid:
        """A closer look at the neighbourhood of a torque, where there is more to see."""
        low = float(self.torques[max(index - 1, 0)])
        high = float(self.torques[min(index + 1, len(self.torques) - 1)])
        if self.smooth and high > low:
            return replace(self, torques=np.linspace(low, high, ZOOM + 1))
        return self if self.whole else load_grid(self.loads, self.smooth, MOST, (low, high))


def grids_of(loads: Mapping[str, Array], laws: Mapping[str, str]) -> dict[str, Grid]:
    """The grids of elements with step or hinge laws, from their loads (n,)."""
    most = MOST if len(laws) <= 2 else MOST_OF_MANY
    return {element: load_grid(loads[element], law == HINGE.name, most) for element, law in laws.items()}


def load_grid(loads: Array, smooth: bool, most: int = MOST, within: tuple[float, float] = (0.0, np.inf)) -> Grid:
    """The middles of the gaps between loads (n,), at most `most` of them, evenly chosen if there are more.

    Where the loads are too few for any, the middle of their range is the only one.
    """
    sizes = np.abs(loads)
    ordered = np.sort(sizes)
    gaps = group_starts(ordered, SAME * float(ordered[-1]))[1:] - 1
    torques = 0.5 * (ordered[gaps] + ordered[gaps + 1])[FEWEST - 1 : len(gaps) - FEWEST + 1]
    torques = torques[(within[0] <= torques) & (torques <= within[1])]
    if not len(torques):
        middle = 0.5 * (ordered[0] + ordered[-1])
        return Grid(sizes, np.array([middle if middle > 0.0 else 1.0]), smooth, True)
    if len(torques) <= most:
        return Grid(sizes, torques, smooth, True)
    return Grid(sizes, torques[np.linspace(0, len(torques) - 1, most).round().astype(int)], smooth, False)


def group_starts(ordered: Array, least: float) -> NDArray[np.intp]:
    """Where groups of like loads start in ascending ones (n,): between groups is a gap of more than `least`.

    Loads so dense that there is no gap for long are divided all the same, every `least`.
    """
    if not len(ordered):
        return np.empty(0, dtype=np.intp)
    starts = np.concatenate([[0], np.flatnonzero(np.diff(ordered) > least) + 1])
    ends = np.append(starts[1:], len(ordered))
    found: list[int] = []
    for start, end in zip(starts.tolist(), ends.tolist(), strict=True):
        found.append(start)
        if ordered[end - 1] - ordered[start] > DENSE * least:
            while (start := int(np.searchsorted(ordered, ordered[start] + least, side="right"))) < end:
                found.append(start)
    return np.array(found, dtype=np.intp)
