"""The command `elastocal report`."""

from __future__ import annotations

import sys
from pathlib import Path

from elastocal.cli.options import Output
from elastocal.errors import InputError


def report(*folders: Path, output: Output = None) -> int:
    """The report on a calibration as one web page, which opens offline; or several calibrations side by side.

    The same page is written by calibrate -o. It has all figures, and what is needed to make the result again.

    Args:
        folders: Folders of calibrations (calibrate -o). Several are compared: models, or dates.
        output: HTML file. Of one calibration report.html in its folder if left out; of several a summary is printed.
    """
    from elastocal.cli.main import DONE
    from elastocal.cli.show import show
    from elastocal.io import RESULT_FILES, load_result, require_writable
    from elastocal.report.documents import calibration_report, write_page, write_sections
    from elastocal.report.results import named_results, several_sections

    if not folders:
        raise InputError("expected the folder of a calibration (calibrate -o DIR), or several to compare; found none")
    inputs = [folder / name for folder in folders for name in RESULT_FILES[:-1]]
    if len(folders) == 1:
        output = output or folders[0] / RESULT_FILES[-1]
    if output is not None and folders[0].is_dir():
        require_writable(output.parent, [output.name], inputs)
    results = [load_result(folder) for folder in folders]
    if len(folders) == 1 and output is not None:
        write_page(output, calibration_report(results[0]), inputs)
    else:
        sections = several_sections(named_results([str(folder) for folder in folders], results))
        if output is None:
            show(sections)
            return DONE
        write_sections(output, f"{len(folders)} calibrations side by side", sections, inputs)
    print(f"{output}", file=sys.stderr)
    return DONE
