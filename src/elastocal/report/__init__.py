"""Reports: sections of text and tables, and how they look on a terminal."""

from elastocal.report.sections import Section, calibration_sections, comparison_sections, validation_sections
from elastocal.report.terminal import print_sections

__all__ = ["Section", "calibration_sections", "comparison_sections", "print_sections", "validation_sections"]
