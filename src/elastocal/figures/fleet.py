"""Figures of a fleet: errors before and after, robots beside their siblings."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from elastocal.figures.panel import Panel, axes, level, line, plain, points
from elastocal.figures.style import AFTER, BEFORE, DATA, LAW, MARK
from elastocal.fleet import Drift, FleetSummary, Siblings, accuracy


def error_panels(summary: FleetSummary) -> list[Panel]:
    """Mean position errors of all calibrations before and after, as shares of them."""
    told = [accuracy(outcome.result) for outcome in summary.outcomes if outcome.result is not None]
    found = {
        "before": (BEFORE, [before.mean for _, before, _ in told if before is not None]),
        "after": (AFTER, [after.mean for _, _, after in told if after is not None]),
    }
    traces = [
        line(1e3 * np.sort(values), np.arange(1, len(values) + 1) / len(values), name, color)
        for name, (color, values) in found.items()
        if values
    ]
    layout = axes("mean position error [mm]", "share of calibrations", xaxis={"type": "log"})
    return [Panel("Errors before and after", traces, layout)] if traces else []


def score_panels(group: Siblings) -> list[Panel]:
    """How far each robot's parameters are from those of its siblings, and the bound beyond which it differs."""
    if not np.isfinite(group.threshold):
        return []
    robots, parameters = group.scores.shape
    column = np.tile(np.arange(parameters, dtype=np.float64), robots)
    names = [f"{serial}, {name}" for serial in group.serials for name in group.parameters]
    scores = group.scores.ravel()
    odd = np.abs(scores) > group.threshold
    traces = [
        points(column[rows], scores[rows], name, color, text=[plain(names[i]) for i in np.flatnonzero(rows)])
        for name, color, rows in (("alike", DATA, ~odd), ("differs", MARK, odd))
        if rows.any()
    ]
    ticks = {"tickvals": list(range(parameters)), "ticktext": [plain(name) for name in group.parameters]}
    bounds = [level(sign * group.threshold, MARK) for sign in (-1.0, 1.0)]
    layout = axes("", "score", xaxis=ticks | {"tickangle": -90}, shapes=bounds)
    return [Panel(f"{group.robot}: robots beside their siblings", traces, layout, height=420, wide=True)]


def compliance_panels(group: Siblings, columns: Sequence[int], units: Sequence[tuple[str, float]]) -> list[Panel]:
    """Identified compliances of all robots, in order, with two standard deviations."""
    panels = []
    for i, (unit, scale) in zip(columns, units, strict=True):
        order = np.argsort(group.values[:, i])
        bars = {"type": "data", "array": (2.0 * scale * group.stds[order, i]).tolist(), "thickness": 1, "width": 0}
        serials = [plain(group.serials[k]) for k in order]
        trace = points(
            np.arange(len(order), dtype=np.float64),
            scale * group.values[order, i],
            "robots",
            LAW,
            error_y=bars,
            text=serials,
        )
        layout = axes("robots in order", f"compliance [{unit}]", showlegend=False)
        panels.append(Panel(group.parameters[i], [trace], layout))
    return panels


def drift_panels(drifts: Sequence[Drift]) -> list[Panel]:
    """Change of the flange's position from date to date against what noise gives it."""
    found = [(drift, drift.found) for drift in drifts if drift.found is not None]
    traces = []
    for name, color, wanted in (("noise", DATA, False), ("drift", MARK, True)):
        chosen = [(drift, one) for drift, one in found if one.drift is wanted]
        if chosen:
            noise = 1e3 * np.array([one.noise for _, one in chosen])
            moved = 1e3 * np.array([one.position[0] for _, one in chosen])
            text = [plain(f"{drift.serial}, {drift.before} to {drift.after}") for drift, _ in chosen]
            traces.append(points(noise, moved, name, color, text=text))
    layout = axes("what noise gives [mm]", "change at the flange [mm]", yaxis={"type": "log"}, xaxis={"type": "log"})
    return [Panel("Drift or noise", traces, layout)] if traces else []
