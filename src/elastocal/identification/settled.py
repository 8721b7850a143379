"""What is settled of all rows by the fit of a sample: which are outliers, and on which side of steps they lie."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.identification.attempt import Attempt
from elastocal.identification.judged import Judged, Rule
from elastocal.identification.partitioned import Marked, Marks, over_parts, packed, unpacked
from elastocal.identification.step_torques import Near, StepTorque, best_torque
from elastocal.identification.threads import one_thread
from elastocal.partitions import Partitions
from elastocal.prediction import Model
from elastocal.robot import Robot

NEAR = 1000
"""So many of the sample's loads to either side of a step's torque reach as far as all rows may move it."""

Window = tuple[float, float, float]
"""A transition torque, and the loads between which rows are near to it."""


def settle_rows(
    fitted: Attempt, data: Partitions, robust: bool, executor: Executor | None
) -> tuple[tuple[Marks, ...], dict[str, StepTorque]]:
    """The marks of all parts, and the torques of steps by element, unless they are given.

    Args:
        fitted: the fit of the sample.
        data: all rows.
        robust: whether outliers are left out.
        executor: where parts are worked through.

    Raises:
        EquilibriumError: a row does not settle under its load.
    """
    trial, none = fitted.trial, (Marks(),) * len(data.parts)
    if not robust and not trial.model.sides:
        return none, {}
    searched = fitted.search is not None and fitted.search.method != "given"
    rule = Rule.of(trial.solution, len(trial.torques) if searched else 0, len(data), data.several_stations)
    windows = {element: _window(trial.loads[element], trial.torques[element]) for element in trial.model.sides}
    robot = fitted.model.displaced(fitted.solution.displacements)
    look = partial(_looked_at, robot, rule, robust, windows if searched else {}, windows)
    found = list(over_parts(look, data, none, executor))
    marks, near = [each[0] for each in found], [each[1] for each in found]
    torques = {
        element: best_torque(window[0], [each[element] for each in near if element in each], rule.variance)
        for element, window in windows.items()
        if searched
    }
    rows = [part.rows for part in data.parts]
    return tuple(map(partial(_with_torques, torques), marks, near, rows)), torques


def _window(loads: Array, torque: float) -> Window:
    ordered = np.sort(np.abs(loads))
    at = int(np.searchsorted(ordered, torque))
    return torque, float(ordered[max(at - NEAR, 0)]), float(ordered[min(at + NEAR, len(ordered) - 1)])


@one_thread
def _looked_at(
    robot: Robot,
    rule: Rule,
    robust: bool,
    searched: Mapping[str, Window],
    windows: Mapping[str, Window],
    marked: Marked,
) -> tuple[Marks, dict[str, Near]]:
    """Marks of a part with the sample's torques, and its rows near the torques that are searched."""
    data = marked.part.read()
    good, high, near = np.ones(len(data), dtype=bool), {}, {}
    if robust:
        judged = rule.judge(robot, data)
        good = ~rule.accused(judged, rule.scores(judged, np.zeros(len(data), dtype=bool)))
    model = Model(robot, (), data)
    loads = model.undeflected_loads(np.zeros(0)) if windows else {}
    for element, (torque, low, up) in windows.items():
        sizes = np.abs(loads[element])
        high[element] = packed(sizes >= torque)
        rows = np.flatnonzero((sizes >= low) & (sizes <= up) & good)
        if element in searched and len(rows):
            near[element] = Near(rows, sizes[rows], *_on_both_sides(model, element, rows, rule))
    return Marks(packed(good) if robust else None, high), near


def _on_both_sides(model: Model, element: str, rows: NDArray[np.intp], rule: Rule) -> list[Array]:
    """(rows,) sums of squares with the rows below the element's torque, and above it."""
    some = replace(model, data=model.data.take(rows))
    forced = [replace(some, sides={element: np.full(len(rows), load)}) for load in (0.0, np.inf)]
    return [Judged.of(each, rule.variances, rule.several).gain for each in forced]


def _with_torques(torques: Mapping[str, StepTorque], marks: Marks, near: Mapping[str, Near], rows: int) -> Marks:
    """A part's marks with the torques that were found."""
    high = dict(marks.high)
    for element, found in torques.items():
        if element in near:
            bits = unpacked(high[element], rows)
            bits[near[element].rows] = near[element].loads >= found.torque
            high[element] = packed(bits)
    return replace(marks, high=high)
