"""Sections on a compensation: how far off the robot was, and how far its commands had to be moved."""

from __future__ import annotations

from elastocal.compensation import Summary, verdict
from elastocal.report.section import Section
from elastocal.report.sections import advice_sections

ROWS = (
    ("error before", "error_before", "angle_before"),
    ("error after", "error_after", "angle_after"),
    ("correction", "correction", "correction_angle"),
)


def compensation_sections(summary: Summary) -> list[Section]:
    """All sections on a compensation."""
    header = ["over the targets reached", "mean [mm]", "max [mm]"]
    oriented = summary.figures["correction_angle"].n > 0
    if oriented:
        header += ["mean [mrad]", "max [mrad]"]
    rows = []
    for label, length, angle in ROWS:
        spreads = [summary.figures[name] for name in ((length, angle) if oriented else (length,))]
        rows.append((label, *(f"{1e3 * value:.4f}" for spread in spreads for value in (spread.mean, spread.max))))
    told = (verdict(summary), MEANING) if summary.reached else (verdict(summary),)
    title = f"{summary.robot}: {summary.reached} of {summary.targets} targets reached"
    sections = [Section(title, tuple(header), tuple(rows) if summary.reached else (), told)]
    if summary.missed:
        sections.append(_missed(summary))
    return sections + advice_sections(summary.warnings)


MEANING = "Errors are the model's. What it leaves unexplained, the real robot keeps: see `elastocal validate`."


def _missed(summary: Summary) -> Section:
    """The first targets that are not reached."""
    sentences = [f"Target {number}: {note}." for number, note in summary.missed]
    more = summary.targets - summary.reached - len(summary.missed)
    if more:
        sentences.append(f"And {more} more; the column `note` says why.")
    return Section("Not reached", sentences=tuple(sentences))
