"""Figures of position errors: how large before and after, and in which direction where."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.figures.panel import Panel, Trace, axes, counted, line, numbers, plain, thinned
from elastocal.figures.robot import arm_traces
from elastocal.figures.rows import Rows, errors_of
from elastocal.figures.style import AFTER, BEFORE, DATA, SERIES, UNSEEN, tinted
from elastocal.identification import AnyResult

BINS = 48

FAR_APART = 5.0
"""Median errors before and after that differ by more than this factor are shown on a logarithmic axis."""

CURVE_POINTS = 400
"""Points of a cumulative curve."""

MOST_VECTORS = 700
"""Error vectors that are drawn at most."""

REACH = 0.12
"""Length that the 95 % vector is drawn with, as a share of the measured space."""

NICE = (1, 2, 5)
"""Scales are these times a power of ten."""


Groups = dict[str, tuple[Array, str, str]]
"""Errors by name, with colour and dash."""


def error_panels(result: AnyResult) -> list[Panel]:
    """Histogram and cumulative curve of position errors, and of angles where orientations were measured."""
    errors = errors_of(result)
    fitted, held = ~errors.held_out, errors.held_out
    found = []
    for title, unit, before, after in (
        ("Position error", "mm", errors.nominal.norms, errors.calibrated.norms),
        ("Orientation error", "mrad", errors.nominal.angles, errors.calibrated.angles),
    ):
        if before is None or after is None or not np.isfinite(after).any():
            continue
        groups: Groups = {}
        for name, values, rows, color, dash in (
            ("before, fitted", before, fitted, BEFORE, "solid"),
            ("before, held-out", before, held, BEFORE, "dot"),
            ("after, fitted", after, fitted, AFTER, "solid"),
            ("after, held-out", after, held, UNSEEN, "dot"),
        ):
            if rows.any():
                groups[name] = 1e3 * values[rows & np.isfinite(values)], color, dash
        found += [_histogram(f"{title}: histogram", unit, groups), _cumulative(f"{title}: cumulative", unit, groups)]
    return found


def _histogram(title: str, unit: str, groups: Groups) -> Panel:
    low, top, logarithmic = _range(groups)
    edges = np.geomspace(low, top, BINS + 1) if logarithmic else np.linspace(0.0, top, BINS + 1)
    data: list[Trace] = []
    for name, (values, color, dash) in groups.items():
        share = 100.0 * np.histogram(values, edges)[0] / max(len(values), 1)
        step: Trace = {"line": {"shape": "hv", "color": color, "width": 1.8, "dash": dash}}
        fill: Trace = {"fill": "tozeroy", "fillcolor": tinted(color)} if dash == "solid" else {}
        data.append(line(edges, np.append(share, 0.0), name, color) | step | fill)
    layout = axes(f"error [{unit}]", "rows [%]", yaxis={"rangemode": "tozero"}, xaxis=_axis(low, top, logarithmic))
    beyond = sum(int((values > edges[-1]).sum()) for values, *_ in groups.values())
    return Panel(title, data, layout, f"{beyond} rows lie beyond the right edge" if beyond else "")


def _cumulative(title: str, unit: str, groups: Groups) -> Panel:
    data = []
    for name, (values, color, dash) in groups.items():
        level = np.linspace(0.0, 1.0, min(CURVE_POINTS, max(len(values), 2)))
        if len(values):
            data.append(line(np.quantile(values, level), 100.0 * level, name, color, dash))
    layout = axes(f"error [{unit}]", "rows at or below [%]", yaxis={"range": [0, 101]}, xaxis=_axis(*_range(groups)))
    return Panel(title, data, layout)


def _range(groups: Groups) -> tuple[float, float, bool]:
    """The least and the largest error shown, and whether they are too far apart for an even axis."""
    everything = [values for values, *_ in groups.values() if len(values)]
    top = 1.02 * max(float(np.quantile(values, 0.998)) for values in everything) or 1.0
    low = min(float(values.min()) for values in everything)
    middles = [float(np.median(values)) for values in everything]
    return max(low, 1e-4 * top), top, max(middles) > FAR_APART * min(middles)


def _axis(low: float, top: float, logarithmic: bool) -> dict[str, object]:
    if logarithmic:
        return {"type": "log", "range": [float(np.log10(low)), float(np.log10(top))]}
    return {"range": [0.0, top]}


def cumulative_panel(results: Mapping[str, AnyResult]) -> Panel:
    """Cumulative curves of several results' errors after calibration, on held-out rows where there are any."""
    data = []
    for number, (name, result) in enumerate(results.items()):
        errors = errors_of(result)
        rows = errors.held_out if errors.held_out.any() else ~errors.held_out
        values = 1e3 * errors.calibrated.norms[rows]
        values = values[np.isfinite(values)]
        if len(values):
            level = np.linspace(0.0, 1.0, min(CURVE_POINTS, max(len(values), 2)))
            color, dash = SERIES[number % len(SERIES)], ("solid", "dash", "dot")[number // len(SERIES) % 3]
            kind = "held-out" if errors.held_out.any() else "fitted"
            data.append(line(np.quantile(values, level), 100.0 * level, f"{name}, {kind}", color, dash))
    layout = axes(
        "position error [mm]", "rows at or below [%]", yaxis={"range": [0, 101]}, xaxis={"rangemode": "tozero"}
    )
    return Panel("Position error after calibration", data, layout, wide=True, height=380)


def vector_panels(result: AnyResult, rows: Rows) -> list[Panel]:
    """Error vectors at the measured points, before and after, with the robot drawn among them."""
    seen = np.flatnonzero(np.isfinite(rows.position).all(axis=1) & np.isfinite(rows.after).all(axis=1))
    if not len(seen):
        return []
    chosen = seen[thinned(len(seen), MOST_VECTORS)]
    before, after, at = rows.before[chosen], rows.after[chosen], rows.position[chosen]
    spread = float(np.linalg.norm(np.ptp(rows.position[seen], axis=0))) or 1.0
    same, own = (_scale(spread, vectors) for vectors in (before, after))
    data: list[Trace] = [
        _vectors(at, before, same, f"before × {same:g}", BEFORE),
        _vectors(at, after, same, f"after × {same:g}", AFTER),
        _vectors(at, after, own, f"after × {own:g}", AFTER) | {"visible": False},
        _points(at, before, after),
        *arm_traces(result, rows, int(_middle(rows, seen))),
    ]
    views = {
        f"both × {same:g}": (True, True, False),
        f"before × {same:g}": (True, False, False),
        f"after × {same:g}": (False, True, False),
        f"after × {own:g}": (False, False, True),
    }
    note = counted(len(chosen), rows.total, "vectors")
    return [Panel("Error vectors", data, _scene(views), note, height=600, wide=True)]


def _scale(spread: float, vectors: Array) -> float:
    """A round number that the vectors are drawn longer by."""
    usual = float(np.quantile(np.linalg.norm(vectors, axis=1), 0.95)) or 1.0
    wanted = REACH * spread / usual
    power = 10.0 ** np.floor(np.log10(wanted))
    return float(max(nice * power for nice in NICE if nice * power <= wanted))


def _middle(rows: Rows, seen: NDArray[np.intp]) -> int:
    """The row whose joints are nearest to the middle of all: a pose that looks like the others."""
    joints = rows.joints[seen]
    spread = joints.std(axis=0)
    apart = (joints - np.median(joints, axis=0)) / np.where(spread > 0.0, spread, 1.0)
    return int(seen[int(np.argmin((apart**2).sum(axis=1)))])


def _vectors(at: Array, vectors: Array, scale: float, name: str, color: str) -> Trace:
    ends = np.stack([at, at + scale * vectors, np.full_like(at, np.nan)], axis=1).reshape(-1, 3)
    x, y, z = (numbers(values) for values in ends.T)
    trace: Trace = {"type": "scatter3d", "mode": "lines", "x": x, "y": y, "z": z, "name": name}
    return trace | {"line": {"color": color, "width": 3}, "hoverinfo": "skip"}


def _points(at: Array, before: Array, after: Array) -> Trace:
    x, y, z = (numbers(values) for values in at.T)
    sizes = np.stack([1e3 * np.linalg.norm(vectors, axis=1) for vectors in (before, after)], axis=1)
    return {
        "type": "scatter3d",
        "mode": "markers",
        "x": x,
        "y": y,
        "z": z,
        "name": "measured points",
        "marker": {"size": 1.8, "color": DATA},
        "customdata": numbers(sizes),
        "hovertemplate": "before %{customdata[0]:.3f} mm<br>after %{customdata[1]:.3f} mm<extra></extra>",
    }


def _scene(views: Mapping[str, tuple[bool, ...]]) -> dict[str, object]:
    """A scene in the base's frame, with a button for each view."""
    buttons = [
        {"label": plain(name), "method": "restyle", "args": [{"visible": list(shown)}, [0, 1, 2]]}
        for name, shown in views.items()
    ]
    menu = {"type": "dropdown", "buttons": buttons, "x": 0, "xanchor": "left", "y": 1, "yanchor": "top"}
    return {
        "scene": {
            "aspectmode": "data",
            **{f"{axis}axis": {"title": {"text": f"{axis} [m]"}} for axis in "xyz"},
            "camera": {"eye": {"x": 1.25, "y": 1.25, "z": 0.7}},
        },
        "updatemenus": [menu | {"pad": {"l": 4, "t": 4}}],
        "margin": {"l": 0, "r": 0, "t": 0, "b": 0},
        "legend": {"x": 1, "xanchor": "right", "y": 1, "yanchor": "top", "orientation": "v"},
        "uirevision": "kept",
    }
