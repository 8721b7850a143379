"""Which transition torques are asked for, and how."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from elastocal.elasticity import LAWS
from elastocal.errors import InputError, unknown_name
from elastocal.identification.gauge import Gauge
from elastocal.identification.transition.genetic import GeneticSearch
from elastocal.robot import Robot

METHODS = ("exact", "ga")

Transition = str | GeneticSearch | Sequence[float]
"""How transition torques are found: "exact", "ga", a genetic search of other size, or the torques [N m or N], in the
order in which their elements are asked for."""


def with_transition(elements: Sequence[str], robot: Robot) -> tuple[str, ...]:
    """Those of the elements whose laws have a transition torque."""
    return tuple(element for element in elements if LAWS[robot.elastic[element].law].transition)


def given_torques(transition: Transition, elements: Sequence[str]) -> dict[str, float]:
    """The torques that a user gives, by element; none if they are to be searched.

    Args:
        transition: what the user asks for.
        elements: those with a transition torque, in the order asked for.

    Raises:
        InputError: no such method, or torques that are not positive or not as many as elements.
    """
    if isinstance(transition, str):
        if transition not in METHODS:
            raise InputError(f"transition: {unknown_name('method', transition, [*METHODS, 'or torques, as 222,80'])}")
        return {}
    if isinstance(transition, GeneticSearch):
        return {}
    torques = [float(torque) for torque in transition]
    listed = ", ".join(elements) or "none: ask for a step or hinge law, as --elastic 2:step"
    if len(torques) != len(elements):
        raise InputError(
            f"transition: expected one torque for each element with a transition ({listed}), found {len(torques)}"
        )
    faults = [
        f"transition: expected a positive torque, found {t:g}" for t in torques if not (math.isfinite(t) and t > 0.0)
    ]
    if faults:
        raise InputError(*faults)
    return dict(zip(elements, torques, strict=True))


def searched_laws(elements: Sequence[str], robot: Robot, gauge: Gauge) -> dict[str, str]:
    """Laws by element whose transition torque can be found: those that both coefficients are kept of.

    Raises:
        InputError: of an element one coefficient is to be found and the other to be kept.
    """
    laws, faults = {}, []
    for element in elements:
        kept = [f"{element}.{key}" in gauge.kept for key in LAWS[robot.elastic[element].law].coefficients]
        if all(kept):
            laws[element] = robot.elastic[element].law
        elif any(kept):
            faults.append(f"{element}: identify both coefficients of its law, or fix both (--fix '{element}.*')")
    if faults:
        raise InputError(*faults)
    return laws


def with_known_torques(robot: Robot, given: Mapping[str, float]) -> Robot:
    """The robot with a transition torque on every element that has one: given, its own, or any if its law is idle."""
    elastic = dict(robot.elastic)
    for element, compliance in robot.elastic.items():
        law = LAWS.get(compliance.law)
        if law is not None and law.transition:
            torque = given.get(element, compliance.transition_torque or IDLE)
            elastic[element] = replace(compliance, transition_torque=torque)
    return replace(robot, elastic=elastic)


IDLE = 1.0
"""The transition torque of a law whose coefficients are not identified and zero: it does not matter."""
