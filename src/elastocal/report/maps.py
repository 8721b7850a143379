"""The section on joint maps."""

from __future__ import annotations

import numpy as np

from elastocal.chain import Array
from elastocal.errors import InputError
from elastocal.identification import AnyResult
from elastocal.report.section import Section

POINTS = 2000
"""Joint positions at which a map's size is taken."""

STRONGEST = 4
"""So many orders of a map are named."""


def maps_section(result: AnyResult) -> Section:
    """Each joint's map over the positions that were measured: its size and its strongest orders.

    Raises:
        InputError: the result was loaded without its rows.
    """
    if result.errors is None:
        raise InputError("the result has no rows: there is no residuals.csv in its folder")
    q = result.errors.data.q[~result.errors.held_out]
    turned = q if result.robot.coupling is None else q @ np.array(result.robot.coupling).T
    rows = []
    for row, measured in zip(result.robot.joints, turned.T, strict=True):
        element = row.joint_element or ""
        error = result.robot.transmission[element]
        values = error.at(np.linspace(measured.min(), measured.max(), POINTS))
        scale, unit = (180.0 / np.pi, "deg") if row.joint == "revolute" else (1e3, "mm")
        amplitude = np.hypot(error.sin, error.cos)
        orders = np.sort(np.argsort(-amplitude)[:STRONGEST] + 1)
        rows.append(
            (
                element,
                f"{1e6 * np.sqrt(np.mean(values**2)):.0f}",
                f"{1e6 * np.abs(values).max():.0f}",
                ", ".join(map(str, orders)),
                f"{scale * measured.min():.0f} … {scale * measured.max():.0f} {unit}",
                f"{scale * _widest_gap(measured, row.joint == 'revolute'):.0f} {unit}",
            )
        )
    header = ("joint", "rms [µrad]", "max [µrad]", "strongest orders", "measured", "widest gap")
    return Section("Joint maps", header, tuple(rows), tuple(_sentences(result)))


def _widest_gap(positions: Array, turns: bool) -> float:
    """Between neighbouring positions (n,), of a joint that turns around the whole circle."""
    if not turns:
        return float(np.diff(np.sort(positions)).max(initial=0.0))
    ordered = np.sort(positions % (2.0 * np.pi))
    return float(np.diff(ordered, append=ordered[0] + 2.0 * np.pi).max())


def _sentences(result: AnyResult) -> list[str]:
    maps = result.maps
    if maps is None:
        return []
    told = [f"Fourier maps of {maps.orders} orders, each band's size estimated from the data"]
    if maps.log_evidence:
        told[0] += ", as many as the evidence favours"
    return [
        f"{told[0]}; where a joint was not measured its map fades out, and the standard deviation of a predicted "
        "position says so."
    ]
