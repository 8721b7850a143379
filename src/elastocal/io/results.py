"""Results out: result.json, residuals.csv and the identified robot."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from importlib.metadata import version
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from elastocal.comparison import Comparison
from elastocal.errors import InputError
from elastocal.identification import (
    CalibrationResult,
    IdentifiedElement,
    Outlier,
    PriorFit,
    Residuals,
    Search,
    Statistics,
)
from elastocal.io.files import require_writable, write_files
from elastocal.io.robot_toml import robot_to_toml
from elastocal.measurements import Measurements
from elastocal.repeatability import Repeatability
from elastocal.validation import ValidationResult

FORMAT = "elastocal-result/1"

RESULT_FILES = ("robot.toml", "result.json", "residuals.csv")
"""What a calibration writes into its folder."""


def save_result(
    result: CalibrationResult, folder: str | Path, data_sha256: Sequence[str] = (), inputs: Sequence[Path] = ()
) -> tuple[str, ...]:
    """Write robot.toml, result.json and residuals.csv into a folder, all or none.

    Args:
        result: of a calibration.
        folder: made if it is not there.
        data_sha256: hashes of the data files.
        inputs: files that must not be overwritten.

    Returns:
        The names of the files.

    Raises:
        InputError: a file would overwrite an input or another robot, or the folder cannot be written to.
    """
    folder = Path(folder)
    require_result_folder(folder, inputs)
    head = f"# {' '.join(result.robot.name.split())}, identified by elastocal {version('elastocal')}; SI units.\n"
    contents = (
        head + robot_to_toml(result.robot),
        result_json(result, data_sha256) + "\n",
        residuals_csv(result),
    )
    write_files(folder, dict(zip(RESULT_FILES, contents, strict=True)), inputs)
    return RESULT_FILES


def require_result_folder(folder: Path, inputs: Iterable[Path] = ()) -> None:
    """Check that results can be written into a folder, before the work that leads to them.

    Raises:
        InputError: it is a file or cannot be written to, or a result would overwrite an input or another robot.
    """
    require_writable(folder, RESULT_FILES, inputs)
    if (folder / "robot.toml").exists() and not (folder / "result.json").exists():
        raise InputError(f"{folder / 'robot.toml'} is not the result of a calibration: choose another folder (-o DIR)")


def result_json(result: CalibrationResult, data_sha256: Sequence[str] = ()) -> str:
    """The result object as JSON, SI units; what is not a finite number is null."""
    seen = result.observability
    return dump(
        {
            "format": FORMAT,
            "robot": result.robot.name,
            "status": result.status,
            "verdict": result.verdict,
            "parameters": [
                {
                    "name": p.name,
                    "unit": p.unit,
                    "nominal": p.nominal,
                    "identified": p.identified,
                    "std": p.std,
                    "verdict": p.verdict,
                    "reason": p.reason,
                    "interval": None if p.interval is None else list(p.interval),
                    "data_share": p.data_share,
                }
                for p in result.parameters
            ],
            "elastic": [
                {
                    "element": e.element,
                    "law": e.law,
                    "transition_torque": e.transition_torque,
                    "coefficients": list(e.coefficients),
                    "std": list(e.std),
                    "verdict": e.verdict,
                    **transition_table(e),
                }
                for e in result.elastic
            ],
            "residuals": {name: statistics_table(found) for name, found in result.residuals.items()},
            "observability": {
                "rank": seen.rank,
                "parameters": seen.parameters,
                "condition": seen.condition,
                **{f"O{i}": getattr(seen, f"O{i}") for i in range(1, 6)},
            },
            "search": None if result.search is None else search_table(result.search),
            "transmission": None if result.prior is None or not result.prior.orders else maps_table(result.prior),
            "tolerance": {} if result.prior is None else result.prior.tolerances,
            "model_sigma": dict(result.model_sigma),
            "chi2_reduced": result.chi2_reduced,
            "covariance": {"names": list(result.names), "matrix": result.covariance.tolist()},
            "correlated": [list(group) for group in result.correlated],
            "freedom": result.freedom,
            "bootstrap": result.bootstrap,
            "outliers": [outlier_table(outlier) for outlier in result.outliers],
            "warnings": list(result.warnings),
            "notes": list(result.notes),
            "iterations": result.iterations,
            "seconds": result.seconds,
            "settings": dict(result.settings),
            "data_sha256": list(data_sha256),
            "version": version("elastocal"),
        }
    )


def transition_table(element: IdentifiedElement) -> dict[str, Any]:
    """Beside a transition torque: its standard deviation, the gap of loads it lies in, and the loads on each side."""
    if element.transition is None:
        return {}
    return {
        "transition_std": element.transition_std,
        "transition_gap": list(element.transition.gap),
        "loads": {"below": element.transition.below, "above": element.transition.above},
    }


def maps_table(maps: PriorFit) -> dict[str, Any]:
    """How joint maps were found: orders, the standard deviation in each band, evidence beside no maps."""
    return {
        "orders": maps.orders,
        "bands": [{"first": band.first, "last": band.last, "std": band.std} for band in maps.bands],
        "log_evidence": {str(orders): value for orders, value in maps.log_evidence.items()},
    }


def outlier_table(outlier: Outlier) -> dict[str, Any]:
    """A row that does not fit the others; residual in m or rad."""
    return {
        "file": outlier.file,
        "row": outlier.row,
        "kind": outlier.kind,
        "residual": outlier.residual,
        "score": outlier.score,
        "rejected": outlier.rejected,
        "hint": outlier.hint,
    }


def search_table(search: Search) -> dict[str, Any]:
    """How transition torques were found; fitness is relative to that of linear laws."""
    return {
        "method": search.method,
        "proven": search.proven,
        "fits": search.fits,
        "best_fitness": list(search.history),
        "seconds": search.seconds,
    }


def validation_json(result: ValidationResult, data_sha256: Sequence[str] = ()) -> str:
    """The outcome of a validation as JSON, SI units."""
    return dump(
        {
            "format": "elastocal-validation/1",
            "robot": result.robot.name,
            "verdict": result.verdict,
            "residuals": {"held_out": statistics_table(result.statistics)},
            "parts": {name: statistics_table(found) for name, found in result.parts.items()},
            "fitted_frames": list(result.fitted_frames),
            "repeatability": {kind: repeatability_table(found) for kind, found in result.repeatability.items()},
            "warnings": list(result.warnings),
            "data_sha256": list(data_sha256),
            "version": version("elastocal"),
        }
    )


def comparison_json(result: Comparison, data_sha256: Sequence[str] = ()) -> str:
    """Models side by side as JSON, SI units."""
    return dump(
        {
            "format": "elastocal-comparison/1",
            "robot": result.robot,
            "elastic": list(result.elements),
            "verdict": result.verdict,
            "recommended": result.recommended,
            "models": [
                {
                    "model": m.name,
                    "status": m.status,
                    "parameters": m.parameters,
                    "coordinates": m.coordinates,
                    "residual": None if m.residual is None else statistics_table(m.residual),
                    "cross_validated": None if m.cross_validated is None else statistics_table(m.cross_validated),
                    "deviance": m.deviance,
                    "aicc": m.aicc,
                    "bic": m.bic,
                    "criterion": m.criterion,
                }
                for m in result.models
            ],
            "warnings": list(result.warnings),
            "data_sha256": list(data_sha256),
            "version": version("elastocal"),
        }
    )


def statistics_table(found: Statistics) -> dict[str, Any]:
    """Statistics [m], with "angle" [rad] where there are any."""
    table: dict[str, Any] = {key: getattr(found, key) for key in ("n", "mean", "max", "rms", "std")}
    return table if found.angle is None else table | {"angle": statistics_table(found.angle)}


def repeatability_table(found: Repeatability) -> dict[str, Any]:
    """Pose accuracy and repeatability of repeated poses [m or rad]."""
    spread = found.repeatability or (None, None)
    return {
        "poses": found.poses,
        "repeats": {"fewest": found.repeats[0], "most": found.repeats[1]},
        "AP": {"mean": found.accuracy[0], "max": found.accuracy[1]},
        "RP": {"poses": found.judged, "mean": spread[0], "max": spread[1]},
    }


def dump(value: Mapping[str, Any]) -> str:
    """A JSON object; what is not a finite number is null."""
    return json.dumps(_finite(value), indent=1, ensure_ascii=False, allow_nan=False)


def _finite(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def save_residuals(result: ValidationResult, path: Path, inputs: Iterable[Path] = ()) -> None:
    """Write every row's residuals of a validation as CSV.

    Raises:
        InputError: the file would overwrite an input, or cannot be written.
    """
    columns = places_of(result.data) | _errors(result.residuals, "")
    write_files(path.parent, {path.name: csv_bytes(columns)}, inputs)


def residuals_csv(result: CalibrationResult) -> bytes:
    """Every row's residuals (measured - predicted), nominal and calibrated, in the instrument's frame."""
    errors = result.errors
    columns = places_of(errors.data)
    columns["set"] = np.where(errors.held_out, "held_out", "fitted").tolist()
    columns["outlier"] = np.isin(np.arange(len(errors.data)), [outlier.index for outlier in result.outliers])
    columns |= _errors(errors.nominal, "nominal_") | _errors(errors.calibrated, "calibrated_")
    return csv_bytes(columns)


def _errors(found: Residuals, prefix: str) -> dict[str, Any]:
    columns: dict[str, Any] = {}
    if found.position is not None:
        columns |= {f"{prefix}d{axis} [mm]": 1e3 * d for axis, d in zip("xyz", found.position.T, strict=True)}
    columns[f"{prefix}error [mm]"] = 1e3 * found.norms
    if found.angles is not None:
        columns[f"{prefix}angle [mrad]"] = 1e3 * found.angles
    return columns


def places_of(data: Measurements) -> dict[str, Any]:
    """Where each row comes from, and its joint positions (rad or m)."""
    columns: dict[str, Any] = {}
    if data.source is not None:
        columns["file"] = [data.source.name(int(code)) for code in data.source.codes]
    columns["row"] = np.arange(1, len(data) + 1) if data.row is None else data.row
    for name, labels in (("station", data.station), ("target", data.target), ("load", data.load)):
        if labels is not None:
            columns[name] = [labels.name(int(code)) for code in labels.codes]
    return columns | {f"q{i + 1}": values for i, values in enumerate(data.q.T)}


def csv_bytes(columns: Mapping[str, Any]) -> bytes:
    """Columns as a CSV file."""
    buffer = BytesIO()
    pl.DataFrame(dict(columns)).fill_nan(None).write_csv(buffer, float_precision=9)
    return buffer.getvalue()
