"""The gauge: which parameters a kind of measurement can tell apart, decided from the robot alone.

Decided once, before the first step, at generic poses and on the robot whose deflections are held: so that names,
standard deviations and comparisons mean the same from run to run, whatever the data happen to be. What the data at hand
are too weak for is reported, never re-gauged.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from elastocal.chain import Array, forward, place
from elastocal.identification.generic import generic_measurements, generic_robot, reach, with_middle_torques
from elastocal.identification.sums import normal_sums
from elastocal.measurements import Measurements
from elastocal.parameters import Group, Parameter, parameters_of
from elastocal.prediction import Model, Setup
from elastocal.robot import Robot
from elastocal.statics import load

DEPENDENT = 1e-3
"""A parameter of whose effect less than this remains, once the others have done what they can, says nothing of its own:
to see it, the others would have to be known a thousand times better than it. It covers tables rounded to 1e-4 rad and
axes that are parallel but for their errors."""

NAMED = 0.02
"""Parameters that another one depends on are named if their part in it is at least this, relative to the largest."""

INVISIBLE = 1e-6
"""An effect smaller than this, relative to that of a like parameter, is rounding."""


@dataclass(frozen=True)
class Dropped:
    """A parameter that is not identified: "unobservable" or "dependent", why, and on which others it depends."""

    name: str
    verdict: str
    reason: str
    partners: tuple[str, ...] = ()


@dataclass(frozen=True)
class Gauge:
    """What is identified and what is not.

    Attributes:
        kept: names, in chain order with the compliances last.
        effects: by kept name, how far a unit of the parameter moves the target at generic poses, rms [m per unit].
        dropped: the others, and why.
    """

    kept: tuple[str, ...]
    effects: Mapping[str, float]
    dropped: Mapping[str, Dropped]


def choose_gauge(robot: Robot, data: Measurements, names: Sequence[str]) -> Gauge:
    """Choose which of the named parameters to keep.

    Of parameters that say the same the first by group is kept: frames and joint offsets before lengths, these before
    link twists, compliances last; within a group the first along the chain.

    Args:
        robot: nominal; compliances to be identified have their laws in it.
        data: only the kinds of their observations, their stations, targets and payloads count.
        names: of the parameters asked for.
    """
    generic = generic_robot(robot)
    model = with_middle_torques(Model(generic, tuple(names), generic_measurements(generic, data, 2 * len(names))))
    gram = _effects(model, reach(robot))
    norms = np.sqrt(np.diag(gram))
    parameters = parameters_of(robot)
    likely = np.array([_likely_effect(generic, parameters[name], len(model.data)) for name in names])
    powers = np.array([parameters[name].power for name in names])
    visible = norms > INVISIBLE**powers * likely
    scale = np.where(visible, norms, 1.0)
    order = sorted(np.flatnonzero(visible).tolist(), key=lambda i: (parameters[names[i]].group, i))
    kept, combined = _eliminate(gram / np.outer(scale, scale), order)
    dropped = {names[i]: _unobservable(model, parameters[names[i]]) for i in np.flatnonzero(~visible).tolist()}
    for i, others in combined.items():
        dropped[names[i]] = _dependent(names[i], tuple(names[k] for k in others))
    effects = {names[i]: float(norms[i] / np.sqrt(len(model.data))) for i in sorted(kept)}
    return Gauge(tuple(effects), effects, dropped)


def _effects(model: Model, size: float) -> Array:
    """Gram matrix (names, names) of the names' effects at generic poses; a radian counts as the reach in metres."""
    ones = {"position": 1.0, "orientation": 1.0 / size**2, "distance": 1.0}
    sums = normal_sums(model, np.zeros(len(model.names)), ones, held=True)
    return np.sum([found.gram for found in sums.values()], axis=0)[:-1, :-1]


