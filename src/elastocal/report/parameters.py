"""Sections on parameters: values, deviations, what was not identified, correlations, observability."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from elastocal.figures.parameters import (
    correlation_panels,
    correlations,
    deviation,
    deviation_panels,
    kinds_of,
    singular_panels,
    tolerances_of,
)
from elastocal.identification import AnyResult
from elastocal.report.section import Section, Verdict
from elastocal.report.sections import DISPLAY, parameter_section, with_deviation

STRONG = 0.9
"""Correlations beyond this are named."""

MOST_PAIRS = 20

BEYOND = 3.0
"""A deviation of more tolerances than this is told."""

WELL, POORLY = 100.0, 1000.0
"""Conditions of the Jacobian up to which the poses tell all parameters well, and from which on they hardly do."""


def parameters_section(result: AnyResult) -> Section:
    """All identified parameters with their deviations from nominal, sortable."""
    found = parameter_section(result)
    values = {p.name: p for p in result.parameters}
    rows = []
    for name, unit, nominal, value, spread, verdict in found.rows:
        p = values[name]
        change = ""
        if p.nominal is not None:
            change, _ = with_deviation(deviation(p) * DISPLAY[p.unit][1], (p.std or 0.0) * DISPLAY[p.unit][1])
        share = "" if p.data_share is None else f"{100.0 * p.data_share:.0f}"
        rows.append((name, unit, nominal, value, spread, change, *((share,) if _shared(result) else ()), verdict))
    header = ("parameter", "unit", "nominal", "identified", "±", "deviation")
    header += (*(("told by data [%]",) if _shared(result) else ()), "verdict")
    told = "± is one standard deviation. Choose a column's name to sort by it."
    return replace(found, header=header, rows=tuple(rows), prose=told, sortable=True)


def _shared(result: AnyResult) -> bool:
    maps = {f"{e}.{key}" for e, error in result.robot.transmission.items() for key in error.coefficients}
    return any(p.data_share is not None for p in result.parameters if p.name not in maps)


def deviation_section(result: AnyResult) -> Section:
    """Deviations of geometry from nominal, in units of tolerance where there is one."""
    kinds, tolerances = kinds_of(result), tolerances_of(result)
    far = [
        p.name
        for p in result.parameters
        if tolerances.get(kinds.get(p.name, "")) and abs(deviation(p)) > BEYOND * tolerances[kinds[p.name]]
    ]
    verdict = None
    if far:
        listed = ", ".join(far[:6]) + (f" and {len(far) - 6} more" if len(far) > 6 else "")
        verdict = Verdict("caution", f"More than {BEYOND:g} tolerances from nominal: {listed}.")
    elif tolerances and kinds:
        verdict = Verdict("good", f"All within {BEYOND:g} tolerances of nominal.")
    told = "Identified less nominal; bars are two standard deviations."
    if result.tolerances and not result.robot.tolerance:
        told += " Tolerances are those that the data favour."
    return Section("Deviations from nominal", prose=told, panels=tuple(deviation_panels(result)), verdict=verdict)


def dropped_section(result: AnyResult) -> Section:
    """Parameters that were not identified, and why."""
    rows = tuple(
        (p.name, p.verdict, p.reason) for p in result.parameters if p.std is None and (p.verdict != "fixed" or p.reason)
    )
    told = "These keep their nominal values: identified ones move the target just as they do, or nothing measured does."
    return Section(
        "Not identified", ("parameter", "verdict", "reason"), rows, prose=told if rows else "", sortable=True
    )


def correlation_section(result: AnyResult) -> Section:
    """The correlation matrix, and its strong pairs by name."""
    names, matrix = correlations(result)
    panels = tuple(correlation_panels(result))
    if not panels:
        return Section("Correlations")
    rows, columns = np.tril_indices(len(names), -1)
    values = matrix[rows, columns]
    strong = [i for i in np.argsort(-np.abs(values), kind="stable") if abs(values[i]) >= STRONG]
    table = tuple((names[columns[i]], names[rows[i]], f"{values[i]:+.3f}") for i in strong[:MOST_PAIRS])
    if strong:
        text = (
            f"{len(strong)} pairs are correlated by {STRONG} or more: their values are sure together, not one by one."
        )
        verdict = Verdict("caution", text)
    else:
        verdict = Verdict("good", f"No two parameters are correlated by {STRONG} or more.")
    more = (f"{len(strong) - MOST_PAIRS} more pairs are as strong.",) if len(strong) > MOST_PAIRS else ()
    told = "Errors of parameters that the measured poses do not tell apart go together; other poses would part them."
    return Section(
        "Correlations", ("parameter", "with", "correlation"), table, more, prose=told, verdict=verdict, panels=panels
    )


def observability_section(result: AnyResult) -> Section:
    """Singular values and the observability indices."""
    seen = result.observability
    if seen is None:
        return Section("Observability")
    indices = [
        ("rank", f"{seen.rank} of {seen.parameters}", "directions of the parameters that the poses see"),
        ("condition", f"{seen.condition:.4g}", "largest over smallest singular value"),
        ("O1", f"{seen.O1:.4g}", "Borm and Menq: volume"),
        ("O2", f"{seen.O2:.4g}", "Driels and Pathre: inverse condition"),
        ("O3", f"{seen.O3:.4g}", "Nahvi and Hollerbach: smallest singular value"),
        ("O4", f"{seen.O4:.4g}", "Nahvi and Hollerbach: noise amplification"),
        ("O5", f"{seen.O5:.4g}", "Sun and Hollerbach: inverse of the summed inverses"),
    ]
    strongest = sorted(seen.weakest, key=lambda name: -abs(seen.weakest[name]))[:3]
    weakest = (f"The weakest direction is mostly {', '.join(strongest)}.",) if strongest else ()
    if seen.rank < seen.parameters:
        verdict = Verdict(
            "problem", f"The poses see {seen.rank} of {seen.parameters} directions: the rest is not told."
        )
    elif seen.condition <= WELL:
        verdict = Verdict("good", f"The poses tell all parameters well (condition {seen.condition:.3g}).")
    elif seen.condition <= POORLY:
        verdict = Verdict("caution", f"Some directions are told weakly (condition {seen.condition:.3g}).")
    else:
        verdict = Verdict(
            "caution", f"Some directions are hardly told (condition {seen.condition:.3g}): measure other poses."
        )
    told = "How well the measured poses tell the parameters, each by how far it moves the target at generic poses."
    return Section(
        "Observability",
        ("index", "value", "meaning"),
        tuple(indices),
        weakest,
        prose=told,
        verdict=verdict,
        panels=tuple(singular_panels(result)),
    )
