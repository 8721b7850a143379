"""Reports: sections of text and tables, and how they look on a terminal."""

from elastocal.report.precision import difference_sections, uncertainty_sections
from elastocal.report.section import Section
from elastocal.report.sections import calibration_sections, comparison_sections, validation_sections
from elastocal.report.terminal import print_sections

__all__ = [
    "Section",
    "calibration_sections",
    "comparison_sections",
    "difference_sections",
    "print_sections",
    "uncertainty_sections",
    "validation_sections",
]
