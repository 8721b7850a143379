"""Which choices of poses are allowed: no two too near one another, and loads on every side of a transition torque."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.errors import InputError

FEWEST_BINS, MOST_BINS, POSES_PER_BIN = 4, 12, 4
"""The range of loads is divided into bins, about so many poses each, where a transition torque is to be searched."""

TRIES = 20
"""Random choices that are tried before poses so far apart are said not to be found."""

Chosen = NDArray[np.intp]


@dataclass(frozen=True)
class Rules:
    """What a choice must keep to.

    Attributes:
        places: (n, joints) joint positions of the candidates in units of the least distance: two that differ by less
            than 1 in every joint are too near.
        taken: (m, joints) of poses that were measured already.
        bins: (elements, n) the bin of the load on each element with a transition torque.
        least: (elements, bins) poses that each bin must have; 0 where there are none to be had.
    """

    places: Array
    taken: Array
    bins: NDArray[np.intp]
    least: NDArray[np.intp]

    def near(self, some: Chosen, others: Chosen) -> NDArray[np.bool_]:
        """Which pairs of candidates are too near, (some, others)."""
        apart = np.ones((len(some), len(others)), dtype=bool)
        for joint in self.places.T:  # joint by joint: a third of the time of all at once
            apart &= np.abs(joint[some][:, None] - joint[others]) < 1.0
        return apart

    @property
    def free(self) -> Chosen:
        """Candidates that are not too near a pose that was measured."""
        near = np.zeros(len(self.places), dtype=bool)
        for place in self.taken:
            near |= (np.abs(self.places - place) < 1.0).all(axis=1)
        return np.flatnonzero(~near)

    def counts(self, chosen: Chosen) -> NDArray[np.intp]:
        """How many of the chosen are in each bin, (elements, bins)."""
        width = self.least.shape[1]
        return np.array([np.bincount(row, minlength=width) for row in self.bins[:, chosen]], dtype=np.intp).reshape(
            self.least.shape
        )

    def allowed(self, chosen: Chosen, entering: Chosen) -> NDArray[np.bool_]:
        """Which exchanges keep to the rules, (chosen, entering)."""
        near = self.near(chosen, entering)
        allowed = near.sum(axis=0) - near == 0
        for bins, have, least in zip(self.bins, self.counts(chosen), self.least, strict=True):
            needed = (have <= least)[bins[chosen]]
            allowed &= ~needed[:, None] | (bins[chosen][:, None] == bins[entering])
        return allowed

    def wanting(self, chosen: Chosen) -> NDArray[np.bool_]:
        """Candidates in a bin that has too few, (n,); all False once every bin has enough."""
        found = np.zeros(len(self.places), dtype=bool)
        for bins, have, least in zip(self.bins, self.counts(chosen), self.least, strict=True):
            found |= (have < least)[bins]
        return found


def rules_of(
    q: Array,
    apart: Array,
    taken: Array,
    loads: Mapping[str, Array],
    torques: Mapping[str, float],
    count: int,
) -> Rules:
    """The rules for `count` of the candidates.

    Args:
        q: (n, joints) joint positions.
        apart: (joints,) least distances of two poses.
        taken: (m, joints) poses measured already.
        loads: (n,) on each element with a transition torque.
        torques: of those whose transition torque is given: both sides are wanted. Of the others it will be searched:
            loads are wanted all over their range.
        count: how many poses are to be chosen.
    """
    bins, least = [], []
    for element, values in loads.items():
        sizes = np.abs(values)
        if element in torques:
            inner, share = np.array([torques[element]]), count // 5
        else:
            number = min(MOST_BINS, max(FEWEST_BINS, count // POSES_PER_BIN))
            low, high = np.quantile(sizes, (0.01, 0.99))
            inner, share = np.linspace(low, high, number + 1)[1:-1], count // (2 * number)
        mine = np.searchsorted(inner, sizes, side="right")
        there = np.bincount(mine, minlength=MOST_BINS)
        bins.append(mine)
        least.append(np.minimum(there, share))
    shape = (len(bins), MOST_BINS)
    places, scaled = q / apart, taken / apart
    return Rules(
        places, scaled, np.array(bins, dtype=np.intp).reshape(len(bins), len(q)), np.array(least).reshape(shape)
    )


def random_choice(rules: Rules, count: int, rng: np.random.Generator, start: Chosen | None = None) -> Chosen:
    """A choice at random that keeps to the rules, in bins with too few first.

    Raises:
        InputError: no such choice is found.
    """
    most = 0
    for _ in range(TRIES):
        chosen = list(() if start is None else start)
        left = rng.permutation(rules.free)
        if chosen:
            left = left[~rules.near(np.array(chosen), left).any(axis=0)]
        while len(chosen) < count and len(left):
            wanting = rules.wanting(np.array(chosen, dtype=np.intp))[left]
            pick = int(left[np.argmax(wanting)])
            chosen.append(pick)
            left = left[~rules.near(np.array([pick]), left)[0]]
        if len(chosen) == count:
            return np.array(chosen, dtype=np.intp)
        most = max(most, len(chosen))
    raise InputError(
        f"found {most} of {count} poses that keep their distance: of {len(rules.places)} candidates the others are "
        "nearer to them, or to poses measured already; ask for a smaller distance, fewer poses or more candidates"
    )
