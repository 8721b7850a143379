"""Sections on a fleet: accuracy, failed rows, robots unlike their siblings, compliance, drift."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from elastocal.figures.fleet import compliance_panels, drift_panels, error_panels, score_panels
from elastocal.fleet import Drift, FleetOutcome, FleetSummary, Siblings, accuracy
from elastocal.fleet.siblings import FEWEST, LEVEL
from elastocal.identification import Statistics
from elastocal.report.section import Section
from elastocal.report.sections import DISPLAY, with_deviation

MOST = 20
"""Rows of a table on a terminal."""

JUDGED = {"held_out": "held-out", "cross_validated": "expected", "calibrated": "fitted"}

Judged = tuple[FleetOutcome, str, Statistics | None, Statistics]


def fleet_sections(summary: FleetSummary, most: int | None = MOST) -> list[Section]:
    """All sections on a fleet.

    Args:
        summary: of the fleet.
        most: rows of a table; None: all.
    """
    sections = [accuracy_section(summary, most)]
    if summary.failed:
        sections.append(failed_section(summary, most))
    sections += [section for group in summary.siblings for section in (siblings_section(group, most),) if section]
    sections += [compliance_section(group) for group in summary.siblings if any(_compliances(group))]
    if summary.drifts:
        sections.append(drift_section(summary.drifts, most))
    return sections


def _judged(summary: FleetSummary) -> list[Judged]:
    """Outcomes with errors, the worst first."""
    found = []
    for outcome in summary.outcomes:
        judged, before, after = accuracy(outcome.result) if outcome.result else ("", None, None)
        if after is not None:
            found.append((outcome, judged, before, after))
    return sorted(found, key=lambda one: -one[3].mean)


def accuracy_section(summary: FleetSummary, most: int | None) -> Section:
    """Errors before and after, the worst robots first."""
    found = _judged(summary)
    rows = [
        (
            o.row.serial,
            o.row.date,
            JUDGED[judged],
            str(after.n),
            "" if before is None else f"{1e3 * before.mean:.4f}",
            f"{1e3 * after.mean:.4f}",
            f"{1e3 * after.max:.4f}",
        )
        for o, judged, before, after in found[:most]
    ]
    header = ("serial", "date", "judged by", "rows", "before", "after", "max [mm]")
    title = f"Fleet: {len({o.row.serial for o in summary.outcomes})} robots, {len(summary.outcomes)} calibrations"
    sentences = [_cut(len(found), most, "calibrations, the worst first")]
    if found:
        before = [1e3 * b.mean for _, _, b, _ in found if b is not None]
        after = [1e3 * a.mean for _, _, _, a in found]
        sentences.append(
            f"Mean position error, median of the calibrations: {np.median(before):.3g} mm before, "
            f"{np.median(after):.3g} mm after; worst after {max(after):.3g} mm ({found[0][0].row.serial})."
        )
    told = (*filter(None, sentences), summary.verdict)
    return Section(title, header, tuple(rows), told, panels=tuple(error_panels(summary)), sortable=True)


def _cut(count: int, most: int | None, what: str) -> str:
    """That a table has not all rows."""
    return f"{most} of {count} {what}; all are in summary.html." if most is not None and count > most else ""


def failed_section(summary: FleetSummary, most: int | None) -> Section:
    """Rows without a sound result, and why."""
    sentences = []
    for outcome in summary.failed[:most]:
        result = outcome.result
        reasons = outcome.reason.splitlines() if result is None else [result.verdict]
        more = f" (and {len(reasons) - 1} more)" if len(reasons) > 1 else ""
        status = outcome.status.replace("_", " ")
        sentences.append(
            f"Row {outcome.row.number}, {outcome.row.serial}, {outcome.row.date}: {status}: {reasons[0]}{more}"
        )
    cut = _cut(len(summary.failed), most, "failed rows")
    return Section("Failed", sentences=(*sentences, *filter(None, [cut])))


def siblings_section(group: Siblings, most: int | None) -> Section | None:
    """Robots that differ, in which parameter; None for a robot alone."""
    count = len(group.serials)
    if count < 2:
        return None
    title = f"{group.robot}: {count} siblings"
    if count < FEWEST:
        return Section(title, sentences=(f"Too few to say who differs: expected {FEWEST} or more.",))
    rows = []
    for d in group.deviations[:most]:
        unit, scale = DISPLAY[d.unit]
        value, median = f"{d.value * scale:.6g}", f"{d.median * scale:.6g}"
        rows.append((d.serial, d.parameter, unit, value, median, f"{d.score:+.1f}"))
    rule = (
        "Score: from the siblings' median, in units of their scatter and of the robot's own uncertainty; beyond "
        f"{group.threshold:.1f} a robot differs. Of fleets of alike robots, at most {100 * LEVEL:.0f} % have one that "
        "does."
    )
    sentences = [] if rows else ["None differs from its siblings."]
    cut = _cut(len(group.deviations), most, "differences")
    header = ("differs", "parameter", "unit", "identified", "median", "score")
    told = (*sentences, *filter(None, [cut]), rule)
    return Section(title, header, tuple(rows), told, panels=tuple(score_panels(group)), sortable=True)


def _compliances(group: Siblings) -> Iterator[int]:
    """Columns of compliances."""
    return (i for i, unit in enumerate(group.units) if unit.startswith(("rad/", "m/")))


def compliance_section(group: Siblings) -> Section:
    """Compliance of each element across the fleet."""
    rows = []
    for i in _compliances(group):
        unit, scale = DISPLAY.get(group.units[i], (group.units[i], 1.0))
        values = group.values[:, i] * scale
        low, high = int(np.argmin(values)), int(np.argmax(values))
        median, scatter = with_deviation(float(group.median[i]) * scale, float(group.scatter[i]) * scale)
        own = f"{float(np.median(group.stds[:, i])) * scale:.2g}"
        ends = (f"{values[k]:.3g} ({group.serials[k]})" for k in (low, high))
        rows.append((group.parameters[i], unit, median, scatter, own, *ends))
    header = ("compliance", "unit", "median", "scatter", "std", "least", "most")
    explained = "Scatter: robust standard deviation over the robots; std: of one robot's value, the median."
    columns = list(_compliances(group))
    units = [DISPLAY.get(group.units[i], (group.units[i], 1.0)) for i in columns]
    panels = tuple(compliance_panels(group, columns, units))
    title = f"{group.robot}: compliance of {len(group.serials)} robots"
    return Section(title, header, tuple(rows), (explained,), panels=panels)


def drift_section(drifts: Sequence[Drift], most: int | None) -> Section:
    """Drift of each serial from date to date, the least likely to be noise first."""
    told = [(drift, drift.found) for drift in drifts if drift.found is not None]
    told.sort(key=lambda one: one[1].probability)
    rows = []
    for drift, found in told[:most]:
        largest = max(found.changes, key=lambda change: abs(change.score), default=None)
        name, score = ("", "") if largest is None else (largest.name, f"{largest.score:+.1f}")
        moved, noise = 1e3 * found.position[0], 1e3 * found.noise
        verdict = "drift" if found.drift else "noise"
        rows.append((drift.serial, drift.before, drift.after, verdict, name, score, f"{moved:.4f}", f"{noise:.4f}"))
    header = ("drift", "since", "at", "verdict", "most", "in std", "flange", "noise")
    sentences = [
        _cut(len(told), most, "pairs of dates"),
        "As `elastocal diff` tells it; flange and the noise there: root mean squares in mm.",
    ]
    sentences += [
        f"{drift.serial}, {drift.before} and {drift.after} cannot be compared: {drift.reason.splitlines()[0]}"
        for drift in drifts
        if drift.found is None
    ]
    told_too = tuple(filter(None, sentences))
    return Section("Drift", header, tuple(rows), told_too, panels=tuple(drift_panels(drifts)), sortable=True)
