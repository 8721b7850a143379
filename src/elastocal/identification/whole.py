"""The fit of all rows of partitions, from that of a sample."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from elastocal.chain import Array
from elastocal.errors import EquilibriumError, InputError
from elastocal.identification.attempt import Attempt, Whole
from elastocal.identification.partitioned import Partitioned
from elastocal.identification.settled import settle_rows
from elastocal.identification.solver import Normal, descend, fit
from elastocal.identification.sums import normal_sums, reweighed
from elastocal.identification.transition import HINGE_STEPS, TransitionData, Trial, free_torques
from elastocal.measurements import KINDS, Measurements
from elastocal.parameters import FRAME_GROUPS, parameters_of
from elastocal.partitions import Partitions
from elastocal.robot import Robot

Data = Measurements | Partitions


def few(data: Data) -> Measurements:
    """The data, or the sample of those too many to hold at once."""
    return data.sample if isinstance(data, Partitions) else data


def require_held(data: Data, holdout: float | None, bootstrap: int) -> None:
    """Check that nothing is asked for that takes all rows at once.

    Raises:
        InputError: something is.
    """
    if not isinstance(data, Partitions):
        return
    faults, rows = [], f"{len(data)} rows are not held in memory at once"
    if holdout is not None:
        faults.append(
            f"holdout: {rows}, so that none can be chosen among them: keep some in files of their own, and give these "
            "as held-out rows (--held-out)"
        )
    if bootstrap:
        faults.append(
            f"bootstrap: {rows}, and of so many the linear covariance is as good: leave it out (--bootstrap 0)"
        )
    if faults:
        raise InputError(*faults)


def on_all_rows(
    sampled: Attempt,
    data: Partitions,
    robust: bool,
    on_step: Callable[[int, float], None] | None = None,
    executor: Executor | None = None,
) -> Attempt:
    """Fit all rows, from the fit of a sample on.

    Args:
        sampled: the fit of the sample, without priors.
        data: all rows.
        robust: whether outliers are left out.
        on_step: called with the number of steps and the sum of squares after each one.
        executor: where parts are worked through; None: here.

    Raises:
        EquilibriumError: a row does not settle under its load.
    """
    trial = sampled.trial
    marks, steps = settle_rows(sampled, data, robust, executor)
    torques = {**trial.torques, **{element: found.torque for element, found in steps.items()}}
    model = Partitioned(_with_torques(trial.model.robot, torques), trial.model.names, data, marks, executor)
    start = trial.solution.displacements
    hinges = free_torques(trial, sampled.search)
    if hinges:
        model, start = _with_hinges(model, start, trial, hinges)
        torques |= {name.rpartition(".")[0]: _torque(model.robot, name) for name in hinges}
    solution = fit(model, start, on_step)
    fitted = replace(
        trial,
        model=replace(trial.model, robot=model.robot),
        solution=solution,
        torques=torques,
        gaps={**trial.gaps, **{element: found.gap for element, found in steps.items()}},
    )
    return replace(sampled, trial=fitted, whole=Whole(model, _nominal(model), replace(trial, torques=torques), steps))


def _with_torques(robot: Robot, torques: Mapping[str, float]) -> Robot:
    moved = {e: replace(robot.elastic[e], transition_torque=torque) for e, torque in torques.items()}
    return replace(robot, elastic={**robot.elastic, **moved})


def _torque(robot: Robot, name: str) -> float:
    """The transition torque that a parameter is."""
    return robot.elastic[name.rpartition(".")[0]].transition_torque or 0.0


def _with_hinges(model: Partitioned, start: Array, trial: Trial, hinges: tuple[str, ...]) -> tuple[Partitioned, Array]:
    """The model and displacements after a few steps with the torques of hinges among the parameters; see `polished`."""
    freed, count = replace(model, names=(*model.names, *hinges)), len(start)
    variances = trial.solution.variances
    begin = np.append(start, np.zeros(len(hinges)))
    try:
        found, *_ = descend(freed, begin, normal_sums(freed, begin, variances), variances, most=HINGE_STEPS)
    except EquilibriumError:
        return model, start
    moved = {n.rpartition(".")[0]: _torque(model.robot, n) + d for n, d in zip(hinges, found[count:], strict=True)}
    if min(moved.values()) <= 0.0:
        return model, start
    return replace(model, robot=_with_torques(model.robot, {e: float(t) for e, t in moved.items()})), found[:count]


def _nominal(model: Partitioned) -> Robot:
    """The robot before, its open frames fitted to all rows: from where the sample has them that is one step."""
    parameters = parameters_of(model.robot)
    frames = tuple(name for name in model.names if parameters[name].group in FRAME_GROUPS)
    marks = tuple(replace(each, high={}) for each in model.marks)
    nominal, here = replace(model, names=frames, marks=marks), np.zeros(len(frames))
    if not frames:
        return model.robot
    sums = normal_sums(nominal, here, dict.fromkeys(KINDS, 1.0))
    weighed = {channel: found.misfit / found.count for channel, found in sums.items()}
    sums = reweighed(nominal, here, sums, dict.fromkeys(sums, 1.0), weighed)
    return nominal.displaced(Normal.of(sums).step(0.0))


def transitions_on_all_rows(
    found: Mapping[str, TransitionData], whole: Whole, names: Sequence[str], covariance: Array, reach: float
) -> dict[str, TransitionData]:
    """The data on both sides of transition torques, with what all rows say where the sample's say less.

    Args:
        found: as the sample tells it, by element.
        whole: the fit of all rows.
        names: of the identified parameters.
        covariance: (names, names).
        reach: so many standard deviations an interval reaches to both sides.
    """
    told = dict(found)
    for element, step in whole.steps.items():
        told[element] = replace(told[element], gap=step.gap, spread=step.spread, interval=step.interval)
    for element, data in found.items():
        name = f"{element}.transition_torque"
        if name in names:
            torque, spread = _torque(whole.model.robot, name), float(np.sqrt(covariance.diagonal()[names.index(name)]))
            told[element] = replace(data, interval=(max(torque - reach * spread, 0.0), torque + reach * spread))
    return told
