"""The accuracy map: how sure the predicted position is over the workspace."""

from __future__ import annotations

from collections import Counter

import numpy as np

from elastocal.chain import Array
from elastocal.figures.panel import Panel, Trace, axes, numbers, points, thinned
from elastocal.figures.rows import Rows, errors_of
from elastocal.figures.style import MARK, SEQUENTIAL
from elastocal.identification import AnyResult
from elastocal.measurements import Labels, Measurements
from elastocal.simulation import random_poses
from elastocal.uncertainty import Uncertainty, uncertainty_at

POSES, POSES_OF_MANY = 4000, 1500
"""Random poses, and how many where there are more than MANY parameters."""

MANY = 200

CELLS = 24

MOST_MEASURED = 400
"""Measured points that are drawn on the map."""


def workspace_uncertainty(result: AnyResult, poses: int | None = None, seed: int = 0) -> Uncertainty:
    """The uncertainty at random poses within the joint limits, of the target, station and payload measured most.

    Raises:
        EquilibriumError: a pose does not settle under its load.
        ValueError: the result was read without its rows.
    """
    data, poses = errors_of(result).data, poses or (POSES if len(result.names) <= MANY else POSES_OF_MANY)
    labels = [data.station, data.target, data.load]
    codes = zip(*(np.full(len(data), -1) if label is None else label.codes for label in labels), strict=True)
    usual = Counter(tuple(int(code) for code in row) for row in codes).most_common(1)[0][0]
    names = (None if label is None else label.name(code) for label, code in zip(labels, usual, strict=True))
    station, target, load = (Labels.same(name, poses) for name in names)
    q = random_poses(result.robot, poses, seed)
    return uncertainty_at(result, Measurements(q, station=station, target=target, load=load))


def accuracy_panels(result: AnyResult, rows: Rows, found: Uncertainty) -> list[Panel]:
    """Median standard deviation of the predicted position, seen from the side and from above, base frame."""
    station = found.data.station
    base = result.robot.base if station is None else result.robot.stations[station.names[0]]
    at = (found.position - base.translation) @ base.rotation
    seen = np.flatnonzero(np.isfinite(rows.position).all(axis=1))
    measured = rows.position[seen[thinned(len(seen), MOST_MEASURED)]]
    total = 1e3 * found.total
    top = float(np.quantile(total, 0.98))
    low = float(total.min())
    sides = np.hypot(at[:, 0], at[:, 1]), np.hypot(measured[:, 0], measured[:, 1])
    return [
        _map(
            "From the side",
            (sides[0], at[:, 2]),
            total,
            (sides[1], measured[:, 2]),
            ("radius [m]", "height [m]"),
            (low, top),
        ),
        _map(
            "From above", (at[:, 0], at[:, 1]), total, (measured[:, 0], measured[:, 1]), ("x [m]", "y [m]"), (low, top)
        ),
    ]


def _map(
    title: str,
    at: tuple[Array, Array],
    values: Array,
    measured: tuple[Array, Array],
    labels: tuple[str, str],
    reach: tuple[float, float],
) -> Panel:
    x, y, z = _cells(at, values)
    heat: Trace = {
        "type": "heatmap",
        "x": numbers(x),
        "y": numbers(y),
        "z": numbers(z),
        "zmin": reach[0],
        "zmax": reach[1],
        "colorscale": SEQUENTIAL,
        "colorbar": {"title": {"text": "std [mm]"}, "thickness": 12},
        "hoverongaps": False,
        "hovertemplate": "%{x:.2f}, %{y:.2f} m: %{z:.3f} mm<extra></extra>",
    }
    dots = points(*measured, "measured", MARK, hoverinfo="skip", marker={"size": 3, "opacity": 0.7})
    layout = axes(
        *labels, yaxis={"scaleanchor": "x", "scaleratio": 1, "constrain": "domain"}, xaxis={"constrain": "domain"}
    )
    return Panel(title, [heat, dots], layout, height=400)


def _cells(at: tuple[Array, Array], values: Array) -> tuple[Array, Array, Array]:
    """Middles of square cells along both axes, and the median of the values in each, NaN where there is none."""
    size = max(float(np.ptp(axis)) for axis in at) / CELLS or 1.0
    places = [np.floor((axis - axis.min()) / size).astype(int) for axis in at]
    x, y = (axis.min() + size * (np.arange(place.max() + 1) + 0.5) for axis, place in zip(at, places, strict=True))
    medians = np.full((len(y), len(x)), np.nan)
    number = places[1] * len(x) + places[0]
    for cell in np.unique(number):
        medians.flat[cell] = np.median(values[number == cell])
    return x, y, medians
