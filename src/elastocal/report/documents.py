"""Whole reports: of one calibration, of several, of any sections."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from elastocal.identification import AnyResult, CalibrationResult, SavedResult
from elastocal.identification.threads import one_thread
from elastocal.io import as_saved, write_files
from elastocal.report.calibration import report_sections
from elastocal.report.html import page_html
from elastocal.report.section import Section


def report_html(result: AnyResult) -> str:
    """The report on a calibration as one web page.

    Args:
        result: as calibrate returned or load_result read it. What is written is what would be read again from its
            folder, so that the same result makes the same report.
    """
    saved = as_saved(result) if isinstance(result, CalibrationResult) else result
    return calibration_report(saved)


@one_thread
def calibration_report(result: SavedResult) -> str:
    """The report on a calibration that was saved."""
    return page_html(f"{result.robot.name}: calibration report", report_sections(result))


def save_report(result: AnyResult, path: str | Path) -> None:
    """Write the report on a calibration as one HTML file.

    Raises:
        InputError: it cannot be written.
    """
    write_page(Path(path), report_html(result))


def write_page(path: Path, page: str, inputs: Iterable[Path] = ()) -> None:
    """Write a page, whole or not at all.

    Raises:
        InputError: it would overwrite an input, or cannot be written.
    """
    contents: Mapping[str, str] = {path.name: page}
    write_files(path.parent, contents, inputs)


def write_sections(path: Path, title: str, sections: list[Section], inputs: Iterable[Path] = ()) -> None:
    """Write any sections as a page.

    Raises:
        InputError: it would overwrite an input, or cannot be written.
    """
    write_page(path, page_html(title, sections), inputs)
