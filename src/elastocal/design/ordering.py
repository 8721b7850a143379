"""The order in which poses are measured: a short way through the joints' space."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.measurements import Measurements

Order = NDArray[np.intp]

LONGEST_PIECE = 3
"""Poses that are moved together to another place of the order."""

MANY = 300
"""From so many poses on, only a few are tried as the first, and the order is improved this many times per pose less."""

FIRST_TRIED = 5

CHANGES = {"load": 1e2, "target": 1e4, "station": 1e6}
"""What a change of payload, target or station counts, in largest joint moves [rad or m]: each is made as seldom as may
be, the dearest the most so."""


def moves(q: Array, other: Array) -> Array:
    """The largest joint move from each of q (n, joints) to each of other (m, joints), (n, m) [rad or m]."""
    largest = np.zeros((len(q), len(other)))
    for one, two in zip(q.T, other.T, strict=True):
        np.maximum(largest, np.abs(one[:, None] - two), out=largest)
    return largest


def travel(q: Array, start: Array | None = None) -> float:
    """Sum of the largest joint moves from pose to pose, from start on if there is one [rad or m]."""
    way = q if start is None else np.vstack([start, q])
    return float(np.abs(np.diff(way, axis=0)).max(axis=1).sum())


def short_order(data: Measurements, start: Array | None = None) -> Order:
    """An order of the poses with short travel, those of one station, target and payload together.

    Args:
        data: the poses.
        start: (joints,) where the robot is at first; None: the first pose is free.
    """
    n = len(data)
    costs = moves(data.q, data.q)
    for name, cost in CHANGES.items():
        labels = getattr(data, name)
        if labels is not None:
            costs = costs + cost * (labels.codes[:, None] != labels.codes)
    # one more place, from which everything is as near as from the start, or as nothing
    away = np.zeros(n) if start is None else moves(start[None], data.q)[0]
    costs = np.block([[costs, np.zeros((n, 1))], [away[None], np.zeros((1, 1))]])
    firsts = range(n) if start is None else [int(np.argmin(away))]
    ways = sorted((_nearest_neighbours(costs, first) for first in _some(firsts)), key=lambda way: _length(costs, way))
    found = [_improved(costs, way) for way in ways[: 1 if n > MANY else FIRST_TRIED]]
    return min([*found, np.arange(n)], key=lambda way: _length(costs, way))


def _some(firsts: range | list[int]) -> list[int]:
    return list(firsts) if len(firsts) <= MANY else list(firsts)[:: len(firsts) // FIRST_TRIED]


def _length(costs: Array, way: Order) -> float:
    """Of a way from the last place of the costs through all others."""
    return float(costs[-1, way[0]] + costs[way[:-1], way[1:]].sum())


def _nearest_neighbours(costs: Array, first: int) -> Order:
    """From each pose to the nearest that is left."""
    n = len(costs) - 1
    left, way = np.ones(n, dtype=bool), [first]
    left[first] = False
    for _ in range(n - 1):
        way.append(int(np.argmin(np.where(left, costs[way[-1], :n], np.inf))))
        left[way[-1]] = False
    return np.array(way, dtype=np.intp)


def _improved(costs: Array, way: Order) -> Order:
    """Turn pieces of the way around and move short ones, the best first, until nothing helps."""
    least = 1e-12 * (1.0 + _length(costs, way))
    for _ in range(10 * MANY):
        gain, changed = max((_turned(costs, way), _moved(costs, way)), key=lambda found: found[0])
        if gain <= least:
            break
        way = changed
    return way


def _turned(costs: Array, way: Order) -> tuple[float, Order]:
    """The best piece to turn around (2-opt, Croes 1958): what it gains, and the way then."""
    n = len(way)
    before, after = np.append(n, way[:-1]), np.append(way[1:], n)
    step, last = costs[before, way], costs[way, after]
    # the costs are the same both ways but for those of the start, which stays before the first
    gains = step[:, None] + last[None] - costs[before[:, None], way[None]] - costs[way[:, None], after[None]]
    i, j = np.unravel_index(int(np.argmax(np.triu(gains, 1))), gains.shape)
    return float(np.triu(gains, 1)[i, j]), np.concatenate([way[:i], way[i : j + 1][::-1], way[j + 1 :]])


def _moved(costs: Array, way: Order) -> tuple[float, Order]:
    """The best short piece to move elsewhere, either way round (Or, 1976)."""
    n, best = len(way), (0.0, way)
    for size in range(1, min(LONGEST_PIECE, n - 1) + 1):
        for start in range(n - size + 1):
            piece = way[start : start + size]
            rest = np.concatenate([[n], way[:start], way[start + size :], [n]])
            closed = costs[rest[start], rest[start + 1]]
            freed = costs[rest[start], piece[0]] + costs[piece[-1], rest[start + 1]] - closed
            for turned in (piece, piece[::-1]):
                added = costs[rest[:-1], turned[0]] + costs[turned[-1], rest[1:]] - costs[rest[:-1], rest[1:]]
                place = int(np.argmin(added))
                if freed - added[place] > best[0]:
                    found = np.concatenate([rest[1 : place + 1], turned, rest[place + 1 : -1]])
                    best = float(freed - added[place]), found
    return best
