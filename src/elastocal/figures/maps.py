"""Figures of joint maps: transmission error against joint position."""

from __future__ import annotations

import numpy as np

from elastocal.chain import Array
from elastocal.figures.panel import Panel, Trace, axes, band, line, numbers, plain, points, thinned
from elastocal.figures.residuals import drawn, reach_of
from elastocal.figures.rows import Rows, driven_elements, turns
from elastocal.figures.style import DATA, LAW, UNSEEN, tinted
from elastocal.identification import AnyResult
from elastocal.identification.intervals import student
from elastocal.robot import JointMap, harmonics

POINTS_IN_WAVE = 8
FEWEST, MOST = 300, 1500
"""Points of a curve."""

COVERAGE_BINS = 72


def map_panels(result: AnyResult, rows: Rows) -> list[Panel]:
    """The map of each joint with its 95 % band, the rows' partial residuals, and where it was measured."""
    found = []
    for joint, element in enumerate(driven_elements(result.robot)):
        error = result.robot.transmission.get(element)
        if error is not None and len(error.sin):
            found.append(_panel(result, rows, joint, element, error))
    return found


def _panel(result: AnyResult, rows: Rows, joint: int, element: str, error: JointMap) -> Panel:
    scale, unit, small = (180.0 / np.pi, "deg", "µrad") if turns(element) else (1e3, "mm", "µm")
    measured = rows.joints[:, joint]
    margin = 0.08 * float(np.ptp(measured)) or 0.1
    low, high = float(measured.min()) - margin, float(measured.max()) + margin
    waves = len(error.sin) * (high - low) / (2.0 * np.pi)
    q = np.linspace(low, high, int(np.clip(POINTS_IN_WAVE * waves, FEWEST, MOST)))
    value, spread = error.at(q), band_of(result, element, error, q)
    said = error.at(measured) + rows.motion[element]
    seen = np.flatnonzero(np.isfinite(said) & ~rows.left_out)
    shown = seen[thinned(len(seen))]
    data = [
        _coverage(scale * measured),
        points(scale * measured[shown], 1e6 * said[shown], "rows", DATA, hoverinfo="skip"),
        *([band(scale * q, 1e6 * (value - spread), 1e6 * (value + spread), "95 % band", LAW)] if spread.any() else []),
        line(scale * q, 1e6 * value, "map", LAW, line={"color": LAW, "width": 1.6}),
    ]
    layout = axes(
        f"position of {plain(element)} [{unit}]",
        f"transmission error [{small}]",
        yaxis=reach_of(1e6 * np.concatenate([said[seen], value])),
        yaxis2={
            "overlaying": "y",
            "side": "right",
            "visible": False,
            "rangemode": "tozero",
            "range": _headroom(measured),
        },
        bargap=0,
    )
    return Panel(element, data, layout, drawn(len(shown), len(seen), rows), height=340)


def band_of(result: AnyResult, element: str, error: JointMap, q: Array) -> Array:
    """Half width (n,) of a map's 95 % band at joint positions (n,)."""
    place = {name: i for i, name in enumerate(result.names)}
    known = [(i, place[f"{element}.{key}"]) for i, key in enumerate(error.coefficients) if f"{element}.{key}" in place]
    if not known:
        return np.zeros_like(q)
    rows, names = (list(found) for found in zip(*known, strict=True))
    waves = harmonics(q, len(error.sin))[rows]
    variance = (waves * (result.covariance[np.ix_(names, names)] @ waves)).sum(axis=0)
    return student(result.freedom) * np.sqrt(np.clip(variance, 0.0, None))


def _counts(measured: Array) -> tuple[Array, Array]:
    counts, edges = np.histogram(measured, COVERAGE_BINS)
    return counts.astype(float), 0.5 * (edges[1:] + edges[:-1])


def _headroom(measured: Array) -> list[float]:
    """The coverage takes the lowest fifth of the panel."""
    return [0.0, 5.0 * float(_counts(measured)[0].max())]


def _coverage(measured: Array) -> Trace:
    counts, middles = _counts(measured)
    return {
        "type": "bar",
        "x": numbers(middles),
        "y": numbers(counts),
        "yaxis": "y2",
        "name": "rows measured",
        "marker": {"color": tinted(UNSEEN), "line": {"width": 0}},
        "hovertemplate": "%{y} rows near %{x:.0f}<extra></extra>",
    }
