"""Inverse kinematics of a rigid robot: any chain, many starts, and the same configuration along a path."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.compensation.pool import Pool
from elastocal.compensation.solver import STEPS, Found, Task, position_first, solve, turns
from elastocal.compensation.targets import Goals

STARTS, THEN_STARTS, MORE_STARTS = 3, 8, 28
"""Further starts for a goal that the first one did not lead to: without limits; within them, the first; all."""

QUICK, SOME = 10, 16
"""Steps from one of many starts: where it is slow, another one is quicker."""

NEAR = 0.1
"""Goals nearer to one another than this part of the workspace's size belong to one path."""

STRETCH = 0.5
"""A path is continued so far at once, in the same measure."""

JUMP = 0.35
"""A joint that moves more than this [rad or m] between neighbours on a path is another configuration."""


@dataclass(frozen=True)
class Tail:
    """The row before the first one: the nominal robot's joint positions (joints,), its goal, the corrected ones."""

    q: Array
    goal: Goals
    corrected: Array


def solutions(task: Task, pool: Pool, start: Array | None = None, before: Tail | None = None) -> Found:
    """Joint positions of a rigid robot at all goals of a task.

    Args:
        task: of the rigid robot.
        pool: where searches start.
        start: (joints, n) where each starts first; None: near the pool's preferred pose, and then so that goals near
            one another are reached in one configuration.
        before: the row before the first one, of which a path may be the continuation.
    """
    rows = np.arange(task.goals.position.shape[1])
    first = pool.nearest(task.machine, task.goals, rows) if start is None else start
    found = _unlimited(task, rows, first)
    missed = np.flatnonzero(~found.reached)
    if len(missed):
        _elsewhere(task, pool, found, missed)
    if start is None:
        _joined(task, pool.size, found, before)
    return found


def _unlimited(task: Task, rows: NDArray[np.intp], start: Array) -> Found:
    """As if there were no limits, then whole turns back; what ends beyond the limits is at infinite distance."""
    free = replace(task, low=np.full_like(task.low, -np.inf), high=np.full_like(task.high, np.inf))
    found = solve(free, rows, start, QUICK)
    low, high = task.low[:, rows], task.high[:, rows]
    found.q[:] = _turned_back(found.q, low, high, task.sliding[:, None])
    found.distance[((found.q < low) | (found.q > high)).any(axis=0)] = np.inf
    return found


def _turned_back(q: Array, low: Array, high: Array, sliding: NDArray[np.bool_]) -> Array:
    """Joint positions, whole turns less where they are beyond their limits; sliding joints as they are."""
    turn = 2.0 * np.pi
    with np.errstate(invalid="ignore"):
        whole = np.where(q < low, np.ceil((low - q) / turn), -np.ceil((q - high) / turn))
    beyond = ((q < low) | (q > high)) & ~sliding
    return q + turn * np.where(beyond, whole, 0.0)


def _elsewhere(task: Task, pool: Pool, found: Found, missed: NDArray[np.intp]) -> None:
    """From other starts; then within the limits; then as near as possible, the position first."""
    starts = pool.various(task.machine, task.goals, missed, MORE_STARTS)
    joints = len(starts)
    several = _unlimited(task, np.tile(missed, STARTS), starts[:, :STARTS].reshape(joints, -1))
    _take_best(task, found, missed, several, pool.preferred)
    still = ~found.reached[missed]
    ends = np.concatenate([found.q[:, None, missed], several.q.reshape(joints, STARTS, -1)], axis=1)
    found.distance[missed[still]] = np.inf
    for tries, steps in ((ends, SOME), (starts[:, :THEN_STARTS], SOME), (starts[:, THEN_STARTS:], STEPS)):
        rows = missed[still]
        if len(rows):
            from_these = tries[..., still]
            bounded = solve(task, np.tile(rows, tries.shape[1]), from_these.reshape(joints, -1), steps)
            _take_best(task, found, rows, bounded, pool.preferred)
            still = ~found.reached[missed]
    _nearest(task, found, missed[still])


