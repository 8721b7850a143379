"""Simulation: measurements of a robot that does not exist."""

from elastocal.simulation.actual import as_built, reach_of, with_frames_drawn, with_geometry_errors
from elastocal.simulation.instrument import Instrument, read
from elastocal.simulation.poses import Drawn, draw, random_poses
from elastocal.simulation.region import Region
from elastocal.simulation.survey import simulate, survey, survey_at, survey_blocks

__all__ = [
    "Drawn",
    "Instrument",
    "Region",
    "as_built",
    "draw",
    "random_poses",
    "reach_of",
    "read",
    "simulate",
    "survey",
    "survey_at",
    "survey_blocks",
    "with_frames_drawn",
    "with_geometry_errors",
]
