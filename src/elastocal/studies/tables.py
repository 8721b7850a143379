"""A study's summary as a table and as JSON, SI units."""

from __future__ import annotations

from importlib.metadata import version
from typing import Any

from elastocal.io.results import dump
from elastocal.studies.summary import CellSummary, StudySummary


def study_table(summary: StudySummary) -> list[dict[str, Any]]:
    """A row for each point of the grid."""
    return [_row(cell) for cell in summary.cells]


def _row(cell: CellSummary) -> dict[str, Any]:
    row: dict[str, Any] = {**vars(cell.setting)}
    row |= {key: value for key, value in vars(cell).items() if isinstance(value, (int, float))}
    if cell.coverage is not None:
        row |= {
            "coverage": cell.coverage.pooled.value,
            "coverage_least": cell.coverage.least[1],
            "coverage_least_parameter": cell.coverage.least[0],
            "coverage_most": cell.coverage.most[1],
            "position_ratio": cell.coverage.position,
            "chi2_true": cell.coverage.chi2,
        }
    if cell.right is not None:
        low, high = cell.right.interval
        row |= {"right": cell.right.value, "right_low": low, "right_high": high}
    if cell.torques is not None:
        row |= {"torque_error": cell.torques.error, "torque_score": cell.torques.score}
        row["same_sides"] = cell.torques.same_sides.value
    if cell.outliers is not None:
        row["outliers_named"] = cell.outliers.value
    return row


def study_json(summary: StudySummary) -> str:
    """A study's summary as JSON."""
    return dump(
        {
            "format": "elastocal-study-summary/1",
            "name": summary.study.name,
            "repeats": summary.study.repeats,
            "calibrations": summary.count,
            "converged": summary.sound,
            "varied": list(summary.study.varied),
            "cells": study_table(summary),
            "version": version("elastocal"),
        }
    )
