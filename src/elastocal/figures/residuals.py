"""Figures of what the model leaves, joint by joint: against the joint's own position, and against its torque."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from elastocal.chain import Array
from elastocal.figures.panel import Panel, Trace, axes, band, counted, line, plain, points, thinned
from elastocal.figures.rows import Means, Rows, binned, driven_elements, turns
from elastocal.figures.style import DATA, LAW, MEANS
from elastocal.identification import AnyResult
from elastocal.robot import Robot

ANGLE_BINS, TORQUE_BINS = 120, 30
ROWS_IN_BIN = 25

ROUNDING = 1e-9
"""Loads [N m or N] that differ by less are the same: nothing presses on the joint."""

LARGE = 2e-3
"""Motions [rad or m] from which on the larger unit serves."""

WIDE = 0.06
WIDER = 3.0
"""A share of the range without rows, and how much wider than usual it is, that is left open."""

WITHIN = 0.997
"""Share of the points that a panel's axes hold."""


@dataclass(frozen=True)
class Pattern:
    """How much of what is left follows a joint's position, and its torque; None where it carries none."""

    element: str
    position: Means
    torque: Means | None


def patterns(result: AnyResult, rows: Rows) -> list[Pattern]:
    """What of the residuals follows each joint; torques are None of joints that carry none."""
    found = []
    for joint, element in enumerate(driven_elements(result.robot)):
        if not np.isfinite(rows.motion[element]).any():
            continue
        torque = means_by_torque(rows, element) if _loaded(rows.loads[element]) else None
        found.append(Pattern(element, means_by_joint(rows, joint, element), torque))
    return found


def _loaded(loads: Array) -> bool:
    return bool(len(loads) and np.ptp(loads) > ROUNDING)


def means_by_joint(rows: Rows, joint: int, element: str) -> Means:
    """Means of what is left, along a joint's own position."""
    return _means(rows, rows.joints[:, joint], element, ANGLE_BINS)


def means_by_torque(rows: Rows, element: str) -> Means:
    """Means of what is left, along the torque on a joint."""
    return _means(rows, rows.loads[element], element, TORQUE_BINS)


def _means(rows: Rows, x: Array, element: str, most: int) -> Means:
    good = np.where(rows.left_out, 0.0, rows.weight[element])
    return binned(x, rows.motion[element], good, int(np.clip(len(rows) // ROWS_IN_BIN, 6, most)))


def joint_panels(result: AnyResult, rows: Rows) -> list[Panel]:
    """What is left as a motion of each joint, against the joint's position."""
    return list(_joint_panels(result.robot, rows))


def _joint_panels(robot: Robot, rows: Rows) -> Iterator[Panel]:
    for joint, element in enumerate(driven_elements(robot)):
        if not np.isfinite(rows.motion[element]).any():
            continue  # it does not move the target
        scale, unit = (180.0 / np.pi, "deg") if turns(element) else (1e3, "mm")
        means = means_by_joint(rows, joint, element)
        yield _panel(rows, scale * rows.joints[:, joint], element, means, scale, f"position of {element} [{unit}]")


def torque_panels(result: AnyResult, rows: Rows) -> list[Panel]:
    """What is left as a motion of each joint that carries a load, against the load."""
    found = []
    for element in driven_elements(result.robot):
        if _loaded(rows.loads[element]) and np.isfinite(rows.motion[element]).any():
            unit = "N·m" if turns(element) else "N"
            load = f"{'torque' if turns(element) else 'force'} on {element} [{unit}]"
            found.append(_panel(rows, rows.loads[element], element, means_by_torque(rows, element), 1.0, load))
    return found


def _panel(rows: Rows, x: Array, element: str, means: Means, scale: float, label: str) -> Panel:
    factor, unit = small_unit(element, rows.motion[element])
    values = factor * rows.motion[element]
    seen = np.flatnonzero(np.isfinite(values) & ~rows.left_out)
    shown = seen[thinned(len(seen))]
    at, mean, error = (
        _parted(means.at, v) for v in (scale * means.at, factor * means.mean, 2.0 * factor * means.error)
    )
    data = [
        points(x[shown], values[shown], "rows", DATA, hoverinfo="skip"),
        *_bands(at, mean, error),
        line(at, mean, "mean", MEANS),
    ]
    layout = axes(plain(label), f"left over [{unit}]", yaxis=reach_of(values[seen]), showlegend=False)
    return Panel(element, data, layout, drawn(len(shown), len(seen), rows), height=290)


def drawn(shown: int, seen: int, rows: Rows) -> str:
    """What of the rows a cloud of points does not show."""
    if shown < seen:
        return counted(shown, rows.total)
    hardly = len(rows) - int(rows.left_out.sum()) - seen
    return f"without {hardly} rows that hardly tell of it" if hardly and seen else ""


def small_unit(element: str, values: Array) -> tuple[float, str]:
    """A unit for small motions of an element, and its factor from SI, by how large they are."""
    usual = np.nanquantile(np.abs(values), 0.9) if np.isfinite(values).any() else 0.0
    if usual > LARGE:
        return 1e3, "mrad" if turns(element) else "mm"
    return 1e6, "µrad" if turns(element) else "µm"


def _parted(at: Array, values: Array) -> Array:
    """Values (n,) with NaN where nothing was measured for long, so that no curve is drawn across."""
    gaps = np.diff(at)
    if not len(gaps):
        return values
    wide = np.flatnonzero((gaps > WIDE * np.ptp(at)) & (gaps > WIDER * np.median(gaps))) + 1
    return np.insert(values, wide, np.nan)


def _bands(at: Array, mean: Array, error: Array) -> list[Trace]:
    """The band of each stretch between gaps."""
    ends = np.flatnonzero(~np.isfinite(at))
    stretches = zip([0, *(ends + 1)], [*ends, len(at)], strict=True)
    named = [(slice(a, b), i) for i, (a, b) in enumerate(stretches)]
    return [
        band(at[s], mean[s] - error[s], mean[s] + error[s], "± 2 standard errors", LAW) | {"showlegend": i == 0}
        for s, i in named
    ]


def reach_of(values: Array) -> dict[str, list[float]]:
    """The range of an axis that holds nearly all values; plotly's own choice if there are none."""
    if not len(values):
        return {}
    low, high = np.quantile(values, [0.5 - WITHIN / 2, 0.5 + WITHIN / 2])
    margin = 0.1 * (high - low) or 1.0
    return {"range": [float(low - margin), float(high + margin)]}
