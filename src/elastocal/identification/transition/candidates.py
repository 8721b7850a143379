"""The best combinations of transition torques of a profile, kept apart from one another."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.identification.transition.profile import Profile

STARTS = 20
"""Combinations from which elements are exchanged where there are too many to compare them all."""

APART = 0.05
"""Combinations closer than this in all elements, as a share of the torques, are neighbours: one of them will do."""

Combination = tuple[int, ...]


def best_combinations(profile: Profile, count: int, seed: int = 0) -> list[Combination]:
    """Up to `count` combinations of torques by their numbers in the grids, the best first.

    All combinations of one or two elements are compared; of more, elements are exchanged one by one from several
    starts.
    """
    if len(profile.counts) <= 2:
        return _apart_in_grid(profile.all_misfits(), profile.counts, count)
    found = {_exchanged(profile, start) for start in _starts(profile, seed)}
    ordered = sorted(found, key=lambda combination: float(profile.misfits(np.array([combination]))[0]))
    chosen: list[Combination] = []
    for combination in ordered:
        if all(_far(combination, other, profile.counts) for other in chosen):
            chosen.append(combination)
    return chosen[:count]


def _apart_in_grid(misfits: Array, counts: Combination, count: int) -> list[Combination]:
    left = misfits.copy()
    chosen: list[Combination] = []
    while len(chosen) < count and np.isfinite(left).any():
        best = tuple(int(i) for i in np.unravel_index(int(np.argmin(left)), left.shape))
        chosen.append(best)
        left[tuple(slice(max(0, i - _reach(k)), i + _reach(k) + 1) for i, k in zip(best, counts, strict=True))] = np.inf
    return chosen


def _reach(count: int) -> int:
    return max(1, round(APART * count))


def _far(one: Combination, other: Combination, counts: Combination) -> bool:
    return any(abs(i - j) > _reach(k) for i, j, k in zip(one, other, counts, strict=True))


def _starts(profile: Profile, seed: int) -> NDArray[np.intp]:
    """Each element at its own best, and combinations by chance."""
    rng = np.random.default_rng(seed)
    alone = [int(np.argmax(slope**2 / profile.products[e, e])) for e, slope in enumerate(profile.slopes)]
    return np.vstack([alone, rng.integers(0, profile.counts, (STARTS, len(profile.counts)))])


def _exchanged(profile: Profile, start: NDArray[np.intp]) -> Combination:
    """Give one element after the other its best torque beside the others', until none changes."""
    combination = start.copy()
    changed = True
    while changed:
        changed = False
        for element, count in enumerate(profile.counts):
            tried = np.repeat(combination[None], count, axis=0)
            tried[:, element] = np.arange(count)
            best = int(np.argmin(profile.misfits(tried)))
            changed = changed or best != combination[element]
            combination[element] = best
    return tuple(combination.tolist())
