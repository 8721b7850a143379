"""Files in, files out: the only place that knows units and formats."""

from elastocal.io.drift_files import difference_json
from elastocal.io.export_files import export_json, save_export
from elastocal.io.exports import EXPORTS, Exported, export_robot, nominal_of
from elastocal.io.files import require_writable, write_files
from elastocal.io.measurement_files import data_hashes, load_measurements, save_measurements, source_files
from elastocal.io.parquet_files import ROW_GROUP, is_parquet, write_parquet
from elastocal.io.partition_files import data_files, open_measurements, scan_measurements, too_large
from elastocal.io.plan_files import plan_csv, plan_json
from elastocal.io.result_files import load_result
from elastocal.io.results import (
    REPORT_FILE,
    RESULT_FILES,
    as_saved,
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
    "EXPORTS",
    "REPORT_FILE",
    "RESULT_FILES",
    "ROW_GROUP",
    "Exported",
    "as_saved",
    "comparison_json",
    "data_files",
    "data_hashes",
    "difference_json",
    "export_json",
    "export_robot",
    "is_parquet",
    "load_measurements",
    "load_result",
    "load_robot",
    "measurements_to_csv",
    "nominal_of",
    "open_measurements",
    "plan_csv",
    "plan_json",
    "require_result_folder",
    "require_writable",
    "result_json",
    "robot_to_toml",
    "save_export",
    "save_measurements",
    "save_residuals",
    "save_result",
    "save_robot",
    "save_uncertainty",
    "scan_measurements",
    "source_files",
    "too_large",
    "uncertainty_json",
    "validation_json",
    "write_files",
    "write_parquet",
]
