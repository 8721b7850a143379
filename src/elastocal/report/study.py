"""Sections on a study: a row for each point of its grid, and figures."""

from __future__ import annotations

import math

from elastocal.figures.study import study_panels
from elastocal.io.study_files import words
from elastocal.report.section import Section
from elastocal.studies import CellSummary, StudySummary


def study_sections(summary: StudySummary) -> list[Section]:
    """All sections on a study."""
    sections = [_errors(summary)]
    if any(cell.coverage for cell in summary.cells):
        sections.append(_coverage(summary))
    if any(cell.right for cell in summary.cells):
        sections.append(_recommendations(summary))
    if any(cell.torques for cell in summary.cells):
        sections.append(_torques(summary))
    if any(cell.outliers for cell in summary.cells):
        sections.append(_outliers(summary))
    panels = study_panels(summary, words)
    return [*sections, Section("Figures", panels=tuple(panels), page_only=True)]


def _head(summary: StudySummary) -> tuple[str, ...]:
    return tuple(name.replace("_", " ") for name in summary.study.varied)


def _place(summary: StudySummary, cell: CellSummary) -> tuple[str, ...]:
    return words(cell.setting, summary.study.varied)


def _errors(summary: StudySummary) -> Section:
    """Held-out errors."""
    rows = []
    for cell in summary.cells:
        values = (cell.nominal_mean, cell.held_out_mean, cell.held_out_q95, cell.held_out_max)
        figures = (f"{1e3 * value:.4f}" if math.isfinite(value) else "" for value in values)
        rows.append((*_place(summary, cell), f"{cell.sound}/{cell.count}", *figures))
    header = (*_head(summary), "done", "before", "mean", "95 %", "max")
    study = summary.study
    asked = len(study.settings) * study.repeats
    verdict = f"{summary.count} of {asked} calibrations are done"
    if summary.sound < summary.count:
        verdict += f", {summary.count - summary.sound} of which came to no sound result"
    explained = (
        f"Errors in mm at {study.held_out} held-out poses without noise: mean over the calibrations before and after, "
        "their 95 % quantile, and the largest of all poses. Done: converged, of all."
    )
    return Section(f"Study: {study.name}", header, tuple(rows), (explained, verdict + "."))


def _coverage(summary: StudySummary) -> Section:
    """Whether uncertainties are right."""
    rows = []
    for cell in summary.cells:
        found = cell.coverage
        if found is not None:
            pooled, least = f"{100 * found.pooled.value:.1f}", f"{100 * found.least[1]:.1f}"
            chi2 = f"{found.chi2:.3f}" if math.isfinite(found.chi2) else ""
            rows.append((*_place(summary, cell), pooled, least, found.least[0], f"{found.position:.3f}", chi2))
    header = (*_head(summary), "cover", "least", "of", "position", "chi²")
    explained = (
        "95 % intervals that cover the fit to the same poses without noise [%], of all parameters and of the one that "
        "is covered least; position: scatter of predicted positions over what their standard deviations "
        "say; chi²: reduced chi-square with the true noise, mean."
    )
    return Section("Coverage", header, tuple(rows), (explained,))


def _recommendations(summary: StudySummary) -> Section:
    """How often the right law is recommended."""
    rows = []
    for cell in summary.cells:
        if cell.right is not None:
            low, high = (100 * end for end in cell.right.interval)
            share = f"{100 * cell.right.value:.0f}"
            rows.append(
                (*_place(summary, cell), f"{cell.right.count}/{cell.right.of}", share, f"{low:.0f} to {high:.0f}")
            )
    header = (*_head(summary), "right", "[%]", "95 % interval")
    explained = "How often `elastocal compare` recommends the law that the actual robot has."
    return Section("The right law", header, tuple(rows), (explained,))


def _torques(summary: StudySummary) -> Section:
    """How well transition torques are found."""
    rows = []
    for cell in summary.cells:
        found = cell.torques
        if found is not None:
            score = f"{found.score:.2f}" if math.isfinite(found.score) else ""
            sides = f"{found.same_sides.count}/{found.same_sides.of}"
            rows.append((*_place(summary, cell), f"{100 * found.error:.2f}", score, sides))
    header = (*_head(summary), "off [%]", "in std", "same sides")
    explained = (
        "Transition torques: errors, root mean square, in % and in their standard deviations; same sides: all fitted "
        "rows on the side of the torque that they are on in truth."
    )
    return Section("Transition torques", header, tuple(rows), (explained,))


def _outliers(summary: StudySummary) -> Section:
    """How many outliers are found, and how many good rows are taken for some."""
    rows = []
    for cell in summary.cells:
        if cell.outliers is not None:
            good = cell.sound * cell.setting.poses - cell.outliers.of
            named = f"{cell.outliers.count}/{cell.outliers.of}"
            rows.append((*_place(summary, cell), named, f"{cell.accused}/{good}"))
    header = (*_head(summary), "outliers named", "good rows accused")
    return Section("Outliers", header, tuple(rows))
