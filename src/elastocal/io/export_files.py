"""Exports as files, and what they leave as JSON."""

from __future__ import annotations

from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from elastocal.io.exports import Exported, Residual
from elastocal.io.files import write_files
from elastocal.io.results import dump

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
        "n": len(residual.position),
        **_statistics(residual.position),
        "angle": _statistics(residual.angle),
    }


def _statistics(values: np.ndarray[Any, np.dtype[np.float64]]) -> dict[str, float]:
    return {
        "mean": float(values.mean()),
        "max": float(values.max()),
        "rms": float(np.sqrt((values**2).mean())),
    }
