"""Results out: result.json, residuals.csv and the identified robot."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict
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
    MapFit,
    Observability,
    Outlier,
    SavedResult,
    Search,
    Statistics,
)
from elastocal.io.covariances import covariance_table
from elastocal.io.files import require_writable, write_files
from elastocal.io.residual_files import residual_columns, wrench_columns
from elastocal.io.result_files import saved_result
from elastocal.io.robot_toml import robot_to_toml
from elastocal.measurements import Measurements
from elastocal.repeatability import Repeatability
from elastocal.validation import ValidationResult

FORMAT = "elastocal-result/1"

RESULT_FILES = ("robot.toml", "result.json", "residuals.csv", "report.html")
"""What a calibration writes into its folder, the report last."""

REPORT_FILE = RESULT_FILES[-1]


def save_result(
    result: CalibrationResult,
    folder: str | Path,
    data_sha256: Sequence[str] = (),
    inputs: Sequence[Path] = (),
    report: Callable[[SavedResult], str] | None = None,
) -> tuple[str, ...]:
    """Write robot.toml, result.json, residuals.csv and perhaps a report into a folder, all or none.

    Args:
        result: of a calibration.
        folder: made if it is not there.
        data_sha256: hashes of the data files.
        inputs: files that must not be overwritten.
        report: makes report.html of what is saved. Without it a report of an earlier result there is removed.

    Returns:
        The names of the files.

    Raises:
        InputError: a file would overwrite an input or another robot, or the folder cannot be written to.
    """
    folder = Path(folder)
    require_result_folder(folder, inputs)
    head = f"# {' '.join(result.robot.name.split())}, identified by elastocal {version('elastocal')}; SI units.\n"
    text, rows = result_json(result, data_sha256) + "\n", residuals_csv(result)
    contents: dict[str, str | bytes] = dict(
        zip(RESULT_FILES, (head + robot_to_toml(result.robot), text, rows), strict=False)
    )
    if report is not None:
        contents[REPORT_FILE] = report(saved_result(result.robot, text, rows))
    write_files(folder, contents, inputs)
    if report is None:
        (folder / REPORT_FILE).unlink(missing_ok=True)  # it tells of another result
    return tuple(contents)


def as_saved(result: CalibrationResult, data_sha256: Sequence[str] = ()) -> SavedResult:
    """The result as it would be read from its files."""
    return saved_result(result.robot, result_json(result, data_sha256), residuals_csv(result))


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
            "observability": observability_table(result.observability),
            "search": None if result.search is None else search_table(result.search),
            "transmission": None if result.maps is None else maps_table(result.maps),
            "tolerance": dict(result.tolerances),
            "model_sigma": dict(result.model_sigma),
            "chi2_reduced": result.chi2_reduced,
            "covariance": covariance_table(result.names, result.covariance),
            "correlated": [list(group) for group in result.correlated],
            "freedom": result.freedom,
            "bootstrap": result.bootstrap,
            "outliers": [outlier_table(outlier) for outlier in result.outliers],
            "streamed": None if result.streamed is None else asdict(result.streamed),
            "warnings": list(result.warnings),
            "notes": list(result.notes),
            "iterations": result.iterations,
            "seconds": result.seconds,
            "settings": dict(result.settings),
            "data_sha256": list(data_sha256),
            "version": version("elastocal"),
        }
    )


def observability_table(seen: Observability) -> dict[str, Any]:
    """Rank, condition and indices, with what the data see least."""
    return {
        "rank": seen.rank,
        "parameters": seen.parameters,
        "condition": seen.condition,
        **{f"O{i}": getattr(seen, f"O{i}") for i in range(1, 6)},
        "singular_values": list(seen.singular_values),
        "weakest": dict(seen.weakest),
    }


def transition_table(element: IdentifiedElement) -> dict[str, Any]:
    """Beside a transition torque: its standard deviation, the gap of loads it lies in, and the loads on each side."""
    if element.transition is None:
        return {}
    curve = element.transition.curve
    return {
        "transition_std": element.transition_std,
        "transition_gap": list(element.transition.gap),
        "loads": {"below": element.transition.below, "above": element.transition.above},
        "searched": element.transition.searched,
        "curve": None if curve is None else {"torques": list(curve.torques), "rises": _rounded(curve.rises)},
    }


def _rounded(values: Sequence[float]) -> list[float]:
    """To five digits, which is more than a figure shows."""
    return [float(f"{value:.5g}") for value in values]


def maps_table(maps: MapFit) -> dict[str, Any]:
    """How joint maps were found: orders, the standard deviation in each band, evidence beside no maps."""
    return {
        "orders": maps.orders,
        "bands": [{"first": band.first, "last": band.last, "std": band.std} for band in maps.bands],
        "log_evidence": {str(orders): value for orders, value in maps.log_evidence.items()},
    }


def outlier_table(outlier: Outlier) -> dict[str, Any]:
    """A row that does not fit the others; residual in m or rad."""
    return {
        "index": outlier.index,
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
    pair = None
    if search.pair is not None:
        pair = {
            "elements": list(search.pair.elements),
            "torques": [list(torques) for torques in search.pair.torques],
            "rises": [_rounded(row) for row in search.pair.rises],
        }
    return {
        "method": search.method,
        "proven": search.proven,
        "fits": search.fits,
        "best_fitness": list(search.history),
        "seconds": search.seconds,
        **({} if pair is None else {"pair": pair}),
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
    """A JSON object; what is not a finite number is null, and a list of numbers is one line."""
    lines: list[str] = []
    text = json.dumps(_finite(value, lines), indent=1, ensure_ascii=False, allow_nan=False)
    return LINE.sub(lambda found: lines[int(found[1])], text)


LINE = re.compile(r'"\\u0000(\d+)\\u0000"')
"""Where a list of numbers goes: no text of a user holds the character zero."""


def _finite(value: Any, lines: list[str]) -> Any:
    """Without numbers that are not finite; lists of numbers are moved to `lines`."""
    if isinstance(value, Mapping):
        return {key: _finite(item, lines) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        items = [_finite(item, lines) for item in value]
        if not items or any(isinstance(item, (dict, list, str)) for item in items):
            return items
        lines.append(json.dumps(items))
        return f"\0{len(lines) - 1}\0"
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def save_residuals(result: ValidationResult, path: Path, inputs: Iterable[Path] = ()) -> None:
    """Write every row's residuals of a validation as CSV.

    Raises:
        InputError: the file would overwrite an input, or cannot be written.
    """
    columns = places_of(result.data) | residual_columns(result.residuals, "")
    write_files(path.parent, {path.name: csv_bytes(columns)}, inputs)


def residuals_csv(result: CalibrationResult) -> bytes:
    """Every row's residuals (measured - predicted), nominal and calibrated, in the instrument's frame."""
    errors = result.errors
    columns = places_of(errors.data)
    columns["set"] = np.where(errors.held_out, "held_out", "fitted").tolist()
    columns["outlier"] = np.isin(np.arange(len(errors.data)), [outlier.index for outlier in result.outliers])
    columns |= wrench_columns(errors.data)
    columns |= residual_columns(errors.nominal, "nominal_") | residual_columns(errors.calibrated, "calibrated_")
    return csv_bytes(columns)


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
