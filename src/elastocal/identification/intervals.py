"""Confidence intervals of parameters, and groups of parameters that the data tell together only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from elastocal.chain import Array
from elastocal.identification.bootstrap import Bootstrap
from elastocal.identification.result import IdentifiedParameter
from elastocal.identification.transition import TransitionData

LEVEL = 0.95
"""Of all intervals so many shall cover the truth."""

TOGETHER = 0.95
"""Parameters whose errors are correlated by more than this are told together only."""


def student(freedom: float, level: float = LEVEL) -> float:
    """Student's two-sided quantile: so many standard deviations an interval reaches to both sides."""
    from scipy.special import stdtrit  # imported late: it takes longer than a calibration

    return float(stdtrit(max(freedom, 1.0), 0.5 * (1.0 + level)))


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
