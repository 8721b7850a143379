"""Uncertainty of predicted positions: as a table, and as JSON."""

from __future__ import annotations

from collections.abc import Iterable
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from elastocal.io.files import write_files
from elastocal.io.results import csv_bytes, dump, places_of
from elastocal.robot import Robot
from elastocal.uncertainty import Uncertainty


def save_uncertainty(found: Uncertainty, path: Path, inputs: Iterable[Path] = ()) -> None:
    """Write the predicted position of every pose and its standard deviations as CSV.

    Raises:
        InputError: the file would overwrite an input, or cannot be written.
    """
    columns = places_of(found.data)
    columns |= {f"{axis} [mm]": 1e3 * values for axis, values in zip("xyz", found.position.T, strict=True)}
    along = np.sqrt(np.diagonal(found.covariance, axis1=1, axis2=2)).T
    columns |= {f"std_parameters_{axis} [mm]": 1e3 * values for axis, values in zip("xyz", along, strict=True)}
    columns["std_parameters [mm]"] = 1e3 * found.from_parameters
    columns["std_model [mm]"] = np.full(len(found.data), 1e3 * found.from_model)
    columns["std [mm]"] = 1e3 * found.total
    write_files(path.parent, {path.name: csv_bytes(columns)}, inputs)


def uncertainty_json(robot: Robot, found: Uncertainty) -> str:
    """What an uncertainty map comes to, as JSON, SI units."""
    worst = int(np.argmax(found.from_parameters))
    return dump(
        {
            "format": "elastocal-uncertainty/1",
            "robot": robot.name,
            "poses": len(found.data),
            "std": {
                "parameters": _spread(found.from_parameters),
                "model": found.from_model,
                "total": _spread(found.total),
            },
            "measured_ratio": found.measured_ratio,
            "worst": {"q": found.data.q[worst].tolist(), "position": found.position[worst].tolist()},
            "version": version("elastocal"),
        }
    )


def _spread(values: np.ndarray[Any, np.dtype[np.float64]]) -> dict[str, float]:
    return {
        "median": float(np.median(values)),
        "p95": float(np.quantile(values, 0.95)),
        "max": float(values.max()),
        "rms": float(np.sqrt((values**2).mean())),
    }
