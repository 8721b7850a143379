"""The identified parameters as a table: values, standard deviations, verdicts."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from elastocal.chain import Array
from elastocal.elasticity import LAWS
from elastocal.identification.gauge import Gauge
from elastocal.identification.result import IdentifiedElement, IdentifiedParameter
from elastocal.parameters import FRAME_GROUPS, Group, parameters_of
from elastocal.robot import Robot

SIGNIFICANT = 2.0
"""A compliance smaller than this many of its standard deviations may as well be zero."""


def parameter_table(
    nominal: Robot, identified: Robot, gauge: Gauge, displacements: Array, covariance: Array, unseen: Mapping[str, str]
) -> tuple[IdentifiedParameter, ...]:
    """Every parameter of a robot.

    Args:
        nominal: as the user gave it, with the laws asked for.
        identified: after the fit.
        gauge: what was identified, and what was not and why.
        displacements: (kept,) of the kept parameters.
        covariance: (kept, kept) of them.
        unseen: reasons for kept parameters that the data at hand do not tell.
    """
    after = parameters_of(identified)
    moved = dict(zip(gauge.kept, displacements.tolist(), strict=True))
    deviation = standard_deviations(identified, gauge.kept, covariance)
    rows = []
    for name, parameter in parameters_of(nominal).items():
        if parameter.group in FRAME_GROUPS:
            value = after[name].nominal or 0.0
        else:
            value = (parameter.nominal or 0.0) + moved.get(name, 0.0)
        std, verdict, reason = None, "fixed", ""
        if name in unseen:
            verdict, reason = "unobservable", unseen[name]
        elif name in deviation:
            std, verdict = deviation[name], "identified"
            if parameter.group == Group.COMPLIANCE and abs(value) < SIGNIFICANT * std:
                verdict, reason = "insignificant", "it is zero within its uncertainty"
        elif name in gauge.dropped:
            verdict, reason = gauge.dropped[name].verdict, gauge.dropped[name].reason
        rows.append(IdentifiedParameter(name, parameter.unit, parameter.nominal, value, std, verdict, reason))
    return tuple(rows)


def element_table(robot: Robot, parameters: tuple[IdentifiedParameter, ...]) -> tuple[IdentifiedElement, ...]:
    """Every elastic element of an identified robot; its verdict is the best of its coefficients'."""
    ranks = ("identified", "insignificant", "dependent", "unobservable", "fixed")
    by_name = {parameter.name: parameter for parameter in parameters}
    rows = []
    for element, compliance in robot.elastic.items():
        mine = [by_name[f"{element}.{name}"] for name in LAWS[compliance.law].coefficients]
        verdict = min((parameter.verdict for parameter in mine), key=ranks.index)
        coefficients, std = tuple(p.identified for p in mine), tuple(p.std for p in mine)
        rows.append(
            IdentifiedElement(element, compliance.law, compliance.transition_torque, coefficients, std, verdict)
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
