"""Design of experiments: which poses to measure."""

from elastocal.design.candidates import Candidates, draw_candidates, draw_workspace, kept_candidates
from elastocal.design.criteria import CRITERIA
from elastocal.design.plan import choose, select_poses
from elastocal.design.request import Request
from elastocal.design.result import CurvePoint, Plan, PlannedParameter, PlannedTransition
from elastocal.design.surroundings import Box, Surroundings
from elastocal.design.task import Reading

__all__ = [
    "CRITERIA",
    "Box",
    "Candidates",
    "CurvePoint",
    "Plan",
    "PlannedParameter",
    "PlannedTransition",
    "Reading",
    "Request",
    "Surroundings",
    "choose",
    "draw_candidates",
    "draw_workspace",
    "kept_candidates",
    "select_poses",
]
