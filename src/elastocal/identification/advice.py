"""Sentences on a calibration: the verdict, what to do about what went wrong, and what the data cannot say."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from elastocal.identification.outlier_advice import on_outliers
from elastocal.identification.plausibility import BAD, misfit
from elastocal.identification.result import CalibrationResult, IdentifiedParameter
from elastocal.prediction import kind_of

NARROW = np.radians(20.0)
"""A revolute joint that moved less than this tells little of what lies before and behind it."""

WEAK = 1e-3
"""A parameter is weakly determined if its standard deviation moves the target by more, rms at generic poses [m]."""

FEW_LOADS = 6
"""A coefficient that rests on fewer different loads may be noise."""

MOST_GROUPS = 4
"""Groups of correlated parameters that are named."""

FEW = 0.5
"""Degrees of freedom per parameter below which a residual flatters."""


def with_advice(result: CalibrationResult) -> CalibrationResult:
    """The result with its verdict, warnings and notes."""
    warnings = (
        *_on_the_fit(result),
        *on_outliers(result),
        *_on_parameters(result),
        *_on_transitions(result),
        *_on_the_data(result),
    )
    return replace(result, verdict=_verdict(result), warnings=warnings, notes=tuple(_notes(result)))


def _verdict(result: CalibrationResult) -> str:
    if result.status == "not_identifiable":
        return "Not identifiable: these measurements do not determine all parameters asked for; see the warnings."
    if result.status == "not_converged":
        return "Not converged: the parameters are where the fit was broken off; see the warnings."
    found = result.residuals
    kind = next(name for name in JUDGED if name in found)
    before = found["held_out_nominal" if kind == "held_out" else "nominal"]
    after, fitted, unit = found[kind], found["calibrated"], "mm"
    if not after.n and after.angle and before.angle and fitted.angle:  # orientations only
        before, after, fitted, unit = before.angle, after.angle, fitted.angle, "mrad"
    beside = f" (the fit's residual is {1e3 * fitted.mean:.3g} {unit})" if kind == "cross_validated" else ""
    return (
        f"Calibrated: {1e3 * after.mean:.3g} {unit} mean and {1e3 * after.max:.3g} {unit} at most "
        f"{JUDGED[kind].format(after.n)}, from {1e3 * before.mean:.3g} {unit}{beside}; "
        f"{_counted(result)} identified."
    )


def _counted(result: CalibrationResult) -> str:
    """How many parameters were identified, the coefficients of joint maps apart."""
    if result.prior is None or not result.prior.orders:
        return f"{len(result.names)} parameters"
    maps = sum(len(found.coefficients) for found in result.prior.robot.transmission.values())
    return f"{len(result.names) - maps} parameters and joint maps of {result.prior.orders} orders"


JUDGED = {
    "held_out": "on {} held-out rows",
    "cross_validated": "to expect on unseen poses",
    "calibrated": "on {} fitted rows",
}
"""What a calibration is judged by: the first of these statistics that it has."""


def _on_the_fit(result: CalibrationResult) -> Iterator[str]:
    parameters, coordinates = len(result.gauge.kept), result.coordinates
    if result.status == "not_converged":
        yield (
            "the fit did not come to rest: check units, joint order and signs of the measurements, "
            "or identify less at once (--identify, --fix)"
        )
    left = misfit(result.errors.calibrated, result.errors.data, ~result.errors.held_out)
    if left > BAD and coordinates > parameters:
        yield (
            f"robot and data do not belong together: calibrated, the robot still misses a fifth of the rows by more "
            f"than {100.0 * left:.2g} % of the spread of the measured points; check the units, order and signs of the "
            "joints, swapped or mirrored axes, the names of targets and stations, and frames called known"
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
            "the residual flatters; measure more poses, or let tolerances help (--prior)"
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
        if data is None or element.transition_torque is None or element.verdict == "unobservable":
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
                    f"{name}.{key} rests on {count} different load{'' if count == 1 else 's'} {where} "
                    f"{element.transition_torque:.3g} {row.unit}: measure more poses with such loads"
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
        if element.law == "step" and element.transition is not None and element.verdict != "unobservable":
            low, high = (f"{edge:.4g}" for edge in element.transition.gap)
            if not (element.transition.below and element.transition.above) or low == high:
                continue
            yield (
                f"no measured load on {element.element} lies between {low} and {high} "
                f"{_unit(result, element.element)}: which of its two compliances holds in there, these data cannot tell"
            )
    if result.search is not None and result.search.method == "exact" and not result.search.proven:
        yield "the transition torques are the best that were found: not all combinations were compared"
    yield from _on_the_sample(result)
    yield from _on_chi2(result)
    yield from _on_priors(result)
    yield from _on_precision(result)
    dependent = sum(dropped.verdict == "dependent" for dropped in gauge.dropped.values())
    if dependent and not (result.prior and result.prior.tolerances):
        yield f"{dependent} parameters keep their nominal values: identified ones move the target just as they do"


def _on_the_sample(result: CalibrationResult) -> Iterator[str]:
    """What was decided on a sample of the rows."""
    found = result.streamed
    if found is None:
        return
    listed = len(result.outliers)
    outliers = f", and the {listed} worst of {found.outliers} outliers" if found.outliers > listed else ""
    yield (
        f"all {found.rows} rows were fitted, read in {found.parts} parts; where the frames and transition torques lie "
        f"was looked for with a sample of {found.sample} of them, whose residuals are those that are written row by "
        f"row{outliers}"
    )


def _on_chi2(result: CalibrationResult) -> Iterator[str]:
    """What the model leaves unexplained, and what reduced chi-square says of it."""
    data = result.errors.data
    stated = data.sigma is not None or data.sigma_angle is not None
    several = {c for c in result.model_sigma if " " in c}
    units = {"position": "mm per axis", "orientation": "mrad per axis", "distance": "mm"}
    shown = {c: s for c, s in result.model_sigma.items() if c in several or not several}
    told = ", ".join(f"{1e3 * s:.2g} {units[kind_of(c)]} of the {c}" for c, s in shown.items())
    if not told or result.freedom < 1.0:
        return
    beyond = "beyond the stated standard deviations" if stated else "the instrument's noise included"
    yield (
        f"what the model leaves unexplained, {beyond}, is estimated to be {told}; with that the residuals are as large "
        f"as they should be (reduced χ² {result.chi2_reduced:.2f})"
    )


def _on_priors(result: CalibrationResult) -> Iterator[str]:
    if result.prior is None or not result.prior.tolerances:
        return
    units = {"length": ("mm", 1e3), "angle": ("mrad", 1e3), "offset": ("mrad", 1e3)}
    units |= {"compliance": ("µrad/(N·m)", 1e6), "linear compliance": ("µm/N", 1e6)}
    found = result.prior.tolerances.items()
    told = ", ".join(f"{kind} {units[kind][1] * std:.2g} {units[kind][0]}" for kind, std in found)
    yield f"all geometry was identified about its nominal values, with the tolerances {told} (standard deviations)"
    carried = [p.name for p in result.parameters if p.data_share is not None and p.data_share < 0.5]
    geometry = [name for name in carried if name in result.gauge.kept or name in result.gauge.dropped]
    if geometry:
        yield f"of {_listed(geometry)} the tolerance says more than the data"


def _on_precision(result: CalibrationResult) -> Iterator[str]:
    if "cross_validated" in result.residuals:
        yield (
            "what to expect on unseen poses is found by leaving each pose out of the fit in turn; it holds for poses "
            "like the measured ones: hold rows out (--held-out) to see others"
        )
    elif not result.errors.held_out.any():
        yield "the residual of the fit is not the accuracy of the robot: hold rows out (--holdout 0.3) to see that"
    if result.bootstrap is not None:
        failed = result.bootstrap["failed"]
        lost = f" ({failed} came to no rest)" if failed else ""
        yield (
            f"standard deviations and intervals are those of a bootstrap of {result.bootstrap['fits']} fits{lost}, not "
            "the linear ones"
        )
    elif result.settings.get("bootstrap"):
        yield "the bootstrap tells nothing, since hardly any fit came to rest: standard deviations are the linear ones"
    if result.correlated:
        groups = [_listed(group, 4) for group in result.correlated]
        yield (
            "parameters that the data tell together only, their errors being correlated by more than 0.95: "
            f"{_listed(groups, MOST_GROUPS, '; ')}; what they predict together is as good as the rest"
        )


def _unit(result: CalibrationResult, element: str) -> str:
    return next(p.unit for p in result.parameters if p.name == f"{element}.transition_torque")


def _listed(names: Sequence[str], most: int = 6, between: str = ", ") -> str:
    return between.join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")
