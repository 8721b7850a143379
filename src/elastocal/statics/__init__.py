"""Masses on a chain, and how they press on its elements."""

from elastocal.statics.gradient import WeightedGradients, mutual_gradients
from elastocal.statics.loads import Statics, Wrench, load
from elastocal.statics.mechanism import Mechanism, PointMass

__all__ = ["Mechanism", "PointMass", "Statics", "WeightedGradients", "Wrench", "load", "mutual_gradients"]
