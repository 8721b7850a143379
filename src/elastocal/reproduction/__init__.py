"""The two papers, reproduced: their inputs, what they leave open, and runs that store nothing."""

from elastocal.reproduction.figures import figures
from elastocal.reproduction.ha006 import SEED
from elastocal.reproduction.nonlinear_stiffness import GENETIC, RUNGS, Ladder, Rung, RungRun
from elastocal.reproduction.selection import Reproduction, Selection, reproduce, select
from elastocal.reproduction.stiffness_analysis import CASES, Case, CaseRun
from elastocal.reproduction.values import Chosen, Figures, Paper, ParameterRow, Slip, StiffnessRow

__all__ = [
    "CASES",
    "GENETIC",
    "RUNGS",
    "SEED",
    "Case",
    "CaseRun",
    "Chosen",
    "Figures",
    "Ladder",
    "Paper",
    "ParameterRow",
    "Reproduction",
    "Rung",
    "RungRun",
    "Selection",
    "Slip",
    "StiffnessRow",
    "figures",
    "reproduce",
    "select",
]
