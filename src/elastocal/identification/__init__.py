"""Identification: alignment, gauge, least squares, uncertainty; calibrate() does all of it."""

from elastocal.identification.calibration import calibrate, fit_frames
from elastocal.identification.gauge import Gauge, choose_gauge
from elastocal.identification.observability import Observability
from elastocal.identification.outliers import Outlier
from elastocal.identification.priors import Band, MapFit, PriorFit
from elastocal.identification.result import CalibrationResult, IdentifiedElement, IdentifiedParameter, RowErrors
from elastocal.identification.saved import AnyResult, SavedResult
from elastocal.identification.statistics import Residuals, Statistics, residuals, statistics, statistics_of
from elastocal.identification.transition import GeneticSearch, Search, TorqueCurve, TorqueMap, TransitionData

__all__ = [
    "AnyResult",
    "Band",
    "CalibrationResult",
    "Gauge",
    "GeneticSearch",
    "IdentifiedElement",
    "IdentifiedParameter",
    "MapFit",
    "Observability",
    "Outlier",
    "PriorFit",
    "Residuals",
    "RowErrors",
    "SavedResult",
    "Search",
    "Statistics",
    "TorqueCurve",
    "TorqueMap",
    "TransitionData",
    "calibrate",
    "choose_gauge",
    "fit_frames",
    "residuals",
    "statistics",
    "statistics_of",
]