def _likely_effect(robot: Robot, parameter: Parameter, poses: int) -> float:
    """The norm of a parameter's effect, had it an ordinary lever and, if a compliance, an ordinary load."""
    size = reach(robot)
    effect = np.sqrt(poses) * (size if parameter.unit.startswith("rad") else 1.0)
    if parameter.group == Group.COMPLIANCE:
        mass = robot.tool_load.mass + sum(row.mass for row in robot.rows)
        weight = mass * float(np.linalg.norm(robot.gravity))
        effect *= (weight * (size if parameter.unit.startswith("rad") else 1.0)) ** parameter.power
    return effect


def _eliminate(gram: Array, order: list[int]) -> tuple[list[int], dict[int, list[int]]]:
    """Keep what adds something to what is kept already, in the given order; the gram matrix has a unit diagonal.

    Returns:
        The kept ones, and for each other one those kept ones that it is a combination of, strongest first.
    """
    swept = gram.copy()
    kept: list[int] = []
    combined = {}
    for i in order:
        if swept[i, i] > DEPENDENT**2:
            kept.append(i)
            _sweep(swept, i)
        else:
            weights = {k: abs(swept[k, i]) for k in kept}
            least = NAMED * max(weights.values(), default=0.0)
            combined[i] = sorted((k for k in kept if weights[k] > least), key=lambda k: -weights[k])
    return kept, combined


def _sweep(gram: Array, pivot: int) -> None:
    """The sweep operator (Goodnight, 1979): regress all rows on the pivot, in place."""
    row = gram[pivot].copy()
    diagonal = row[pivot]
    gram -= np.outer(row, row) / diagonal
    gram[pivot] = gram[:, pivot] = row / diagonal
    gram[pivot, pivot] = -1.0 / diagonal


def _dependent(name: str, partners: tuple[str, ...]) -> Dropped:
    listed = ", ".join(partners[:4]) + (f" and {len(partners) - 4} more" if len(partners) > 4 else "")
    verbs = ("does", "takes") if len(partners) == 1 else ("do", "take")
    reason = f"moves the target as {listed} {verbs[0]}, which {verbs[1]} up its error"
    return Dropped(name, "dependent", reason, partners)


def _unobservable(model: Model, parameter: Parameter) -> Dropped:
    return Dropped(parameter.name, "unobservable", _why_invisible(model, parameter))


def _why_invisible(model: Model, parameter: Parameter) -> str:
    element = parameter.name.rpartition(".")[0] if parameter.group == Group.COMPLIANCE else parameter.name
    setups = [setup for setup in model.setups if element in setup.assembly.mechanism.chain.index]
    if not setups:
        return "no measurement involves it"
    if parameter.group != Group.COMPLIANCE:
        return STILL
    turns = parameter.unit.startswith("rad")
    weight, along = np.max([_load_and_slant(model, setup, element) for setup in setups], axis=0)
    if weight > INVISIBLE * _likely_effect(model.robot, replace(parameter, power=1), 1) / reach(model.robot):
        return STILL
    if turns and along > 1.0 - INVISIBLE:
        return "its axis is vertical: gravity has no moment about it"
    if not turns and along < INVISIBLE:
        return "its axis is horizontal: gravity has no force along it"
    return "nothing loads it: what hangs beyond it has no mass, or is balanced about its axis, and there is no wrench"


STILL = "the measured point stays where it is: a target off this axis, or one with an orientation, would show it"


def _load_and_slant(model: Model, setup: Setup, element: str) -> tuple[float, float]:
    """Largest load on an element at the setup's poses, and the smallest |cosine| of its axis and gravity."""
    mechanism = setup.assembly.mechanism
    placement = place(mechanism.chain, mechanism.chain.values)
    motion = setup.assembly.motion(model.data.q[setup.rows].T)
    wrench = None if model.data.wrench is None else model.data.wrench[setup.rows].T
    statics = load(mechanism, placement, forward(placement, motion), wrench)
    row = mechanism.elastic.index(mechanism.chain.index[element])
    weight = float(np.linalg.norm(statics.gravity))
    slant = np.abs(statics.gravity @ statics.axes[:, row]).min() / weight if weight else 0.0
    return float(np.abs(statics.loads[row]).max()), float(slant)
