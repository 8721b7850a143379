"""The loaded robot brought to its goals from the nominal solution, without leaving its configuration."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.compensation.solver import FEW_STEPS, Found, Task, left, position_first, solve

SWING = 0.3
"""A correction that would move a joint further than this [rad or m] is none: near a singularity, a wrist would turn
round for the sake of a milliradian."""

TOGETHER = 5
"""Up to so many laws with a step all combinations of their sides are tried; of more, one after the other changes."""


@dataclass(frozen=True)
class Corrected:
    """Where the loaded robot ended.

    Attributes:
        found: joint positions, and what is left to the goals with the sides as they really are.
        unsettled: (stepping elements, n) laws whose side would change with each correction.
        bounded: (joints, n) joints that may not move further from the nominal solution.
    """

    found: Found
    unsettled: NDArray[np.bool_]
    bounded: NDArray[np.bool_]


def corrected(task: Task, nominal: Found) -> Corrected:
    """Correct the nominal joint positions of every row of a task."""
    free = ~nominal.reached  # what the nominal robot did not reach may be anywhere
    low = np.where(free, task.low, np.maximum(task.low, nominal.q - SWING))
    high = np.where(free, task.high, np.minimum(task.high, nominal.q + SWING))
    bounded = replace(task, low=low, high=high)
    rows = np.arange(len(free))
    stepping = task.machine.stepping
    if stepping:
        found, unsettled = _on_sides(bounded, rows, nominal.q)
    else:
        found, unsettled = _solved(bounded, rows, nominal.q), np.zeros((0, len(free)), dtype=bool)
    at_low = (found.q <= low) & (low > task.low)
    at_high = (found.q >= high) & (high < task.high)
    return Corrected(found, unsettled, at_low | at_high)


def _solved(task: Task, rows: NDArray[np.intp], start: Array) -> Found:
    found = solve(task, rows, start, FEW_STEPS)
    missed = np.flatnonzero(~found.reached & task.goals.oriented[rows])
    if len(missed):
        found.put(missed, position_first(task, rows[missed], found.q[:, missed]))
    return found


def _on_sides(task: Task, rows: NDArray[np.intp], start: Array) -> tuple[Found, NDArray[np.bool_]]:
    """With each law's side held while a row is solved; of the sides that hold at their own solution, if any."""
    stepping = list(task.machine.stepping)
    guess = task.machine.undeflected_loads(start, rows)
    found = _solved(replace(task, sides=guess), rows, start)
    wrong = _wrong(task, rows, found.q, guess)
    unsettled = wrong.copy()
    open_ = np.flatnonzero(wrong.any(axis=0))
    if not len(open_):
        return found, unsettled
    found.distance[open_], found.angle[open_] = left(task, rows[open_], found.q[:, open_])
    for sides in _choices(task, guess[:, open_]):
        whole = np.zeros_like(guess)
        whole[:, open_] = sides
        tried = _solved(replace(task, sides=whole), rows[open_], start[:, open_])
        again = _wrong(task, rows[open_], tried.q, sides)
        tried.distance[:], tried.angle[:] = left(task, rows[open_], tried.q)
        consistent = ~again.any(axis=0)
        old, settled = found.take(open_), ~unsettled[:, open_].any(axis=0)
        nearer = tried.distance + task.weight * tried.angle < old.distance + task.weight * old.angle
        moved = np.abs(tried.q - start[:, open_]).max(axis=0) < np.abs(old.q - start[:, open_]).max(axis=0)
        better = np.where(settled, consistent & moved, consistent | nearer)
        taken = np.flatnonzero(better)
        found.put(open_[taken], tried.take(taken))
        unsettled[:, open_[taken]] = again[:, taken]
    assert len(stepping) == len(unsettled)
    return found, unsettled


def _wrong(task: Task, rows: NDArray[np.intp], q: Array, sides: Array) -> NDArray[np.bool_]:
    """(stepping, k) whose side at q is not the one that was held."""
    stepping = list(task.machine.stepping)
    torques = transition_torques(task)[:, None]
    there = np.abs(task.machine.undeflected_loads(q, rows)[stepping])
    return (there >= torques) != (np.abs(sides[stepping]) >= torques)


def transition_torques(task: Task) -> Array:
    """Of the stepping elements, (stepping,)."""
    springs = task.machine.drivers[0].assembly.springs
    return np.array([springs[i].transition or 0.0 for i in task.machine.stepping])


def _choices(task: Task, guess: Array) -> Iterator[Array]:
    """Loads (elastic, k) that stand for combinations of sides."""
    stepping = list(task.machine.stepping)
    k = len(stepping)
    torques = transition_torques(task)
    if k <= TOGETHER:
        for above in product((False, True), repeat=k):
            sides = guess.copy()
            sides[stepping] = np.where(above, 2.0 * torques + 1.0, 0.0)[:, None]
            yield sides
        return
    for i, torque in zip(stepping, torques, strict=True):
        sides = guess.copy()
        sides[i] = np.where(np.abs(guess[i]) >= torque, 0.0, 2.0 * torque + 1.0)
        yield sides
