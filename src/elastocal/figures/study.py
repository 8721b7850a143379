"""Figures of a study: a figure of its calibrations against what its grid varies."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import groupby
from typing import Any

import numpy as np

from elastocal.figures.panel import Panel, axes, level, plain
from elastocal.figures.style import MARK, SERIES
from elastocal.io.study_values import Setting
from elastocal.studies import CellSummary, StudySummary

NUMERIC = ("poses", "noise", "outliers", "outlier_size", "noise_angle", "bootstrap")
UNITS = {"noise": 1e3, "outlier_size": 1e3, "noise_angle": 1e3}
TITLES = {
    "poses": "poses",
    "noise": "noise [mm]",
    "outliers": "share of outliers",
    "outlier_size": "size of outliers [mm]",
    "noise_angle": "noise of orientations [mrad]",
    "bootstrap": "fits of the bootstrap",
}

Words = Callable[[Setting, tuple[str, ...]], tuple[str, ...]]
Told = Callable[[CellSummary], tuple[float, float, float]]


def study_panels(summary: StudySummary, words: Words) -> list[Panel]:
    """Held-out error, and what else was asked for, each against the first number that the grid varies.

    Args:
        summary: of the study.
        words: how parts of a setting are shown.
    """
    error = _panel(summary, words, "Held-out error", "mean held-out error [mm]", _error, yaxis={"type": "log"})
    panels = [error]
    if any(cell.coverage for cell in summary.cells):
        title = "95 % intervals that cover [%]"
        panels.append(_panel(summary, words, "Coverage", title, _coverage, shapes=[level(95.0, MARK)]))
    if any(cell.right for cell in summary.cells):
        span = {"range": [0, 102]}
        panels.append(_panel(summary, words, "The right law is found", "calibrations [%]", _right, yaxis=span))
    return panels


def _error(cell: CellSummary) -> tuple[float, float, float]:
    spread = 2e3 * cell.held_out_error
    return 1e3 * cell.held_out_mean, spread, spread


def _coverage(cell: CellSummary) -> tuple[float, float, float]:
    if cell.coverage is None:
        return (np.nan,) * 3
    value, (low, high) = cell.coverage.pooled.value, cell.coverage.pooled.interval
    return 100 * value, 100 * (value - low), 100 * (high - value)


def _right(cell: CellSummary) -> tuple[float, float, float]:
    if cell.right is None:
        return (np.nan,) * 3
    value, (low, high) = cell.right.value, cell.right.interval
    return 100 * value, 100 * (value - low), 100 * (high - value)


def _panel(summary: StudySummary, words: Words, title: str, y_title: str, told: Told, **more: Any) -> Panel:
    """A figure against the first number that is varied, a curve for each combination of the rest."""
    varied = summary.study.varied
    against = next((name for name in NUMERIC if name in varied), None)
    others = tuple(name for name in varied if name != against)
    if against is None:
        cells = [", ".join(words(cell.setting, others)) for cell in summary.cells]
        trace = _series(range(len(cells)), summary.cells, told, "", 0)
        ticks = {"tickvals": list(range(len(cells))), "ticktext": [plain(cell) for cell in cells]}
        return Panel(title, [trace], axes("", y_title, xaxis=ticks, showlegend=False, **more), wide=len(cells) > 6)
    ordered = sorted(summary.cells, key=lambda cell: (words(cell.setting, others), getattr(cell.setting, against)))
    traces = []
    for number, (name, group) in enumerate(groupby(ordered, key=lambda cell: words(cell.setting, others))):
        cells_of = list(group)
        x = [getattr(cell.setting, against) * UNITS.get(against, 1.0) for cell in cells_of]
        traces.append(_series(x, cells_of, told, ", ".join(name), number))
    layout = axes(TITLES[against], y_title, showlegend=len(traces) > 1, **more)
    return Panel(title, traces, layout, height=380)


def _series(
    x: Sequence[float] | range, cells: Sequence[CellSummary], told: Told, name: str, number: int
) -> dict[str, object]:
    values = np.array([told(cell) for cell in cells])
    color = SERIES[number % len(SERIES)]
    bars = {"type": "data", "array": values[:, 2].tolist(), "arrayminus": values[:, 1].tolist(), "symmetric": False}
    return {
        "type": "scatter",
        "mode": "lines+markers" if name or len(cells) > 1 else "markers",
        "x": list(x),
        "y": values[:, 0].tolist(),
        "name": plain(name),
        "error_y": bars | {"thickness": 1, "width": 3},
        "line": {"color": color, "width": 2},
    }
