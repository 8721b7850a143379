"""Figures of compliance: torque against deflection of each elastic element, and the search for transition torques."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from elastocal.chain import Array
from elastocal.elasticity import CURVES, LAWS, Load
from elastocal.figures.panel import (
    Panel,
    Trace,
    axes,
    band,
    level,
    line,
    numbers,
    plain,
    points,
    stripe,
    thinned,
    upright,
)
from elastocal.figures.residuals import ROWS_IN_BIN, drawn, reach_of, small_unit
from elastocal.figures.rows import Rows, binned, turns
from elastocal.figures.style import DATA, LAW, MARK, MEANS, SEQUENTIAL, SERIES
from elastocal.identification import AnyResult, IdentifiedElement
from elastocal.identification.intervals import student
from elastocal.identification.transition import allowed_rise

CURVE_POINTS = 240
BINS = 16


def law_panels(result: AnyResult, rows: Rows) -> list[Panel]:
    """Torque against deflection of each elastic element: the law, its band, and what the rows say of it."""
    return [_law_panel(result, found, rows) for found in result.elastic if found.element in rows.loads]


def _law_panel(result: AnyResult, found: IdentifiedElement, rows: Rows) -> Panel:
    element, load = found.element, rows.loads[found.element]
    unit, _ = units(element)
    low, high = min(float(load.min()), 0.0), max(float(load.max()), 0.0)
    torque = torques_along(found, low, high)
    law, spread = law_at(result, found, torque)
    said = deflection_at(result, found, load) + rows.motion[element]
    factor, small = small_unit(element, said)
    seen = np.flatnonzero(np.isfinite(said) & ~rows.left_out)
    shown = seen[thinned(len(seen))]
    weight = np.where(rows.left_out, 0.0, rows.weight[element])
    means = binned(load, said, weight, int(np.clip(len(rows) // ROWS_IN_BIN, 6, BINS)))
    data = [
        points(load[shown], factor * said[shown], "rows", DATA, hoverinfo="skip"),
        *([band(torque, factor * (law - spread), factor * (law + spread), "95 % band", LAW)] if spread.any() else []),
        line(torque, factor * law, f"{found.law} law", LAW, line={"color": LAW, "width": 2.5}),
        _mean_points(means.at, factor * means.mean, 2.0 * factor * means.error),
    ]
    layout = axes(
        f"{'torque' if turns(element) else 'force'} [{unit}]",
        f"deflection [{small}]",
        shapes=_torque_marks(found, low, high),
        yaxis=reach_of(factor * np.append(said[seen], law)),
    )
    return Panel(element, data, layout, drawn(len(shown), len(seen), rows), height=360)


def units(element: str) -> tuple[str, str]:
    """Units of load and of a small deflection."""
    return ("N·m", "µrad") if turns(element) else ("N", "µm")


def torques_along(found: IdentifiedElement, low: float, high: float) -> Array:
    """Loads from low to high, with both sides of transition torques among them."""
    torque = found.transition_torque
    sides = [] if torque is None else [sign * torque * side for sign in (-1, 1) for side in (1 - 1e-6, 1 + 1e-6)]
    inside = [value for value in sides if low < value < high]
    return np.unique(np.concatenate([np.linspace(low, high, CURVE_POINTS), inside]))


def deflection_at(result: AnyResult, found: IdentifiedElement, load: Array) -> Array:
    """Deflections (n,) by the identified law at loads (n,)."""
    at = Load(load, load, found.transition_torque or 0.0)
    return CURVES[found.law].respond(result.robot.elastic[found.element].coefficients, at).deflection


def law_at(result: AnyResult, found: IdentifiedElement, load: Array) -> tuple[Array, Array]:
    """Deflections (n,) by the identified law, and the half width (n,) of their 95 % band."""
    at = Load(load, load, found.transition_torque or 0.0)
    response = CURVES[found.law].respond(result.robot.elastic[found.element].coefficients, at)
    keys = (*LAWS[found.law].coefficients, "transition_torque") if found.law in LAWS else ()
    known = [
        (i, result.names.index(f"{found.element}.{k}"))
        for i, k in enumerate(keys)
        if f"{found.element}.{k}" in result.names
    ]
    if not known:
        return response.deflection, np.zeros_like(load)
    rows, names = (list(found_) for found_ in zip(*known, strict=True))
    partials = response.partials[rows]
    variance = np.einsum("in,ij,jn->n", partials, result.covariance[np.ix_(names, names)], partials)
    return response.deflection, student(result.freedom) * np.sqrt(np.clip(variance, 0.0, None))


def _mean_points(x: Array, y: Array, error: Array) -> Trace:
    return points(x, y, "mean ± 2 standard errors", MEANS, marker={"size": 6, "opacity": 1.0, "symbol": "diamond"}) | {
        "error_y": {"type": "data", "array": numbers(error), "color": MEANS, "thickness": 1.2, "width": 3}
    }


def _torque_marks(found: IdentifiedElement, low: float, high: float) -> list[Trace]:
    """Lines at the transition torque on both sides of zero, and stripes where it lies with 95 % confidence."""
    torque, shapes = found.transition_torque, []
    if torque is None:
        return []
    interval = None if found.transition is None else found.transition.interval
    for sign in (-1.0, 1.0):
        if low <= sign * torque <= high:
            if interval is not None:
                edges = sorted(float(np.clip(sign * end, low, high)) for end in interval)
                shapes.append(stripe(edges[0], edges[1], MARK))
            shapes.append(upright(sign * torque, MARK))
    return shapes


def overlay_panels(results: Mapping[str, AnyResult], loads: Mapping[str, tuple[float, float]]) -> list[Panel]:
    """The laws of several results over one another, with their bands.

    Args:
        results: by name.
        loads: by element, the least and the largest load of any.
    """
    found = []
    for element, (low, high) in loads.items():
        unit, small = units(element)
        data: list[Trace] = []
        for number, (name, result) in enumerate(results.items()):
            law = next((e for e in result.elastic if e.element == element), None)
            if law is not None:
                color = SERIES[number % len(SERIES)]
                torque = torques_along(law, low, high)
                value, spread = law_at(result, law, torque)
                data.append(
                    band(torque, 1e6 * (value - spread), 1e6 * (value + spread), name, color) | {"showlegend": False}
                )
                data.append(line(torque, 1e6 * value, f"{name}, {law.law}", color))
        layout = axes(f"{'torque' if turns(element) else 'force'} [{unit}]", f"deflection [{small}]")
        found.append(Panel(element, data, layout, height=360))
    return found


def search_panels(result: AnyResult) -> list[Panel]:
    """The misfit at all transition torques that were compared, and the generations of a genetic algorithm."""
    reach = student(result.freedom)
    found = [
        _curve_panel(element, math.sqrt(allowed_rise(element.law, reach)))
        for element in result.elastic
        if _curved(element)
    ]
    search = result.search
    if search is not None and search.pair is not None:
        found.append(_pair_panel(result))
    if search is not None and search.history:
        generations = np.arange(1.0, len(search.history) + 1.0)
        data = [line(generations, np.array(search.history), "best of each generation", LAW)]
        found.append(Panel("Genetic algorithm", data, axes("generation", "misfit, of that with linear laws")))
    return found


def _curved(found: IdentifiedElement) -> bool:
    return found.transition is not None and found.transition.curve is not None


def _curve_panel(found: IdentifiedElement, limit: float) -> Panel:
    curve = found.transition.curve if found.transition else None
    torques, rises = (np.array(values) for values in ((curve.torques, curve.rises) if curve else ((), ())))
    shapes = [level(limit, MARK, "dot"), upright(found.transition_torque or 0.0, MARK)]
    interval = found.transition.interval if found.transition else None
    if interval is not None and len(torques):
        low, high = max(interval[0], float(torques[0])), min(interval[1], float(torques[-1]))
        shapes.insert(0, stripe(low, high, MARK))
    data = [line(torques, np.sqrt(np.clip(rises, 0.0, None)), "misfit above the best", LAW)]
    unit, _ = units(found.element)
    layout = axes(f"transition torque [{unit}]", "worse by [standard deviations]", shapes=shapes, showlegend=False)
    return Panel(found.element, data, layout | {"yaxis": layout["yaxis"] | {"rangemode": "tozero"}})


def _pair_panel(result: AnyResult) -> Panel:
    pair = result.search.pair if result.search else None
    if pair is None:
        raise ValueError("no pair of transition torques was searched")
    first, second = pair.torques
    best: Sequence[float] = [
        next((e.transition_torque or math.nan for e in result.elastic if e.element == name), math.nan)
        for name in pair.elements
    ]
    worse = np.sqrt(np.clip(np.array(pair.rises), 0.0, None))
    data: list[Trace] = [
        {
            "type": "heatmap",
            "x": numbers(first),
            "y": numbers(second),
            "z": numbers(worse.T),
            "colorscale": SEQUENTIAL,
            "reversescale": True,
            "zmin": 0.0,
            "zmax": float(worse.max()) or 1.0,
            "colorbar": {"title": {"text": "worse by<br>[std]"}, "thickness": 12},
            "hovertemplate": "%{x:.1f}, %{y:.1f}: worse by %{z:.2f}<extra></extra>",
        },
        points(
            np.array(best[:1]), np.array(best[1:]), "found", MARK, marker={"size": 13, "symbol": "x", "opacity": 1.0}
        ),
    ]
    labels = [f"{plain(name)} [{units(name)[0]}]" for name in pair.elements]
    return Panel("Both transition torques", data, axes(*labels, showlegend=False), height=380)
