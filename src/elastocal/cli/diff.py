"""The command `elastocal diff`."""

from __future__ import annotations

import sys
from pathlib import Path

from elastocal.cli.options import Json, Page, Seed


def diff(before: Path, after: Path, /, *, seed: Seed = 0, html: Page = None, json: Json = False) -> int:
    """What changed between two calibrations of one robot, in units of its uncertainty: drift, or noise?

    Base, tool and targets are listed apart: they move with the instrument and the probe.

    Args:
        before: Folder of the first calibration (calibrate -o).
        after: Folder of the second.
        seed: Of the random poses at which the change of the flange's position is told.
        html: HTML file to write too.
        json: Print the result object and nothing else on standard output.
    """
    from elastocal.cli.main import DONE
    from elastocal.cli.show import show
    from elastocal.drift import difference
    from elastocal.io import RESULT_FILES, difference_json, load_result, require_writable
    from elastocal.report import difference_sections
    from elastocal.report.documents import write_sections

    inputs = [folder / name for folder in (before, after) for name in RESULT_FILES]
    if html is not None:
        require_writable(html.parent, [html.name], inputs)
    found = difference(load_result(before, rows=False), load_result(after, rows=False), seed=seed)
    sections = difference_sections(found)
    if html is not None:
        write_sections(html, f"{found.robot}: changes between two calibrations", sections, inputs)
        print(f"{html}", file=sys.stderr)
    if json:
        print(difference_json(found))
    else:
        show(sections)
    return DONE
