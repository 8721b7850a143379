"""Prediction: the one place where model meets data."""

from elastocal.prediction.model import Combination, Model, Part, Setup, combinations, predict

__all__ = ["Combination", "Model", "Part", "Setup", "combinations", "predict"]
