"""Sentences: what went wrong and what to do about it, and what the data cannot say."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from elastocal.identification.gauge import Gauge
from elastocal.identification.observability import Observability
from elastocal.identification.result import IdentifiedParameter
from elastocal.identification.statistics import Statistics
from elastocal.measurements import Measurements
from elastocal.robot import Robot

NARROW = np.radians(20.0)
"""A revolute joint that moved less than this tells little of what lies before and behind it."""

WEAK = 1e-3
"""What a standard deviation does to the target at generic poses, rms [m], from which a parameter is called weakly determined."""

FEW = 0.5
"""Degrees of freedom per parameter below which a residual flatters."""


def verdict_on(status: str, residuals: Mapping[str, Statistics], identified: int) -> str:
    """One sentence on a calibration."""
    before, after = ("held_out_nominal", "held_out") if "held_out" in residuals else ("nominal", "calibrated")
    where = "held-out" if after == "held_out" else "fitted"
    if status == "not_identifiable":
        return "Not identifiable: these measurements do not determine all parameters asked for; see the warnings."
    if status == "not_converged":
        return "Not converged: the parameters are where the fit was broken off; see the warnings."
    nominal, calibrated = residuals[before], residuals[after]
    if not calibrated.n:
        return f"Calibrated: {identified} parameters identified."
    return (
        f"Calibrated: {1e3 * calibrated.mean:.3g} mm mean and {1e3 * calibrated.max:.3g} mm at most on {calibrated.n} "
        f"{where} rows, from {1e3 * nominal.mean:.3g} mm; {identified} parameters identified."
    )


def warnings_on(
    robot: Robot,
    data: Measurements,
    parameters: Sequence[IdentifiedParameter],
    gauge: Gauge,
    residuals: Mapping[str, Statistics],
    seen: Observability,
    converged: bool,
    coordinates: int,
) -> Iterator[str]:
    """What a user should know and do before trusting a calibration.

    Args:
        coordinates: how many were observed.
    """
    if not converged:
        yield (
            "the fit did not come to rest: check units, joint order and signs of the measurements, "
            "or identify less at once (--identify, --fix)"
        )
    if coordinates < seen.parameters:
        per_row = coordinates / len(data)
        more = int(np.ceil((seen.parameters - coordinates) / per_row))
        yield (
            f"{coordinates} observed coordinates cannot determine {seen.parameters} parameters: measure at least {more} "
            f"more poses (three times as many are better), or identify fewer (--identify, --fix)"
        )
    elif coordinates - seen.parameters < FEW * seen.parameters:
        yield (
            f"only {coordinates - seen.parameters} degrees of freedom for {seen.parameters} parameters: "
            "the residual flatters; measure more poses"
        )
    yield from _unseen(parameters, gauge)
    yield from _compliances(parameters)
    weak = [p.name for p in parameters if p.std is not None and p.std * gauge.effects[p.name] > WEAK]
    if weak and seen.rank == seen.parameters:
        yield (
            f"weakly determined, to no better than {1e3 * WEAK:g} mm at the target: {_listed(weak)}; "
            "measure poses that move the joints next to them further, or fix them (--fix)"
        )
    for row, span in zip(robot.joints, np.ptp(data.q, axis=0), strict=False):
        if row.joint == "revolute" and span < NARROW:
            yield (
                f"joint {row.name} moved over {np.degrees(span):.3g} deg only: what it carries and what carries it "
                "cannot be told apart; spread it over its range"
            )
    for before, after, where in (("nominal", "calibrated", "fitted"), ("held_out_nominal", "held_out", "held-out")):
        if after in residuals and residuals[after].n and residuals[after].mean >= residuals[before].mean > 0.0:
            yield (
                f"the calibrated robot is no better than the nominal one on the {where} rows: identify fewer parameters, "
                "measure more poses, or check that both data sets are of one robot in one state"
            )


def _unseen(parameters: Sequence[IdentifiedParameter], gauge: Gauge) -> Iterator[str]:
    weak = [p.name for p in parameters if p.verdict == "unobservable" and p.name in gauge.kept]
    if weak:
        yield (
            f"the measured poses do not tell {_listed(weak)}: spread the joints over their ranges, measure more poses, "
            "or leave them out (--fix)"
        )


def _compliances(parameters: Sequence[IdentifiedParameter]) -> Iterator[str]:
    for p in parameters:
        if not p.unit.startswith(("rad/", "m/")) or p.verdict == "fixed":
            continue
        if p.verdict in ("unobservable", "dependent") and p.reason:
            yield f"compliance {p.name} is {p.verdict}: {p.reason}; leave it out of --elastic"
        elif p.verdict == "insignificant":
            yield (
                f"compliance {p.name} is zero within its uncertainty ({p.identified:.2g} ± {p.std:.2g} {p.unit}): "
                "leave it out, or measure with more payload"
            )
        elif p.identified < 0.0:
            yield (
                f"compliance {p.name} is negative ({p.identified:.2g} ± {p.std:.2g} {p.unit}), which no joint is: "
                "check masses, centres of mass and gravity, and whether another joint's compliance is missing"
            )


def notes_on(robot: Robot, data: Measurements, gauge: Gauge, elastic: bool, held_out: bool) -> Iterator[str]:
    """What the data cannot say, however good they are."""
    points = data.rotation is None and (data.target is None or len(data.target.names) <= 1)
    if points:
        yield (
            "a single measured point calibrates that point: the orientation of the tool and the last joint's offset stay "
            "unknown; measure three points of the tool, or its orientation, to correct another point"
        )
    if elastic:
        yield (
            "compliances are relative to the masses in the robot file: masses 10 % too high give compliances "
            "10 % too low, and the same deflections"
        )
    if not held_out:
        yield "the residual of the fit is not the accuracy of the robot: hold rows out (--holdout 0.3) to see that"
    dependent = sum(dropped.verdict == "dependent" for dropped in gauge.dropped.values())
    if dependent:
        yield f"{dependent} parameters keep their nominal values because identified ones move the target just as they do"


def _listed(names: Sequence[str], most: int = 6) -> str:
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")
