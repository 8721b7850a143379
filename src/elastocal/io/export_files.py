"""Exports as files, and what they leave as JSON."""

from __future__ import annotations

from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path
from typing import Any

from elastocal.identification import statistics_of
from elastocal.io.exports import Exported, Residual
from elastocal.io.files import write_files
from elastocal.io.results import dump, statistics_table

FORMAT = "elastocal-export/1"


def save_export(exported: Exported, path: Path, inputs: Iterable[Path] = ()) -> None:
    """Write an exported robot.

    Raises:
        InputError: the file would overwrite an input, or cannot be written.
    """
    write_files(path.parent, {path.name: exported.text}, inputs)


def export_json(exported: Exported, path: Path | None) -> str:
    """What an export holds and leaves as JSON, SI units; with its text where it went to no file."""
    return dump(
        {
            "format": FORMAT,
            "robot": exported.robot,
            "to": exported.to,
            "file": None if path is None else str(path),
            **({"text": exported.text} if path is None else {}),
            "cannot_hold": list(exported.cannot_hold),
            "notes": list(exported.notes),
            "residuals": [_residual(residual) for residual in exported.residuals],
            "version": version("elastocal"),
        }
    )


def _residual(residual: Residual) -> dict[str, Any]:
    return {
        "reading": residual.reading,
        "load": residual.load,
        "refitted": residual.refitted,
        **statistics_table(statistics_of(residual.position, statistics_of(residual.angle))),
    }
