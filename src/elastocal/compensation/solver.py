"""Damped Newton steps to goals, for all rows of a block at once: inverse kinematics of any chain, rigid or loaded."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array, rotation_vectors
from elastocal.compensation.machine import Machine
from elastocal.compensation.targets import Goals

EXACT = 1e-12
"""Rows nearer to their goal than this [m and rad] need no further step."""

REACHED = 1e-9
"""A goal is reached within this [m and rad]."""

LONGEST = 0.5
"""No joint moves further in one step [rad or m]: linear models do not hold beyond, and branches would be left."""

LEAST_DAMPING, FIRST_DAMPING, MOST_DAMPING = 1e-12, 1e-4, 1e4
"""Damping relative to the largest diagonal entry of the normal matrix. The least one makes steps of redundant robots
the shortest ones."""

TRIALS = 6
"""A step that is longer is damped ten times more, so often at most, before it is cut short."""

STEPS, FEW_STEPS, LAST_STEPS = 40, 12, 6
"""Newton's method needs four or five from near by. Those that need more are near a singularity or a limit."""


@dataclass(frozen=True)
class Task:
    """Rows that are to be brought to their goals.

    Attributes:
        machine: which moves.
        goals: of its rows.
        low, high: (joints, n) bounds of the joint positions.
        sliding: (joints,) which of the joint positions are lengths.
        weight: metres that count as much as a radian of orientation.
        sides: (elastic, n) loads that decide the sides of laws, or None.
    """

    machine: Machine
    goals: Goals
    low: Array
    high: Array
    sliding: NDArray[np.bool_]
    weight: float
    sides: Array | None = None


@dataclass(frozen=True)
class Found:
    """Joint positions q (joints, k), and what is left to the goal: distance (k,) [m] and angle (k,) [rad].

    Where the orientation does not matter the angle is 0.
    """

    q: Array
    distance: Array
    angle: Array

    @property
    def reached(self) -> NDArray[np.bool_]:
        """Which rows are at their goals."""
        return (self.distance <= REACHED) & (self.angle <= REACHED)

    def take(self, rows: NDArray[np.intp]) -> Found:
        """Some of the rows."""
        return Found(self.q[:, rows], self.distance[rows], self.angle[rows])

    def put(self, rows: NDArray[np.intp], other: Found) -> None:
        """Overwrite some of the rows by those of another."""
        self.q[:, rows], self.distance[rows], self.angle[rows] = other.q, other.distance, other.angle


@dataclass
class _State:
    """Rows on their way, everything that the next step needs; rows that have ended are taken out now and then."""

    rows: NDArray[np.intp]  # (k,) of the task
    place: NDArray[np.intp]  # (k,) in what is asked for
    goals: Goals
    low: Array
    high: Array
    sides: Array | None
    q: Array
    residual: Array  # (6, k) goal - pose, orientation in metres
    jacobian: Array  # (6, joints, k) likewise
    distance: Array
    angle: Array
    damping: Array
    slow: NDArray[np.intp]

    @property
    def cost(self) -> Array:
        return np.einsum("ck,ck->k", self.residual, self.residual)

    def within(self, limit: float) -> NDArray[np.bool_]:
        return (self.distance <= limit) & (self.angle <= limit)

    def take(self, kept: NDArray[np.intp]) -> _State:
        changed: dict[str, Any] = {}
        for field in fields(self):
            value = getattr(self, field.name)
            if value is not None:
                changed[field.name] = value.take(kept) if isinstance(value, Goals) else value[..., kept]
        return replace(self, **changed)


def solve(task: Task, rows: NDArray[np.intp], start: Array, steps: int = STEPS, patience: float = 1e-3) -> Found:
    """Bring rows (k,), which may repeat, to their goals from joint positions `start` (joints, k).

    Levenberg-Marquardt; joints at a bound that a step would leave are held there for this step.

    Args:
        task: what is to be reached.
        rows: of the task.
        start: where they are; taken to the nearest within bounds.
        steps: how many at most.
        patience: rows are given up that lower their sum of squares by less than this part of it, twice running.
    """
    state = _begin(task, rows, start)
    found = Found(state.q.copy(), state.distance.copy(), state.angle.copy())
    ended = state.within(EXACT)
    for _ in range(steps):
        if ended.mean() > SPARE if len(ended) else True:
            state, ended = state.take(np.flatnonzero(~ended)), ended[~ended]
        if not len(ended):
            break
        ended |= _advance(task, state, patience)
        found.q[:, state.place] = state.q
        found.distance[state.place], found.angle[state.place] = state.distance, state.angle
    return found


SPARE = 0.1
"""Rows that have ended are carried along until they are this part of all: taking them out costs as much as a step."""


def _begin(task: Task, rows: NDArray[np.intp], start: Array) -> _State:
    """Rows at their start."""
    low, high = task.low[:, rows], task.high[:, rows]
    state = _State(
        rows=rows,
        place=np.arange(len(rows)),
        goals=task.goals.take(rows),
        low=low,
        high=high,
        sides=None if task.sides is None else task.sides[:, rows],
        q=np.clip(start, low, high),
        residual=np.empty(0),
        jacobian=np.empty(0),
        distance=np.empty(0),
        angle=np.empty(0),
        damping=np.full(len(rows), LEAST_DAMPING),
        slow=np.zeros(len(rows), dtype=int),
    )
    state.residual, state.jacobian, state.distance, state.angle = _evaluate(task, state, state.q)
    return state


