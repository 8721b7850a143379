"""Simulation: measurements of a robot that does not exist."""

from elastocal.simulation.actual import as_built, with_frames_drawn, with_geometry_errors
from elastocal.simulation.instrument import Instrument, read
from elastocal.simulation.poses import random_poses
from elastocal.simulation.region import Region
from elastocal.simulation.survey import simulate, survey

__all__ = [
    "Instrument",
    "Region",
    "as_built",
    "random_poses",
    "read",
    "simulate",
    "survey",
    "with_frames_drawn",
    "with_geometry_errors",
]
