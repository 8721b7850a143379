"""Robots of one kind side by side: which of them differs from its siblings, and in what."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from elastocal.chain import Array
from elastocal.identification import IdentifiedParameter, SavedResult
from elastocal.parameters import FRAME_GROUPS, parameters_of

LEVEL = 0.05
"""Of so many fleets of robots that are alike, at most, one is said to differ."""

FEWEST = 5
"""Siblings, of which fewer tell nothing of one another."""

CONSISTENT = 1.4826
"""Median absolute deviation of normal values, times this, is their standard deviation."""

DRAWN = 4_000_000
"""Normal numbers that a threshold is drawn from."""


@dataclass(frozen=True)
class Deviation:
    """A parameter of a robot that its siblings do not have so; SI.

    Attributes:
        score: (value − median) / √(scatter² + std²).
    """

    serial: str
    parameter: str
    unit: str
    value: float
    median: float
    score: float


@dataclass(frozen=True)
class Siblings:
    """Robots with the same nominal robot and the same request, each at its latest date.

    Attributes:
        robot: name of the nominal robot.
        serials: of the robots.
        parameters: their own identified ones, not those of frames.
        units: of the parameters.
        values: (robots, parameters) identified.
        stds: (robots, parameters) standard deviations.
        median: (parameters,) over the robots.
        scatter: (parameters,) 1.4826 times the median absolute deviation from it.
        scores: (robots, parameters), see Deviation.
        threshold: of a score's size, above which a robot is said to differ; infinite with too few robots.
        deviations: these, the largest first.
    """

    robot: str
    serials: tuple[str, ...]
    parameters: tuple[str, ...]
    units: tuple[str, ...]
    values: Array
    stds: Array
    median: Array
    scatter: Array
    scores: Array
    threshold: float
    deviations: tuple[Deviation, ...]


def siblings_of(serials: Sequence[str], results: Sequence[SavedResult]) -> Siblings:
    """Compare robots that have the same nominal robot and identified parameters.

    Args:
        serials: one for each.
        results: their calibrations.
    """
    first = results[0]
    frames = {name for name, parameter in parameters_of(first.robot).items() if parameter.group in FRAME_GROUPS}
    told = [_told(result) for result in results]
    names = tuple(name for name in told[0] if name not in frames and all(name in found for found in told))
    values = np.array([[found[name].identified for name in names] for found in told]).reshape(len(told), len(names))
    stds = np.array([[found[name].std for name in names] for found in told], dtype=float).reshape(values.shape)
    median, scatter, scores = robust_scores(values, stds)
    enough = len(serials) >= FEWEST and bool(names)
    limit = threshold(len(serials), len(names)) if enough else np.inf
    units = tuple(told[0][name].unit for name in names)
    found = [
        Deviation(serials[i], names[j], units[j], float(values[i, j]), float(median[j]), float(scores[i, j]))
        for i, j in np.argwhere(np.abs(scores) > limit).tolist()
    ]
    found.sort(key=lambda deviation: -abs(deviation.score))
    return Siblings(
        first.robot.name, tuple(serials), names, units, values, stds, median, scatter, scores, limit, tuple(found)
    )


def _told(result: SavedResult) -> dict[str, IdentifiedParameter]:
    return {p.name: p for p in result.parameters if p.std is not None}


def robust_scores(values: Array, stds: Array) -> tuple[Array, Array, Array]:
    """Median and scatter of each column of (robots, parameters), and every value's score.

    The scatter is that of the identified values, so it has the noise of a usual calibration in it; the standard
    deviation is added so that a poor one accuses nobody.
    """
    median = np.median(values, axis=0)
    scatter = CONSISTENT * np.median(np.abs(values - median), axis=0)
    size = np.hypot(scatter, stds)
    moved = values - median
    return median, scatter, np.divide(moved, size, out=np.zeros_like(moved), where=size > 0.0)


@cache
def threshold(robots: int, parameters: int, level: float = LEVEL) -> float:
    """The size that the largest score among alike robots exceeds with probability `level`, over all parameters.

    Each parameter may use level / parameters of it (Bonferroni). Few robots tell their scatter badly, so that this is
    no quantile of the normal distribution: it is drawn, of normal values without noise, which have the largest scores.
    """
    rng, share = np.random.default_rng(0), level / parameters
    samples = int(max(DRAWN / robots, 20.0 / share))
    largest = np.concatenate(list(_largest_scores(rng, samples, robots)))
    return float(np.quantile(largest, 1.0 - share))


def _largest_scores(rng: np.random.Generator, samples: int, robots: int) -> Iterator[Array]:
    block = max(1, 500_000 // robots)
    for begin in range(0, samples, block):
        values = rng.standard_normal((robots, min(block, samples - begin)))
        yield np.abs(robust_scores(values, np.zeros_like(values))[2]).max(axis=0)
