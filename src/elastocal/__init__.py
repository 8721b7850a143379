"""elastocal: robot calibration that models what bends. This file is the public API."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from elastocal import figures as figures
    from elastocal.comparison import Comparison as Comparison
    from elastocal.comparison import compare as compare
    from elastocal.compensation import Compensation as Compensation
    from elastocal.compensation import Targets as Targets
    from elastocal.compensation import compensate as compensate
    from elastocal.compensation import inverse_kinematics as inverse_kinematics
    from elastocal.cross_validation import cross_validate as cross_validate
    from elastocal.design import Plan as Plan
    from elastocal.design import select_poses as select_poses
    from elastocal.drift import Difference as Difference
    from elastocal.drift import difference as difference
    from elastocal.errors import ElastocalError as ElastocalError
    from elastocal.errors import EquilibriumError as EquilibriumError
    from elastocal.errors import InputError as InputError
    from elastocal.fleet import FleetSummary as FleetSummary
    from elastocal.fleet import run_fleet as run_fleet
    from elastocal.identification import CalibrationResult as CalibrationResult
    from elastocal.identification import GeneticSearch as GeneticSearch
    from elastocal.identification import calibrate as calibrate
    from elastocal.io import Exported as Exported
    from elastocal.io import export_robot as export_robot
    from elastocal.io import load_measurements as load_measurements
    from elastocal.io import load_result as load_result
    from elastocal.io import load_robot as load_robot
    from elastocal.io import save_measurements as save_measurements
    from elastocal.io import save_result as save_result
    from elastocal.io import save_robot as save_robot
    from elastocal.io import scan_measurements as scan_measurements
    from elastocal.measurements import Measurements as Measurements
    from elastocal.partitions import Partitions as Partitions
    from elastocal.prediction import predict as predict
    from elastocal.report import report_html as report_html
    from elastocal.report import save_report as save_report
    from elastocal.robot import Robot as Robot
    from elastocal.simulation import random_poses as random_poses
    from elastocal.simulation import simulate as simulate
    from elastocal.studies import StudySummary as StudySummary
    from elastocal.studies import run_study as run_study
    from elastocal.uncertainty import Uncertainty as Uncertainty
    from elastocal.uncertainty import position_uncertainty as position_uncertainty
    from elastocal.validation import ValidationResult as ValidationResult
    from elastocal.validation import validate as validate

_HOMES = {
    "comparison": ("Comparison", "compare"),
    "compensation": ("Compensation", "Targets", "compensate", "inverse_kinematics"),
    "cross_validation": ("cross_validate",),
    "design": ("Plan", "select_poses"),
    "drift": ("Difference", "difference"),
    "errors": ("ElastocalError", "EquilibriumError", "InputError"),
    "fleet": ("FleetSummary", "run_fleet"),
    "identification": ("CalibrationResult", "GeneticSearch", "calibrate"),
    "io": (
        "Exported",
        "export_robot",
        "load_measurements",
        "load_result",
        "load_robot",
        "save_measurements",
        "save_result",
        "save_robot",
        "scan_measurements",
    ),
    "measurements": ("Measurements",),
    "partitions": ("Partitions",),
    "prediction": ("predict",),
    "report": ("report_html", "save_report"),
    "robot": ("Robot",),
    "simulation": ("random_poses", "simulate"),
    "studies": ("StudySummary", "run_study"),
    "uncertainty": ("Uncertainty", "position_uncertainty"),
    "validation": ("ValidationResult", "validate"),
}
"""Where the public names live; they are imported when first used, so that `elastocal --help` is quick."""

__all__ = sorted(name for names in _HOMES.values() for name in names)


def __getattr__(name: str) -> object:
    if name == "figures":
        return import_module("elastocal.figures")
    for home, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f"elastocal.{home}"), name)
    raise AttributeError(f"module 'elastocal' has no attribute {name!r}; it has {', '.join(__all__)}")


def __dir__() -> list[str]:
    return [*__all__, "figures"]
