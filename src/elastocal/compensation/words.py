"""What rows and sums of a compensation say in words."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.compensation.inverse import JUMP
from elastocal.compensation.loaded import Corrected
from elastocal.compensation.outcome import Summary
from elastocal.compensation.solver import REACHED, Task

AT_LIMIT = 1e-9
"""A joint nearer to its limit than this [rad or m] is at it."""


def notes(task: Task, done: Corrected, distance: Array, angle: Array, leap: NDArray[np.bool_]) -> tuple[str, ...]:
    """A sentence for each row that is not reached, or whose joints jump; else "".

    Args:
        task: of the loaded robot.
        done: where it ended.
        distance: (n,) what is left [m].
        angle: (n,) [rad].
        leap: (n,) whether the joints jump from the row before although the targets are near one another.
    """
    found = np.full(len(distance), "", dtype=object)
    found[leap] = "joints jump from the row before: its configuration ends here"
    for row in np.flatnonzero((distance > REACHED) | (angle > REACHED)).tolist():
        rest = _left(float(distance[row]), float(angle[row]))
        found[row] = f"{_reason(task, done, row, float(distance[row]))}: {rest} left"
    return tuple(found.tolist())


def _left(distance: float, angle: float) -> str:
    if distance <= REACHED:
        return f"{_number(1e3 * angle)} mrad of the orientation"
    return f"{_number(1e3 * distance)} mm" + (f" and {_number(1e3 * angle)} mrad" if angle > REACHED else "")


def _number(value: float) -> str:
    return f"{value:.4f}" if value < 1.0 else f"{value:.2f}"


def _reason(task: Task, done: Corrected, row: int, distance: float) -> str:
    """Why a row is not at its target."""
    unsettled = np.flatnonzero(done.unsettled[:, row])
    if len(unsettled):
        names = [task.machine.springs()[task.machine.stepping[i]] for i in unsettled]
        return f"load passes the transition torque of {' and '.join(names)}"
    q = done.found.q[:, row]
    at = np.flatnonzero((q <= task.low[:, row] + AT_LIMIT) | (q >= task.high[:, row] - AT_LIMIT)) + 1
    if len(at) == 1:
        return f"joint {at[0]} at its limit"
    if len(at):
        return f"joints {', '.join(map(str, at[:-1]))} and {at[-1]} at their limits"
    if len(q) < 6 and distance <= REACHED:
        return f"only {len(q)} joint{'s' if len(q) > 1 else ''}"
    turning = np.flatnonzero(done.bounded[:, row]) + 1
    if len(turning):
        return f"singular, joint {turning[0]} would have to swing round"
    return "singular" if distance <= REACHED else "out of reach"


def jumps(near: NDArray[np.bool_], q: Array, previous: Array) -> NDArray[np.bool_]:
    """Rows (n,) where joints q (joints, n) jump from those of the row before, though the targets are near."""
    return near & (np.abs(q - previous).max(axis=0) > JUMP)


def verdict(summary: Summary) -> str:
    """One sentence on all targets."""
    n, reached = summary.targets, summary.reached
    if not n:
        return "No targets."
    head = f"{reached} of {n} targets reached" if reached < n else f"All {n} targets reached" if n > 1 else "Reached"
    before, after = summary.figures["error_before"], summary.figures["error_after"]
    if not reached:
        return f"{head}."
    return (
        f"{head}: predicted error {1e3 * before.mean:.3g} mm on average and {1e3 * before.max:.3g} mm at most with the "
        f"nominal joint positions, {_small(after.max)} with the corrected ones."
    )


def _small(length: float) -> str:
    return "less than 1 nm" if length < 1e-9 else f"at most {1e3 * length:.3g} mm"


def summary_text(summary: Summary) -> str:
    """The figures as a table, in millimetres, and the verdict."""
    head = f"{summary.robot}: {summary.reached} of {summary.targets} targets reached"
    lines = [head, f"{'':24}{'mean':>10}{'max':>10}"]
    for name, spread in summary.figures.items():
        if spread.n:
            unit = "mrad" if "angle" in name else "mm"
            label = f"{name.replace('_', ' ')} [{unit}]"
            lines.append(f"{label:24}{1e3 * spread.mean:10.4f}{1e3 * spread.max:10.4f}")
    return "\n".join([*lines, verdict(summary), *summary.warnings])
