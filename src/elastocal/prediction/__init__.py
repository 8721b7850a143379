"""Prediction: the one place where model meets data."""

from elastocal.prediction.model import Model, Part, Setup, predict

__all__ = ["Model", "Part", "Setup", "predict"]
