"""Results of runs as the report's sections."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

from elastocal.drift import difference
from elastocal.errors import ElastocalError
from elastocal.identification import SavedResult
from elastocal.io import load_result
from elastocal.report import Section, difference_sections
from elastocal.report.calibration import report_sections
from elastocal.report.html import sections_html
from elastocal.web.runs import Run

ERRORS = {
    "nominal": "nominal, fitted rows",
    "calibrated": "calibrated, fitted rows",
    "cross_validated": "expected on unseen poses",
    "held_out_nominal": "nominal, held-out rows",
    "held_out": "calibrated, held-out rows",
}


NOT_COMPARED = ("command",)
"""Settings that say nothing more than the others."""


def report_of(run: Run) -> str:
    """The report's sections on a run, as HTML."""
    return _report_of(run.result, (run.result / "result.json").stat().st_mtime_ns)


@lru_cache(maxsize=8)
def _report_of(folder: Path, _written: int) -> str:
    try:
        sections = report_sections(load_result(folder))
    except ElastocalError as error:
        sections = [Section("Report", sentences=(f"It cannot be shown: {error}",))]
    return sections_html(sections)


def compared(runs: Sequence[Run], titles: Sequence[str]) -> list[Section]:
    """Errors, compliances and settings of several results side by side; of two of one robot, what changed."""
    results = [load_result(run.result, rows=False) for run in runs]
    sections = [_errors(results, titles), _compliances(results, titles), _settings(results, titles)]
    if len(results) == 2:
        try:
            sections += difference_sections(difference(*results))
        except ElastocalError as error:
            sections.append(Section("What changed", sentences=(str(error),)))
    return [section for section in sections if section.rows or section.sentences]


def _errors(results: Sequence[SavedResult], titles: Sequence[str]) -> Section:
    rows = []
    for kind, label in ERRORS.items():
        found = [result.residuals.get(kind) for result in results]
        if any(found):
            rows.append((label, *("" if s is None else f"{1e3 * s.mean:.4f} / {1e3 * s.max:.2f}" for s in found)))
    return Section("Position error, mean / max [mm]", ("", *titles), tuple(rows))


def _compliances(results: Sequence[SavedResult], titles: Sequence[str]) -> Section:
    """Coefficients of the laws, with standard deviations."""
    cells: dict[str, dict[int, str]] = {}
    for number, result in enumerate(results):
        for p in result.parameters:
            if p.std is not None and p.unit == "rad/(N·m)":
                cells.setdefault(p.name, {})[number] = f"{1e6 * p.identified:.2f} ± {1e6 * p.std:.2f}"
    rows = [(name, *(found.get(i, "") for i in range(len(results)))) for name, found in cells.items()]
    return Section("Compliance [µrad/(N·m)]", ("", *titles), tuple(rows))


def _settings(results: Sequence[SavedResult], titles: Sequence[str]) -> Section:
    """Settings that are not the same in all results."""
    names = dict.fromkeys(name for result in results for name in result.settings if name not in NOT_COMPARED)
    rows = []
    for name in names:
        told = [_told(result.settings.get(name)) for result in results]
        if len(set(told)) > 1:
            rows.append((name.replace("_", " "), *told))
    rows.append(("identified parameters", *(str(len(result.names)) for result in results)))
    return Section("Settings that differ", ("", *titles), tuple(rows))


def _told(value: object) -> str:
    if value in (None, [], {}, False):
        return "none"
    if isinstance(value, dict):
        return ", ".join(f"{key} {item}" for key, item in value.items())
    return ", ".join(map(str, value)) if isinstance(value, list) else str(value)
