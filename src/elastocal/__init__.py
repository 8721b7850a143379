"""elastocal: robot calibration that models what bends. This file is the public API."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from elastocal.comparison import Comparison as Comparison
    from elastocal.comparison import compare as compare
    from elastocal.cross_validation import cross_validate as cross_validate
    from elastocal.drift import Difference as Difference
    from elastocal.drift import difference as difference
    from elastocal.errors import ElastocalError as ElastocalError
    from elastocal.errors import EquilibriumError as EquilibriumError
    from elastocal.errors import InputError as InputError
    from elastocal.identification import CalibrationResult as CalibrationResult
    from elastocal.identification import GeneticSearch as GeneticSearch
    from elastocal.identification import calibrate as calibrate
    from elastocal.io import load_measurements as load_measurements
    from elastocal.io import load_result as load_result
    from elastocal.io import load_robot as load_robot
    from elastocal.io import save_measurements as save_measurements
    from elastocal.io import save_result as save_result
    from elastocal.io import save_robot as save_robot
    from elastocal.measurements import Measurements as Measurements
    from elastocal.prediction import predict as predict
    from elastocal.robot import Robot as Robot
    from elastocal.simulation import random_poses as random_poses
    from elastocal.simulation import simulate as simulate
    from elastocal.uncertainty import Uncertainty as Uncertainty
    from elastocal.uncertainty import position_uncertainty as position_uncertainty
    from elastocal.validation import ValidationResult as ValidationResult
    from elastocal.validation import validate as validate

_HOMES = {
    "comparison": ("Comparison", "compare"),
    "cross_validation": ("cross_validate",),
    "drift": ("Difference", "difference"),
    "errors": ("ElastocalError", "EquilibriumError", "InputError"),
    "identification": ("CalibrationResult", "GeneticSearch", "calibrate"),
    "io": ("load_measurements", "load_result", "load_robot", "save_measurements", "save_result", "save_robot"),
    "measurements": ("Measurements",),
    "prediction": ("predict",),
    "robot": ("Robot",),
    "simulation": ("random_poses", "simulate"),
    "uncertainty": ("Uncertainty", "position_uncertainty"),
    "validation": ("ValidationResult", "validate"),
}
"""Where the public names live; they are imported when first used, so that `elastocal --help` is quick."""

__all__ = sorted(name for names in _HOMES.values() for name in names)


def __getattr__(name: str) -> object:
    for home, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f"elastocal.{home}"), name)
    raise AttributeError(f"module 'elastocal' has no attribute {name!r}; it has {', '.join(__all__)}")


def __dir__() -> list[str]:
    return __all__
