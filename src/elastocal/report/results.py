"""The report on several calibrations side by side: of different models, or of different dates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from elastocal.drift import difference
from elastocal.errors import ElastocalError, EquilibriumError, InputError
from elastocal.figures.compliance import overlay_panels
from elastocal.figures.errors import cumulative_panel
from elastocal.figures.rows import rows_of
from elastocal.identification import IdentifiedParameter, SavedResult, Statistics
from elastocal.report.section import Section, Verdict
from elastocal.report.sections import DISPLAY, advice_sections, with_deviation

Results = Mapping[str, SavedResult]


def several_sections(results: Results) -> list[Section]:
    """Errors, laws and parameters of several results side by side, and what changed from each to the next.

    Args:
        results: by name, in order.

    Raises:
        InputError: there are fewer than two.
    """
    if len(results) < 2:
        raise InputError(f"expected two results or more to compare, found {len(results)}")
    sections = [_overview(results), _errors(results)]
    sections += [section for section in (_laws(results), _parameters(results)) if section.rows or section.panels]
    for (name, before), (other, after) in pairwise(results.items()):
        sections += _change(name, before, other, after)
    warnings = [f"{name}: {warning}" for name, result in results.items() for warning in result.warnings]
    return [*sections, *advice_sections(warnings)]


def _overview(results: Results) -> Section:
    robots = dict.fromkeys(result.robot.name for result in results.values())
    rows = tuple(
        (
            name,
            result.status.replace("_", " "),
            str(len(result.names)),
            *(_millimetres(result.residuals.get(kind)) for kind in ("calibrated", "cross_validated", "held_out")),
        )
        for name, result in results.items()
    )
    header = ("result", "status", "params", "fitted", "expected", "held-out")
    told = "Mean position errors in mm: of fitted rows, to expect on unseen poses, and of held-out rows."
    several = "" if len(robots) == 1 else f"These are different robots: {', '.join(robots)}."
    models = [f"{name}: {_model(result)}." for name, result in results.items()]
    return Section("Results", header, rows, tuple(filter(None, (told, *models, several))), verdict=_best(results))


def _model(result: SavedResult) -> str:
    """What was modelled beyond geometry."""
    laws = ", ".join(f"{e.element} {e.law}" for e in result.elastic) or "rigid"
    return f"{laws}; joint maps of {result.maps.orders} orders" if result.maps else laws


def _millimetres(found: Statistics | None) -> str:
    return "" if found is None else f"{1e3 * found.mean:.4f}"


def _best(results: Results) -> Verdict | None:
    """Which result predicts held-out rows best, if all were judged by the same number of them."""
    held = {name: result.residuals["held_out"] for name, result in results.items() if "held_out" in result.residuals}
    if len(held) != len(results) or len({found.n for found in held.values()}) != 1:
        return None
    best = min(held, key=lambda name: held[name].mean)
    sound = results[best].status == "converged"
    text = f"{best} has the least mean error on held-out rows, {1e3 * held[best].mean:.3g} mm"
    return Verdict("good" if sound else "caution", f"{text}{'' if sound else ', but did not converge'}.")


def _errors(results: Results) -> Section:
    rows = []
    for name, result in results.items():
        for kind, found in result.residuals.items():
            figures = (f"{1e3 * value:.4f}" for value in (found.mean, found.max, found.rms))
            rows.append((name, kind.replace("_", " "), str(found.n), *figures))
    measured = {name: result for name, result in results.items() if result.errors is not None}
    panels = (cumulative_panel(measured),) if measured else ()
    header = ("result", "errors", "rows", "mean [mm]", "max [mm]", "rms [mm]")
    return Section("Position errors", header, tuple(rows), panels=panels, sortable=True)


def _laws(results: Results) -> Section:
    """The laws of compliance over one another."""
    loads: dict[str, tuple[float, float]] = {}
    for result in results.values():
        for element, (low, high) in _loads(result).items():
            known = loads.get(element, (0.0, 0.0))
            loads[element] = min(known[0], low), max(known[1], high)
    told = "The identified laws over the loads measured, with their 95 % bands."
    return Section("Torque and deflection", prose=told, panels=tuple(overlay_panels(results, loads)))


def _loads(result: SavedResult) -> dict[str, tuple[float, float]]:
    """The least and the largest load of each elastic element."""
    if not result.elastic or result.errors is None:
        return {}
    try:
        loads = rows_of(result).loads
    except EquilibriumError:
        return {}
    named = [e.element for e in result.elastic if e.element in loads and len(loads[e.element])]
    return {name: (float(np.min(loads[name])), float(np.max(loads[name]))) for name in named}


def _parameters(results: Results) -> Section:
    """All parameters that any result identified, with ±."""
    tables = {name: {p.name: p for p in result.parameters} for name, result in results.items()}
    maps = {
        f"{e}.{key}"
        for result in results.values()
        for e, error in result.robot.transmission.items()
        for key in error.coefficients
    }
    named = [p.name for result in results.values() for p in result.parameters if p.std is not None]
    rows = tuple(
        _parameter_row(name, [table.get(name) for table in tables.values()])
        for name in dict.fromkeys(named)
        if name not in maps
    )
    header = ("parameter", "unit", *results, "largest change [std]")
    told = (
        "± is one standard deviation; the last column is the largest change from a result to the next, in units of "
        "both deviations together. Results of the same measurements share their noise: their changes look too small."
    )
    return Section("Parameters", header, rows, prose=told, sortable=True, page_only=True)


def _parameter_row(name: str, found: Sequence[IdentifiedParameter | None]) -> tuple[str, ...]:
    unit, scale = DISPLAY.get(next(p.unit for p in found if p is not None), ("", 1.0))
    sure = [p for p in found if p is not None and p.std]
    scores = [(b.identified - a.identified) / float(np.hypot(a.std or 0.0, b.std or 0.0)) for a, b in pairwise(sure)]
    largest = max(scores, key=abs, default=None)
    change = "" if largest is None else f"{largest:+.1f}"
    return (name, unit, *(_value(p, scale) for p in found), change)


def _value(p: IdentifiedParameter | None, scale: float) -> str:
    if p is None:
        return ""
    if p.std is None:
        return f"{p.identified * scale:.6g}"
    return " ± ".join(with_deviation(p.identified * scale, p.std * scale))


def _change(name: str, before: SavedResult, other: str, after: SavedResult) -> list[Section]:
    """What changed between two results, if they can be compared at all."""
    title = f"From {name} to {other}"
    if before.data_sha256 and before.data_sha256 == after.data_sha256:
        same = "Both were fitted to the same measurements: what differs is the model, and no drift is told."
        return [Section(title, sentences=(same,))]
    try:
        found = difference(before, after)
    except ElastocalError as error:
        return [Section(title, sentences=(f"Not told: {error}.",))]
    return [
        Section(title, sentences=found.warnings, verdict=Verdict("caution" if found.drift else "good", found.verdict))
    ]


def named_results(names: Sequence[str], results: Sequence[SavedResult]) -> dict[str, SavedResult]:
    """Results by short names: the last parts of their folders' paths, as many as tell them apart."""
    parts = [tuple(part for part in name.replace("\\", "/").split("/") if part not in ("", ".")) for name in names]
    for length in range(1, max(map(len, parts), default=1) + 1):
        short = ["/".join(part[-length:]) for part in parts]
        if len(set(short)) == len(short):
            return dict(zip(short, results, strict=True))
    return {f"{name} ({i})": result for i, (name, result) in enumerate(zip(names, results, strict=True), start=1)}
