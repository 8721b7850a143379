"""Identification: alignment, gauge, least squares, uncertainty; calibrate() does all of it."""

from elastocal.identification.calibration import calibrate, fit_frames
from elastocal.identification.gauge import Gauge, choose_gauge
from elastocal.identification.observability import Observability
from elastocal.identification.outliers import Outlier
from elastocal.identification.priors import PriorFit
from elastocal.identification.result import CalibrationResult, IdentifiedElement, IdentifiedParameter
from elastocal.identification.saved import SavedResult
from elastocal.identification.statistics import Residuals, Statistics, residuals, statistics, statistics_of
from elastocal.identification.transition import GeneticSearch, Search

__all__ = [
    "CalibrationResult",
    "Gauge",
    "GeneticSearch",
    "IdentifiedElement",
    "IdentifiedParameter",
    "Observability",
    "Outlier",
    "PriorFit",
    "Residuals",
    "SavedResult",
    "Search",
    "Statistics",
    "calibrate",
    "choose_gauge",
    "fit_frames",
    "residuals",
    "statistics",
    "statistics_of",
]
