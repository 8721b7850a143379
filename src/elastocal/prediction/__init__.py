"""Prediction: the one place where model meets data."""

from elastocal.prediction.model import Model, Part, Setup, kind_of, predict

__all__ = ["Model", "Part", "Setup", "kind_of", "predict"]
