"""Reports: sections of text, tables and figures, and how they look on a terminal and on a page."""

from elastocal.report.documents import report_html, save_report
from elastocal.report.export import export_sections
from elastocal.report.plan import plan_sections
from elastocal.report.precision import difference_sections, uncertainty_sections
from elastocal.report.section import Section
from elastocal.report.sections import calibration_sections, comparison_sections, validation_sections
from elastocal.report.terminal import print_sections

__all__ = [
    "Section",
    "calibration_sections",
    "comparison_sections",
    "difference_sections",
    "export_sections",
    "plan_sections",
    "print_sections",
    "report_html",
    "save_report",
    "uncertainty_sections",
    "validation_sections",
]
