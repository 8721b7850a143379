"""Files in, files out: the only place that knows units and formats."""

from elastocal.io.drift_files import difference_json
from elastocal.io.files import require_writable, write_files
from elastocal.io.measurement_files import data_hashes, load_measurements, save_measurements, source_files
from elastocal.io.result_files import load_result
from elastocal.io.results import (
    comparison_json,
    require_result_folder,
    result_json,
    save_residuals,
    save_result,
    validation_json,
)
from elastocal.io.robot_files import load_robot, save_robot
from elastocal.io.robot_toml import robot_to_toml
from elastocal.io.tidy import measurements_to_csv
from elastocal.io.uncertainty_files import save_uncertainty, uncertainty_json

__all__ = [
    "comparison_json",
    "data_hashes",
    "difference_json",
    "load_measurements",
    "load_result",
    "load_robot",
    "measurements_to_csv",
    "require_result_folder",
    "require_writable",
    "result_json",
    "robot_to_toml",
    "save_measurements",
    "save_residuals",
    "save_result",
    "save_robot",
    "save_uncertainty",
    "source_files",
    "uncertainty_json",
    "validation_json",
    "write_files",
]
