"""Results of many arms in a few numbers."""

from __future__ import annotations

import math
import statistics
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from runs import Result

LAWS = ("rigid", "linear", "step", "hinge")


@dataclass(frozen=True)
class Cell:
    """A setting on the arms of one law.

    Attributes:
        arms: how many were fitted.
        failed: of them, how many gave no prediction.
        mean: held-out mean error, mean over the arms [mm].
        least, most: of the held-out mean errors [mm].
        worst: the largest error at any held-out pose of any arm [mm].
    """

    arms: int
    failed: int
    mean: float
    least: float
    most: float
    worst: float


def cell(results: Iterable[Result], tool: str, setting: str, law: str) -> Cell:
    """Summarise."""
    found = [r for r in results if (r.tool, r.setting, r.law) == (tool, setting, law)]
    means = [r.mean for r in found if r.status == "done"]
    if not means:
        return Cell(len(found), len(found), math.nan, math.nan, math.nan, math.nan)
    worst = max(r.largest for r in found if r.status == "done")
    return Cell(len(found), len(found) - len(means), statistics.fmean(means), min(means), max(means), worst)


def of_setting(results: Iterable[Result], tool: str, setting: str) -> list[Result]:
    """All of a setting's results."""
    return [r for r in results if (r.tool, r.setting) == (tool, setting)]


def median_seconds(results: Sequence[Result]) -> tuple[float, float]:
    """Of the processor, medians over the arms: the fit's and the process's."""
    done = [r for r in results if r.status == "done"]
    if not done:
        return math.nan, math.nan
    return statistics.median(r.fit_seconds for r in done), statistics.median(r.process_seconds for r in done)


def worsened(results: Sequence[Result], tool: str, setting: str) -> int:
    """Arms whose calibrated model is worse than the nominal robot where it stands."""
    before = {(r.law, r.seed): r.mean for r in results if r.tool == "nominal"}
    return sum(r.mean > before[r.law, r.seed] for r in of_setting(results, tool, setting) if r.status == "done")


def notes(results: Iterable[Result]) -> Counter[str]:
    """How often a tool said what."""
    return Counter(r.note for r in results if r.note and r.status == "done")


def failures(results: Iterable[Result]) -> Counter[str]:
    """Why runs gave nothing."""
    return Counter(r.note for r in results if r.status == "failed")
