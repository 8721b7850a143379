"""The identified parameters as a table: values, standard deviations, verdicts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from elastocal.chain import Array
from elastocal.elasticity import CURVES, LAWS, STEP
from elastocal.identification.gauge import Gauge
from elastocal.identification.result import IdentifiedElement, IdentifiedParameter
from elastocal.identification.transition import TransitionData
from elastocal.parameters import FRAME_GROUPS, Group, Parameter, parameters_of
from elastocal.robot import Compliance, Robot

SIGNIFICANT_STEP = 3.5
"""The two compliances of a step whose torque was searched differ by so many standard deviations of their difference:
the best of fifty torques finds a difference of three in one linear robot of twenty."""

SIGNIFICANT = 2.0
"""A compliance smaller than this many of its standard deviations may as well be zero."""


@dataclass(frozen=True)
class Estimates:
    """What a fit says of parameters.

    Attributes:
        names: of the identified ones.
        displacements: of those that were stepped along, by name.
        covariance: (names, names).
        unseen: reasons for those of them that the data at hand do not tell.
        held: compliances held at zero, which would come out negative.
        transitions: the data on both sides of transition torques, by element.
    """

    names: tuple[str, ...]
    displacements: Mapping[str, float]
    covariance: Array
    unseen: Mapping[str, str]
    held: tuple[str, ...]
    transitions: Mapping[str, TransitionData]


def parameter_table(
    nominal: Robot, identified: Robot, gauge: Gauge, found: Estimates
) -> tuple[IdentifiedParameter, ...]:
    """Every parameter of a robot.

    Args:
        nominal: as the user gave it, with the laws asked for.
        identified: after the fit.
        gauge: which parameters were not identified and why.
        found: what the fit says.
    """
    after = parameters_of(identified)
    deviation = standard_deviations(identified, found.names, found.covariance)
    rows = []
    for name, parameter in parameters_of(nominal).items():
        if parameter.group == Group.TRANSITION:
            rows.append(_transition_row(parameter, identified, deviation, found))
            continue
        if parameter.group in FRAME_GROUPS:
            value = after[name].nominal or 0.0
        else:
            value = (parameter.nominal or 0.0) + found.displacements.get(name, 0.0)
        std, verdict, reason = None, "fixed", ""
        if name in found.unseen:
            verdict, reason = "unobservable", found.unseen[name]
        elif name in found.held:
            value, verdict, reason = 0.0, "insignificant", "it is held at zero: it would come out negative"
        elif name in deviation:
            std, verdict = deviation[name], "identified"
            if parameter.group == Group.COMPLIANCE and abs(value) < SIGNIFICANT * std:
                verdict, reason = "insignificant", "it is zero within its uncertainty"
        elif name in gauge.dropped:
            verdict, reason = gauge.dropped[name].verdict, gauge.dropped[name].reason
        rows.append(IdentifiedParameter(name, parameter.unit, parameter.nominal, value, std, verdict, reason))
    return tuple(rows)


def _transition_row(
    parameter: Parameter, identified: Robot, deviation: Mapping[str, float], found: Estimates
) -> IdentifiedParameter:
    """A transition torque: of a step as the misfit around it tells, of a hinge with a fitted parameter's deviation."""
    element = parameter.name.rpartition(".")[0]
    compliance, data = identified.elastic[element], found.transitions.get(element)
    std, verdict, reason = None, "fixed", ""
    if data is not None and data.searched:
        std, verdict = deviation.get(parameter.name, data.spread), "identified"
        if not _sides_differ(element, compliance, found):
            verdict, reason = "insignificant", "the compliances on its two sides are the same within their uncertainty"
    torque = compliance.transition_torque or 0.0
    return IdentifiedParameter(parameter.name, parameter.unit, parameter.nominal, torque, std, verdict, reason)


def _sides_differ(element: str, compliance: Compliance, found: Estimates) -> bool:
    """Whether a law's two coefficients differ by more than the uncertainty of their difference."""
    names = [f"{element}.{key}" for key in LAWS[compliance.law].coefficients]
    if not all(name in found.names for name in names):
        return True
    low, high = (found.names.index(name) for name in names)
    c = found.covariance
    change = compliance.coefficients[1] - compliance.coefficients[0]
    least = SIGNIFICANT_STEP if compliance.law == STEP.name else SIGNIFICANT
    return bool(abs(change) >= least * np.sqrt(c[low, low] + c[high, high] - 2.0 * c[low, high]))


def element_table(
    robot: Robot, parameters: tuple[IdentifiedParameter, ...], transitions: Mapping[str, TransitionData]
) -> tuple[IdentifiedElement, ...]:
    """Every elastic element of an identified robot; its verdict is the best of its coefficients'."""
    ranks = ("identified", "insignificant", "dependent", "unobservable", "fixed")
    by_name = {parameter.name: parameter for parameter in parameters}
    rows = []
    for element, compliance in robot.elastic.items():
        mine = [
            by_name[name]
            for name in (f"{element}.{key}" for key in CURVES[compliance.law].coefficients)
            if name in by_name
        ]
        torque = by_name.get(f"{element}.transition_torque")
        rows.append(
            IdentifiedElement(
                element=element,
                law=compliance.law,
                transition_torque=compliance.transition_torque,
                coefficients=compliance.coefficients,
                std=tuple(p.std for p in mine) or (None,) * len(compliance.coefficients),
                verdict=min((p.verdict for p in mine), key=ranks.index, default="fixed"),
                transition_std=torque.std if torque else None,
                transition=transitions.get(element),
            )
        )
    return tuple(rows)


def standard_deviations(robot: Robot, names: tuple[str, ...], covariance: Array) -> dict[str, float]:
    """Standard deviations by name, those of a frame's rotations turned into roll, pitch and yaw."""
    found = dict(zip(names, np.sqrt(np.clip(np.diag(covariance), 0.0, None)).tolist(), strict=True))
    for prefix, frame in robot.frames.items():
        turns = [f"{prefix}.{key}" for key in ("rx", "ry", "rz")]
        kept = [i for i, name in enumerate(turns) if name in names]
        index = [names.index(turns[i]) for i in kept]
        if index and frame.rpy is not None:
            rates = _rpy_rates(*frame.rpy[:2])[:, kept]
            spread = np.sqrt(np.diag(rates @ covariance[np.ix_(index, index)] @ rates.T))
            found |= {turns[i]: float(spread[i]) for i in kept}
    return found


def _rpy_rates(roll: float, pitch: float) -> Array:
    """Rates of roll, pitch and yaw (rows) with turns about the frame's own axes (columns); singular at pitch 90 deg."""
    cosine = np.cos(pitch) if abs(np.cos(pitch)) > 1e-12 else 1e-12
    sin_roll, cos_roll = np.sin(roll), np.cos(roll)
    return np.array(
        [
            [1.0, sin_roll * np.sin(pitch) / cosine, cos_roll * np.sin(pitch) / cosine],
            [0.0, cos_roll, -sin_roll],
            [0.0, sin_roll / cosine, cos_roll / cosine],
        ]
    )