def _advance(task: Task, state: _State, patience: float) -> NDArray[np.bool_]:
    """One step of all rows, where it leads nearer; which rows have ended, (k,)."""
    q = np.clip(state.q + _step(state, state.low, state.high, state.damping), state.low, state.high)
    residual, jacobian, distance, angle = _evaluate(task, state, q)
    before, near = state.cost, state.within(REACHED)
    after = np.einsum("ck,ck->k", residual, residual)
    still = (q == state.q).all(axis=0)
    better = after < before
    state.slow = np.where(better & (after > (1.0 - patience) * before), state.slow + 1, 0)
    harder = np.maximum(state.damping * 10.0, FIRST_DAMPING)
    state.damping = np.where(better, np.maximum(0.1 * state.damping, LEAST_DAMPING), harder)
    back = np.flatnonzero(~better)
    if len(back):
        q[:, back], residual[:, back], jacobian[..., back] = (
            state.q[:, back],
            state.residual[:, back],
            state.jacobian[..., back],
        )
        distance[back], angle[back] = state.distance[back], state.angle[back]
    state.q, state.residual, state.jacobian, state.distance, state.angle = q, residual, jacobian, distance, angle
    given_up = still | (~better & near) | (state.slow >= 2) | (state.damping >= MOST_DAMPING)
    return state.within(EXACT) | given_up


def _evaluate(task: Task, state: _State, q: Array) -> tuple[Array, Array, Array, Array]:
    """Residual, Jacobian, distance and angle of rows at joint positions q (joints, k)."""
    driven = task.machine.at(q, state.rows, state.sides)
    goals = state.goals
    residual = np.zeros((6, len(state.rows)))
    np.subtract(goals.position, driven.position, out=residual[:3])
    if goals.oriented.any():
        residual[3:] = turns(goals, driven.rotation)
    distance, angle = (np.sqrt(np.einsum("ck,ck->k", part, part)) for part in (residual[:3], residual[3:]))
    scale = task.weight * goals.oriented
    residual[3:] *= scale
    driven.jacobian[3:] *= scale
    return residual, driven.jacobian, distance, angle


def turns(goals: Goals, rotation: Array) -> Array:
    """Rotation vectors (3, k) from poses to goals, zero where the orientation does not matter."""
    return rotation_vectors(np.einsum("ijn,kjn->ikn", goals.rotation, rotation)) * goals.oriented


def _step(state: _State, low: Array, high: Array, damping: Array) -> Array:
    """Steps (joints, k), each as long as LONGEST at most."""
    normal = np.einsum("cik,cjk->ijk", state.jacobian, state.jacobian)
    gradient = np.einsum("cik,ck->ik", state.jacobian, state.residual)
    held = ((state.q <= low) & (gradient < 0.0)) | ((state.q >= high) & (gradient > 0.0))
    diagonal = np.einsum("iik->ik", normal)
    largest = diagonal.max(axis=0)
    largest[largest == 0.0] = 1.0
    if held.any():
        normal *= ~(held[:, None] | held[None])
        gradient *= ~held
        diagonal += held * largest
    step, extra = _damped(normal, gradient, damping * largest), damping
    longer = np.flatnonzero(np.abs(step).max(axis=0) > LONGEST)
    for _ in range(TRIALS):
        if not len(longer):
            return step
        extra = np.maximum(10.0 * extra, FIRST_DAMPING)
        step[:, longer] = _damped(normal[..., longer], gradient[:, longer], (extra * largest)[longer])
        longer = longer[np.abs(step[:, longer]).max(axis=0) > LONGEST]
    return step * np.minimum(1.0, LONGEST / np.maximum(np.abs(step).max(axis=0), 1e-300))


def _damped(normal: Array, gradient: Array, damping: Array) -> Array:
    """Solutions (joints, k) of (normal + damping) x = gradient, by elimination on all rows at once.

    NumPy's solver of stacks calls LAPACK for each row, which takes ten times as long. The matrices are positive
    definite, so that no pivots need be searched.
    """
    matrix, x = normal.copy(), gradient.copy()
    size = len(x)
    diagonal = np.einsum("iik->ik", matrix)
    diagonal += damping
    for i in range(size - 1):
        factors = matrix[i, i + 1 :] / matrix[i, i]
        matrix[i + 1 :, i + 1 :] -= factors[:, None] * matrix[i, i + 1 :]
        x[i + 1 :] -= factors * x[i]
    for i in range(size - 1, -1, -1):
        if i + 1 < size:
            x[i] -= np.einsum("jk,jk->k", matrix[i, i + 1 :], x[i + 1 :])
        x[i] /= matrix[i, i]
    return x


def position_first(task: Task, rows: NDArray[np.intp], start: Array) -> Found:
    """As near as possible in position, and then in orientation; from joint positions `start` (joints, k).

    A weak weight on the orientation, and a last step on the position alone.
    """
    weak = solve(replace(task, weight=WEAK * task.weight), rows, start, FEW_STEPS, patience=1e-6)
    goals = task.goals
    alone = replace(task, goals=replace(goals, oriented=np.zeros_like(goals.oriented)))
    found = solve(alone, rows, weak.q, LAST_STEPS)
    far = np.flatnonzero(found.distance > REACHED)
    if len(far):  # out of reach: it takes longer to be as near as possible
        found.put(far, solve(alone, rows[far], found.q[:, far], patience=1e-9))
    return Found(found.q, *left(task, rows, found.q))


def left(task: Task, rows: NDArray[np.intp], q: Array) -> tuple[Array, Array]:
    """Distance [m] and angle [rad] from the poses at q (joints, k) to the goals of rows (k,)."""
    driven = task.machine.at(q, rows, None if task.sides is None else task.sides[:, rows], derivatives=False)
    goals = task.goals.take(rows)
    distance = np.linalg.norm(goals.position - driven.position, axis=0)
    angle = np.linalg.norm(turns(goals, driven.rotation), axis=0) if goals.oriented.any() else np.zeros(len(rows))
    return distance, angle


WEAK = 1e-3
"""How much less orientations count where they cannot be reached."""