def _take_best(task: Task, found: Found, rows: NDArray[np.intp], tried: Found, preferred: Array) -> None:
    """Of several tries for each row the best: of those at the goal the one nearest to preferred joint positions."""
    away = np.abs(tried.q - preferred[:, None]).max(axis=0)
    miss = np.where(tried.reached, -1.0 / (1.0 + away), tried.distance + task.weight * tried.angle)
    best = miss.reshape(-1, len(rows)).argmin(axis=0) * len(rows) + np.arange(len(rows))
    better = miss[best] < found.distance[rows] + task.weight * found.angle[rows]
    found.put(rows[better], tried.take(best[better]))


def _nearest(task: Task, found: Found, rows: NDArray[np.intp]) -> None:
    """Take what comes nearer in position, or as near and nearer in orientation."""
    if not len(rows):
        return
    near = position_first(task, rows, found.q[:, rows])
    closer = near.distance < found.distance[rows] - 1e-9
    turned = (near.distance <= found.distance[rows] + 1e-9) & (near.angle < found.angle[rows])
    better = closer | turned
    found.put(rows[better], near.take(np.flatnonzero(better)))


def _joined(task: Task, size: float, found: Found, before: Tail | None) -> None:
    """Solve anew where a path leaves its configuration, from the last row that has it."""
    goals, n = task.goals, len(found.distance)
    step = spacing(goals, before, task.weight)
    near = step < NEAR * size
    settled = ~near
    for _ in range(n):
        previous = np.column_stack([found.q[:, :1] if before is None else before.q[:, None], found.q[:, :-1]])
        leap = np.abs(found.q - previous).max(axis=0)
        jumps = near & ~settled & found.reached & (leap > JUMP)
        if not jumps.any():
            return
        at, stretch = _stretches(jumps, near, step, STRETCH * size)
        tried = solve(task, stretch, previous[:, np.repeat(at, np.bincount(_owner(stretch, at), minlength=len(at)))])
        owner = _owner(stretch, at)
        heads = np.searchsorted(stretch, at)
        held = tried.reached[heads]
        smaller = np.abs(tried.q[:, heads] - previous[:, at]).max(axis=0) < leap[at]
        settled[at] = True
        taken = tried.reached & (held & smaller)[owner]
        found.put(stretch[taken], tried.take(np.flatnonzero(taken)))


def _owner(stretch: NDArray[np.intp], at: NDArray[np.intp]) -> NDArray[np.intp]:
    """Which jump each row of the stretches belongs to."""
    return np.searchsorted(at, stretch, side="right") - 1


def _stretches(
    jumps: NDArray[np.bool_], near: NDArray[np.bool_], step: Array, reach: float
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The first jump of each path, and the rows that follow it on its path within reach, itself among them."""
    path = np.cumsum(~near)
    jumping = np.flatnonzero(jumps)
    at = jumping[np.unique(path[jumping], return_index=True)[1]]
    travelled = np.cumsum(np.where(near, step, 0.0))
    rows = np.arange(len(near))
    owner = np.searchsorted(at, rows, side="right") - 1
    first = at[np.maximum(owner, 0)]
    within = (owner >= 0) & (path == path[first]) & (travelled - travelled[first] <= reach)
    return at, rows[within]


def spacing(goals: Goals, before: Tail | None, weight: float) -> Array:
    """How far each goal is from the one before it [m], orientations included where both have one; (n,)."""
    n = goals.position.shape[1]
    last = goals.take(slice(0, 1)) if before is None else before.goal
    previous = Goals(
        np.column_stack([last.position, goals.position[:, :-1]]),
        np.concatenate([last.rotation, goals.rotation[:, :, :-1]], axis=2),
        np.concatenate([last.oriented, goals.oriented[:-1]]),
        goals.strict,
    )
    both = Goals(goals.position, goals.rotation, goals.oriented & previous.oriented, goals.strict)
    angle = np.linalg.norm(turns(both, previous.rotation), axis=0)
    step = np.linalg.norm(goals.position - previous.position, axis=0) + weight * angle
    if before is None and n:
        step[0] = np.inf
    return step
