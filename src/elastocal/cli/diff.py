"""The command `elastocal diff`."""

from __future__ import annotations

from pathlib import Path

from elastocal.cli.options import Json, Seed


def diff(before: Path, after: Path, /, *, seed: Seed = 0, json: Json = False) -> int:
    """What changed between two calibrations of one robot, in units of its uncertainty: drift, or noise?

    Base, tool and targets are listed apart: they move with the instrument and the probe.

    Args:
        before: Folder of the first calibration (calibrate -o).
        after: Folder of the second.
        seed: Of the random poses at which the change of the flange's position is told.
        json: Print the result object and nothing else on standard output.
    """
    from elastocal.cli.main import DONE
    from elastocal.cli.show import show
    from elastocal.drift import difference
    from elastocal.io import difference_json, load_result
    from elastocal.report import difference_sections

    found = difference(load_result(before), load_result(after), seed=seed)
    if json:
        print(difference_json(found))
    else:
        show(difference_sections(found))
    return DONE
