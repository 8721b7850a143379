"""Sentences on a calibration: the verdict, what to do about what went wrong, and what the data cannot say."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from elastocal.identification.result import CalibrationResult, IdentifiedParameter

NARROW = np.radians(20.0)
"""A revolute joint that moved less than this tells little of what lies before and behind it."""

WEAK = 1e-3
"""A parameter is weakly determined if its standard deviation moves the target by more, rms at generic poses [m]."""

FEW_LOADS = 6
"""A coefficient that rests on fewer different loads may be noise."""

FEW = 0.5
"""Degrees of freedom per parameter below which a residual flatters."""


def with_advice(result: CalibrationResult) -> CalibrationResult:
    """The result with its verdict, warnings and notes."""
    warnings = (*_on_the_fit(result), *_on_parameters(result), *_on_transitions(result), *_on_the_data(result))
    return replace(result, verdict=_verdict(result), warnings=warnings, notes=tuple(_notes(result)))


def _verdict(result: CalibrationResult) -> str:
    if result.status == "not_identifiable":
        return "Not identifiable: these measurements do not determine all parameters asked for; see the warnings."
    if result.status == "not_converged":
        return "Not converged: the parameters are where the fit was broken off; see the warnings."
    held = "held_out" in result.residuals
    before = result.residuals["held_out_nominal" if held else "nominal"]
    after = result.residuals["held_out" if held else "calibrated"]
    identified = f"{len(result.names)} parameters identified."
    found, unit = after, "mm"
    if not after.n and after.angle and before.angle:  # orientations only
        before, found, unit = before.angle, after.angle, "mrad"
    return (
        f"Calibrated: {1e3 * found.mean:.3g} {unit} mean and {1e3 * found.max:.3g} {unit} at most on {found.n} "
        f"{'held-out' if held else 'fitted'} rows, from {1e3 * before.mean:.3g} {unit}; {identified}"
    )


def _on_the_fit(result: CalibrationResult) -> Iterator[str]:
    parameters, coordinates = len(result.gauge.kept), result.coordinates
    if result.status == "not_converged":
        yield (
            "the fit did not come to rest: check units, joint order and signs of the measurements, "
            "or identify less at once (--identify, --fix)"
        )
    if coordinates < parameters:
        rows = int((~result.errors.held_out).sum())
        more = int(np.ceil((parameters - coordinates) * rows / coordinates))
        yield (
            f"{coordinates} observed coordinates cannot determine {parameters} parameters: measure at least {more} "
            "more poses (three times as many are better), or identify fewer (--identify, --fix)"
        )
    elif coordinates - parameters < FEW * parameters:
        yield (
            f"only {coordinates - parameters} degrees of freedom for {parameters} parameters: "
            "the residual flatters; measure more poses"
        )


def _on_parameters(result: CalibrationResult) -> Iterator[str]:
    kept = result.gauge.effects
    unseen = [p.name for p in result.parameters if p.verdict == "unobservable" and p.name in kept]
    if unseen:
        yield (
            f"the measured poses do not tell {_listed(unseen)}: spread the joints over their ranges, "
            "measure more poses, or leave them out (--fix)"
        )
    for parameter in result.parameters:
        if parameter.unit.startswith(("rad/", "m/")):
            yield from _on_compliance(parameter)
    weak = [p.name for p in result.parameters if p.std is not None and p.std * kept.get(p.name, 0.0) > WEAK]
    if weak:
        yield (
            f"weakly determined, to no better than {1e3 * WEAK:g} mm at the target: {_listed(weak)}; "
            "measure poses that move the joints next to them further, or fix them (--fix)"
        )


def _on_compliance(p: IdentifiedParameter) -> Iterator[str]:
    found = f"{p.identified:.2g} ± {p.std or 0.0:.2g} {p.unit}"
    if p.verdict == "insignificant" and p.std is None:
        yield (
            f"compliance {p.name} is held at zero, since it would come out negative: leave it out of --elastic, or "
            "check masses, centres of mass and gravity"
        )
    elif p.verdict in ("unobservable", "dependent"):
        yield f"compliance {p.name} is {p.verdict}: {p.reason}; leave it out of --elastic"
    elif p.verdict == "insignificant":
        yield (
            f"compliance {p.name} is zero within its uncertainty ({found}): leave it out, or measure with more payload"
        )
    elif p.verdict == "identified" and p.identified < 0.0 and "^" not in p.unit:
        yield (
            f"compliance {p.name} is negative ({found}), which no joint is: check masses, centres of mass and gravity, "
            "and whether another joint's compliance is missing"
        )


def _on_transitions(result: CalibrationResult) -> Iterator[str]:
    rows = {p.name: p for p in result.parameters}
    for element in result.elastic:
        data, name = element.transition, element.element
        if data is None or element.transition_torque is None:
            continue
        row = rows[f"{name}.transition_torque"]
        if row.verdict == "insignificant":
            yield (
                f"no transition is seen at {name}: the compliances on the two sides of {element.transition_torque:.3g} "
                f"{row.unit} are the same within their uncertainty; make its law linear, or measure with more payload"
            )
        for key, where, count in (("c_low", "below", data.below), ("c_high", "above", data.above)):
            if count < FEW_LOADS:
                yield (
                    f"{name}.{key} rests on {count} different loads {where} {element.transition_torque:.3g} "
                    f"{row.unit}: measure more poses with such loads"
                )


def _on_the_data(result: CalibrationResult) -> Iterator[str]:
    fitted = result.errors.data.q[~result.errors.held_out]
    for row, span in zip(result.robot.joints, np.ptp(fitted, axis=0), strict=False):
        if row.joint == "revolute" and span < NARROW:
            yield (
                f"joint {row.name} moved over {np.degrees(span):.3g} deg only: what it carries and what carries it "
                "cannot be told apart; spread it over its range"
            )
    for before, after, where in (
        ("nominal", "calibrated", "fitted"),
        ("held_out_nominal", "held_out", "held-out"),
    ):
        found = result.residuals.get(after)
        if found and found.n and found.mean >= result.residuals[before].mean > 0.0:
            yield (
                f"the calibrated robot is no better than the nominal one on the {where} rows: identify fewer "
                "parameters, measure more poses, or check that all data are of one robot in one state"
            )


def _notes(result: CalibrationResult) -> Iterator[str]:
    data, gauge = result.errors.data, result.gauge
    if data.orientation is None and (data.target is None or len(data.target.names) <= 1):
        yield (
            "a single measured point calibrates that point: the orientation of the tool and the last joint's offset "
            "stay unknown; measure three points of the tool, or its orientation, to correct another point"
        )
    if any(element.verdict in ("identified", "insignificant") for element in result.elastic):
        yield (
            "compliances are relative to the masses in the robot file: masses 10 % too high give compliances "
            "10 % too low, and the same deflections"
        )
    for element in result.elastic:
        if element.law == "step" and element.transition is not None:
            low, high = element.transition.gap
            yield (
                f"no measured load on {element.element} lies between {low:.4g} and {high:.4g} "
                f"{_unit(result, element.element)}: which of its two compliances holds in there, these data cannot tell"
            )
    if result.search is not None and result.search.method == "exact" and not result.search.proven:
        yield "the transition torques are the best that were found: not all combinations were compared"
    if not result.errors.held_out.any():
        yield "the residual of the fit is not the accuracy of the robot: hold rows out (--holdout 0.3) to see that"
    dependent = sum(dropped.verdict == "dependent" for dropped in gauge.dropped.values())
    if dependent:
        yield f"{dependent} parameters keep their nominal values: identified ones move the target just as they do"


def _unit(result: CalibrationResult, element: str) -> str:
    return next(p.unit for p in result.parameters if p.name == f"{element}.transition_torque")


def _listed(names: Sequence[str], most: int = 6) -> str:
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")
