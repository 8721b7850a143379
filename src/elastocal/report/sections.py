"""Sections of a report: pure functions from a result to text and tables, rendered elsewhere."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from elastocal.comparison import Comparison
from elastocal.identification import AnyResult, IdentifiedElement, IdentifiedParameter, Statistics
from elastocal.repeatability import FEWEST, Repeatability
from elastocal.report.maps import maps_section
from elastocal.report.section import Section
from elastocal.validation import ValidationResult

LABELS = {
    "nominal": "nominal, fitted",
    "calibrated": "calibrated, fitted",
    "cross_validated": "expected, unseen poses",
    "held_out_nominal": "nominal, held-out",
    "held_out": "calibrated, held-out",
}

DISPLAY = {
    "m": ("mm", 1e3),
    "rad": ("deg", 180.0 / math.pi),
    "rad/(N·m)": ("µrad/(N·m)", 1e6),
    "rad/(N·m)^3": ("prad/(N·m)³", 1e12),
    "m/N": ("µm/N", 1e6),
    "m/N^3": ("pm/N³", 1e12),
    "N·m": ("N·m", 1.0),
    "N": ("N", 1.0),
}
"""Units that people read, and their factors from SI."""

STIFFNESS = {"rad/(N·m)": ("kN·m/rad", 1e-3), "m/N": ("N/µm", 1e-6)}
"""Units of the inverse of a compliance, and their factors from SI."""


def error_section(title: str, found: Mapping[str, Statistics], verdict: str) -> Section:
    """Errors by name: rows, mean, max, rms in mm, and the mean angle where orientations were measured."""
    angles = any(statistics.angle for statistics in found.values())
    header = ("position error", "rows", "mean [mm]", "max [mm]", "rms [mm]") + (("angle [mrad]",) if angles else ())
    rows = []
    for name, s in found.items():
        row = (LABELS.get(name, name), str(s.n), *(_fixed(1e3 * value, 4) for value in (s.mean, s.max, s.rms)))
        rows.append(row + ((_fixed(1e3 * s.angle.mean, 3) if s.angle else "",) if angles else ()))
    return Section(title, header, tuple(rows), (verdict,))


def outlier_section(result: AnyResult, most: int = 10) -> Section:
    """Rows that do not fit the others, the worst first."""
    rows = []
    for o in result.outliers[:most]:
        unit = "mrad" if o.kind == "orientation" else "mm"
        became = "left out" if o.rejected else "fitted"
        rows.append((o.file or "data", str(o.row), o.kind, f"{1e3 * o.residual:.3g} {unit}", f"{o.score:.3g}", became))
    header = ("outliers", "row", "observation", "off by", "score", "")
    more = len(result.outliers) - most
    sentences = [f"{more} more are in result.json and residuals.csv (-o DIR)."] if more > 0 else []
    explained = "Off by: from the fit of the other rows; score: root of F, about 1 for a good row."
    return Section("Outliers", header, tuple(rows), (*sentences, explained))


def parameter_section(result: AnyResult) -> Section:
    """What was identified, with standard deviations; what was not, counted."""
    maps = {f"{e}.{key}" for e, found in result.robot.transmission.items() for key in found.coefficients}
    shown = [p for p in result.parameters if p.std is not None and not _elastic(p) and p.name not in maps]
    rows = []
    for p in shown:
        unit, scale = DISPLAY[p.unit]
        nominal = "" if p.nominal is None else f"{p.nominal * scale:.6g}"
        value, spread = with_deviation(p.identified * scale, (p.std or 0.0) * scale)
        rows.append((p.name, unit, nominal, value, spread, p.verdict))
    return Section(
        "Identified parameters",
        ("parameter", "unit", "nominal", "identified", "±", "verdict"),
        tuple(rows),
        tuple(_not_identified(result.parameters)),
    )


def _elastic(p: IdentifiedParameter) -> bool:
    """Whether it belongs to a law of compliance."""
    return p.unit.startswith(("rad/", "m/", "N"))


def _not_identified(parameters: Sequence[IdentifiedParameter]) -> list[str]:
    counted = []
    for verdict in ("dependent", "unobservable", "fixed"):
        names = [p.name for p in parameters if p.verdict == verdict]
        if names:
            listed = ", ".join(names[:8]) + (f" and {len(names) - 8} more" if len(names) > 8 else "")
            counted.append(f"{len(names)} {verdict}: {listed}")
    return counted


def elastic_section(result: AnyResult) -> Section:
    """Compliance and stiffness of each elastic element, and how its transition torque was found."""
    rows = [row for element in result.elastic for row in _elastic_rows(element, result)]
    header = ("compliance", "unit", "identified", "±", "stiffness", "verdict")
    return Section("Compliance", header, tuple(rows), (*_torque_intervals(result), *_how_found(result)))


def _torque_intervals(result: AnyResult) -> Iterator[str]:
    """Where transition torques lie with 95 % confidence, which their standard deviations do not tell."""
    for p in result.parameters:
        if p.name.endswith(".transition_torque") and p.interval is not None:
            low, high = p.interval
            reach = f"between {low:.4g} and {high:.4g}" if math.isfinite(high) else f"above {low:.4g}"
            yield f"{p.name.replace('.transition_torque', ' torque')}: {reach} {p.unit} with 95 % confidence."


def _how_found(result: AnyResult) -> list[str]:
    """How transition torques were found."""
    search = result.search
    if search is None or search.method == "given":
        return []
    if search.method == "exact":
        compared = "all combinations compared" if search.proven else "best found by exchange"
        return [f"Transition torques: exact search, {compared}."]
    return [f"Transition torques: genetic algorithm, {search.fits} fits in {len(search.history)} generations."]


def _elastic_rows(element: IdentifiedElement, result: AnyResult) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = []
    for p in result.parameters:
        if p.name.rpartition(".")[0] != element.element or not _elastic(p):
            continue
        unit, scale = DISPLAY.get(p.unit, (p.unit, 1.0))
        value, spread = (
            (f"{p.identified * scale:.4g}", "")
            if p.std is None
            else with_deviation(p.identified * scale, p.std * scale)
        )
        told = p.identified != 0.0 and p.verdict in ("identified", "fixed") and p.unit in STIFFNESS
        stiffness = f"{STIFFNESS[p.unit][1] / p.identified:.3g} {STIFFNESS[p.unit][0]}" if told else ""
        name = p.name.replace(".transition_torque", " torque")  # else the column would be too wide
        rows.append((name, unit, value, spread, stiffness, p.verdict))
    return rows


def advice_sections(warnings: Sequence[str], notes: Sequence[str] = ()) -> list[Section]:
    """Warnings with remedies, then what the data cannot say."""
    found = []
    if warnings:
        found.append(Section("Warnings", sentences=tuple(warnings)))
    if notes:
        found.append(Section("Notes", sentences=tuple(notes)))
    return found


def calibration_sections(result: AnyResult) -> list[Section]:
    """All sections on a calibration: verdict first."""
    sections = [
        error_section(f"{result.robot.name}: {result.status.replace('_', ' ')}", result.residuals, result.verdict)
    ]
    if result.outliers:
        sections.append(outlier_section(result))
    sections.append(parameter_section(result))
    if result.elastic:
        sections.append(elastic_section(result))
    if result.maps:
        sections.append(maps_section(result))
    return sections + advice_sections(result.warnings, result.notes)


def validation_sections(result: ValidationResult) -> list[Section]:
    """All sections on a validation."""
    found = {"all rows": result.statistics, **result.parts}
    sections = [error_section(f"{result.robot.name}: validation", found, result.verdict)]
    if result.repeatability:
        sections.append(repeatability_section(result.repeatability))
    return sections + advice_sections(result.warnings)


def repeatability_section(found: Mapping[str, Repeatability]) -> Section:
    """Pose accuracy AP and repeatability RP of repeated poses."""
    rows = []
    for kind, r in found.items():
        unit = "mrad" if kind == "orientation" else "mm"
        fewest, most = r.repeats
        times = f"{fewest}" if fewest == most else f"{fewest}-{most}"
        spread = ("", "") if r.repeatability is None else tuple(_fixed(1e3 * value, 4) for value in r.repeatability)
        accuracy = (_fixed(1e3 * value, 4) for value in r.accuracy)
        rows.append((kind, unit, str(r.poses), times, *accuracy, *spread))
    header = ("repeated poses", "unit", "poses", "times", "AP mean", "AP max", "RP mean", "RP max")
    explained = (
        "After ISO 9283: AP from the predicted pose to the barycentre of its repeats, RP their mean distance from it "
        f"plus three standard deviations, of poses measured {FEWEST} times or more."
    )
    return Section("Accuracy and repeatability", header, tuple(rows), (explained,))


def comparison_sections(result: Comparison) -> list[Section]:
    """Models side by side, and which to believe."""
    rows = []
    for m in result.models:
        errors = (m.residual, m.cross_validated)
        figures = ("" if s is None else _fixed(1e3 * s.mean, 4) for s in errors)
        criteria = (_criterion(value) for value in (m.aicc, m.bic, m.criterion))
        mark = "best" if m.name == result.recommended else "" if m.status == "converged" else m.status
        rows.append((m.name, str(m.parameters), *figures, *criteria, mark.replace("_", " ")))
    header = ("model", "params", "residual", "unseen", "AICc", "BIC", "criterion", "verdict")
    explained = "Mean errors in mm, of fitted poses and of poses left out of the fit; of the criteria, less is better."
    title = f"{result.robot}: models of {', '.join(result.elements)}"
    return [Section(title, header, tuple(rows), (explained, result.verdict)), *advice_sections(result.warnings)]


def _criterion(value: float) -> str:
    """A criterion to one decimal, where there is room for it."""
    return "" if not math.isfinite(value) else _fixed(value, 1 if abs(value) < 1e4 else 0)


def with_deviation(value: float, deviation: float) -> tuple[str, str]:
    """A value and its standard deviation, this one to two digits and the value to the same place."""
    if not (math.isfinite(deviation) and deviation > 0.0):
        return f"{value:.6g}", f"{deviation:.2g}"
    places = max(0, 1 - math.floor(math.log10(deviation)))
    return _fixed(value, places), _fixed(deviation, places)


def _fixed(value: float, places: int) -> str:
    return f"{value:.{places}f}"
