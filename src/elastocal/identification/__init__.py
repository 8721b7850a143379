"""Identification: alignment, gauge, least squares, uncertainty; calibrate() does all of it."""

from elastocal.identification.calibration import calibrate, fit_frames
from elastocal.identification.gauge import Gauge, choose_gauge
from elastocal.identification.observability import Observability
from elastocal.identification.result import CalibrationResult, IdentifiedElement, IdentifiedParameter
from elastocal.identification.statistics import Residuals, Statistics, residuals, statistics

__all__ = [
    "CalibrationResult",
    "Gauge",
    "IdentifiedElement",
    "IdentifiedParameter",
    "Observability",
    "Residuals",
    "Statistics",
    "calibrate",
    "choose_gauge",
    "fit_frames",
    "residuals",
    "statistics",
]
