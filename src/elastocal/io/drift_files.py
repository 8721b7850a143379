"""What changed between two calibrations, as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import version
from typing import Any

from elastocal.drift import Change, Difference
from elastocal.io.results import dump


def difference_json(found: Difference) -> str:
    """Two calibrations side by side as JSON, SI units; scores are changes in units of their standard deviations."""
    return dump(
        {
            "format": "elastocal-difference/1",
            "robot": found.robot,
            "verdict": found.verdict,
            "drift": found.drift,
            "probability": found.probability,
            "chi2": found.chi2,
            "tested": found.tested,
            "parameters": _table(found.changes),
            "frames": _table(found.frames),
            "only_before": list(found.only_before),
            "only_after": list(found.only_after),
            "flange": {"rms": found.position[0], "max": found.position[1], "noise": found.noise},
            "warnings": list(found.warnings),
            "version": version("elastocal"),
        }
    )


def _table(changes: Sequence[Change]) -> list[dict[str, Any]]:
    keys = ("name", "unit", "before", "after", "change", "std", "score")
    return [{key: getattr(change, key) for key in keys} for change in changes]
