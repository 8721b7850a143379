"""Do a robot and its data belong together? Where they cannot, the fault that explains it is named, not fitted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.errors import EquilibriumError, InputError
from elastocal.identification.alignment import align
from elastocal.identification.faults import Fault, faults
from elastocal.identification.statistics import Residuals, residuals
from elastocal.measurements import Measurements
from elastocal.robot import Robot

SUSPECT = 0.03
"""Misfit of the aligned nominal robot from which on faults are looked for; errors of 5 mm and 0.5 deg everywhere leave
less than 0.06, joint offsets of 5 deg 0.1 to 0.3, faults 0.15 and more."""

BETTER, GOOD = 5.0, 0.2
"""A fault is named if without it the misfit is so many times smaller, and no larger than this, which is the robot's."""

ALIKE = 1.5
"""Of faults that explain the data as well as the best, to this factor, the likeliest is named, then the others."""

BAD = 0.01
"""Misfit of a calibrated robot that cannot be its own."""

FEWEST, SAMPLE = 12, 300
"""Rows below which nothing is said, and rows that suffice."""

MOST_ROWS = 0.8
"""The misfit is what this share of the rows stays below, so that a few outliers do not count."""


def misfit(found: Residuals, data: Measurements, rows: NDArray[np.bool_] | None = None) -> float:
    """What most of the rows' residuals stay below, over the spread of what was measured; angles in rad."""
    each = _row_misfits(found, data)[slice(None) if rows is None else rows]
    return float(np.quantile(each, MOST_ROWS)) if len(each) else 0.0


def _row_misfits(found: Residuals, data: Measurements) -> Array:
    """(n,) residual over the spread of the measured points, plus the orientation's [rad]."""
    total = np.zeros(found.n) if found.angles is None else np.nan_to_num(found.angles)
    return total + np.nan_to_num(found.norms) / spread(data)


def spread(data: Measurements) -> float:
    """Root mean square distance of the measured points from their middle, or the deviation of distances [m]."""
    each = [] if data.position is None else [np.nanvar(data.position, axis=0).sum()]
    each += [] if data.distance is None else [np.nanvar(data.distance)]
    return max(float(np.sqrt(max(each, default=1.0))), 1e-9)


def require_plausible(robot: Robot, aligned: Robot, data: Measurements) -> None:
    """Check that the nominal robot is near the data, as near as robots are.

    Args:
        robot: nominal, its open frames open.
        aligned: the same, its open frames fitted to the data.
        data: what was measured.

    Raises:
        InputError: it is not, and a fault of the data explains that; says which.
    """
    before = misfit(residuals(aligned, data), data)
    if len(data) < FEWEST or before < SUSPECT:
        return
    rows = np.arange(0, len(data), max(1, len(data) // SAMPLE))
    tried = [(_misfit_without(fault, rows), fault) for fault in faults(robot, data)]
    best = min((after for after, _ in tried), default=np.inf)
    if best > min(before / BETTER, GOOD):
        return
    named = [fault for after, fault in tried if after <= ALIKE * best]
    raise InputError(_sentence(named, before / max(best, 1e-9), data))


def _misfit_without(fault: Fault, rows: NDArray[np.intp]) -> float:
    """The misfit of the nominal robot, aligned with the data (those rows) as they were meant."""
    data = fault.data.take(rows)
    try:
        with np.errstate(all="ignore"):
            found = misfit(residuals(align(fault.robot, data), data), data)
    except (EquilibriumError, np.linalg.LinAlgError):
        return np.inf
    return found * fault.freedom if np.isfinite(found) else np.inf


def _sentence(named: Sequence[Fault], better: float, data: Measurements) -> str:
    """What is wrong, what to do, and what else it could be."""
    fault = named[0]
    where = fault.file or ("" if data.source is None else ", ".join(data.source.names))
    others = [other.found for other in named[1:] if other.found != fault.found]
    either = f"; or {', or '.join(dict.fromkeys(others[:3]))}" if others else ""
    return (
        f"{where or 'the measurements'}: {fault.found}{either} (once that is put right the nominal robot fits the data "
        f"{better:.0f} times better); {fault.remedy}"
    )
