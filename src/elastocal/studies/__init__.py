"""Simulated calibrations over a grid: how good are they, and what does that depend on?"""

from elastocal.io.study_files import read_study
from elastocal.io.study_values import Actual, Setting, Spring, Study
from elastocal.studies.run import require_study, run_study
from elastocal.studies.summary import CellSummary, StudySummary
from elastocal.studies.tables import study_json

__all__ = [
    "Actual",
    "CellSummary",
    "Setting",
    "Spring",
    "Study",
    "StudySummary",
    "read_study",
    "require_study",
    "run_study",
    "study_json",
]
