"""Confidence intervals of parameters, and groups of parameters that the data tell together only."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from statistics import NormalDist

import numpy as np

from elastocal.chain import Array
from elastocal.identification.bootstrap import Bootstrap
from elastocal.identification.result import IdentifiedParameter
from elastocal.identification.transition import TransitionData

LEVEL = 0.95
"""Of all intervals so many shall cover the truth."""

TOGETHER = 0.95
"""Parameters whose errors are correlated by more than this are told together only."""

_EXPANSION = ((1, 1, 4.0), (5, 16, 3, 96.0), (3, 19, 17, -15, 384.0), (79, 776, 1482, -1920, -945, 92160.0))
"""Coefficients of z^3, z, …, then their divisor, by the power of 1 / freedom."""


def student(freedom: float, level: float = LEVEL) -> float:
    """Student's two-sided quantile: so many standard deviations an interval reaches to both sides.

    By the expansion about the normal quantile (Abramowitz and Stegun 1964, 26.7.5), good to 0.3 % from three degrees of
    freedom on; exact for one and two. No special functions, which take longer to import than a calibration takes.
    """
    p = 0.5 * (1.0 + level)
    if freedom < 1.5:
        return math.tan(math.pi * (p - 0.5))
    if freedom < 2.5:
        return (2.0 * p - 1.0) * math.sqrt(2.0 / (4.0 * p * (1.0 - p)))
    z = NormalDist().inv_cdf(p)
    quantile = z
    for power, (*coefficients, divisor) in enumerate(_EXPANSION, start=1):
        highest = 2 * len(coefficients) - 1
        terms = (c * z ** (highest - 2 * i) for i, c in enumerate(coefficients))
        quantile += sum(terms) / (divisor * freedom**power)
    return quantile


def with_intervals(
    parameters: Sequence[IdentifiedParameter],
    freedom: float,
    transitions: Mapping[str, TransitionData],
    resampled: Bootstrap | None = None,
) -> tuple[IdentifiedParameter, ...]:
    """The parameters with their intervals of level LEVEL, None where there is no standard deviation.

    Args:
        parameters: with their standard deviations.
        freedom: degrees of freedom that these rest on.
        transitions: the data on both sides of transition torques by element, with their intervals.
        resampled: where intervals come from instead; of frames' rotations, which are shown as other angles than they
            are identified by, only the standard deviations do.
    """
    reach, found = student(freedom), []
    for p in parameters:
        interval = None
        if p.std is not None:
            interval = p.identified - reach * p.std, p.identified + reach * p.std
            if p.name.endswith(".transition_torque"):
                interval = transitions[p.name.rpartition(".")[0]].interval
            elif resampled is not None and p.name in resampled.names and not p.name.endswith((".rx", ".ry", ".rz")):
                low, high = resampled.interval(p.name)
                interval = p.identified + low, p.identified + high
        found.append(replace(p, interval=interval))
    return tuple(found)


def correlated_groups(names: Sequence[str], covariance: Array) -> tuple[tuple[str, ...], ...]:
    """Groups of parameters that hang together by correlations above TOGETHER, one after the other.

    Args:
        names: of the parameters.
        covariance: (names, names).
    """
    deviation = np.sqrt(np.clip(np.diag(covariance), 0.0, None))
    scale = np.where(deviation > 0.0, deviation, np.inf)
    linked = np.abs(covariance / np.outer(scale, scale)) > TOGETHER
    left, groups = set(range(len(names))), []
    while left:
        group, grown = set[int](), {min(left)}
        while grown:
            group |= grown
            grown = set(np.flatnonzero(linked[sorted(group)].any(axis=0)).tolist()) - group
        left -= group
        if len(group) > 1:
            groups.append(tuple(names[i] for i in sorted(group)))
    return tuple(groups)
