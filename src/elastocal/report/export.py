"""Sections on an export: what it leaves of the robot, and what it cannot hold."""

from __future__ import annotations

from elastocal.io.exports import Exported, Residual
from elastocal.report.section import Section

HEADER = ("residual of the tool's pose", "mean [mm]", "max [mm]", "mean [mrad]", "max [mrad]")


def export_sections(exported: Exported) -> list[Section]:
    """What a reader of the file has less than the robot, and how far that puts its tool."""
    poses = len(exported.residuals[0].position)
    how = (
        f"Between the robot under its load and the robot that a reader has, at {poses} random poses within the joint "
        "limits, in the base frame. Fitted: base and tool taught anew on the robot."
    )
    sections = [Section(f"{exported.robot} as {exported.to}", HEADER, tuple(map(_row, exported.residuals)), (how,))]
    if exported.cannot_hold:
        sections.append(Section("Cannot hold", sentences=tuple(f"- {text}" for text in exported.cannot_hold)))
    if exported.notes:
        sections.append(Section("Notes", sentences=exported.notes))
    return sections


def _row(residual: Residual) -> tuple[str, ...]:
    name = residual.reading + (f", {residual.load}" if residual.load else "")
    found = (v for values in (residual.position, residual.angle) for v in (values.mean(), values.max()))
    return (f"{name}, fitted" if residual.refitted else name, *(f"{1e3 * value:.4f}" for value in found))
