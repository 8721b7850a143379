"""Size of the report on the UR10's 4,268 poses, and its seconds: `python benchmarks/report.py`, on an idle machine.

Bars: 8 MB, 3 s. Where the data are not there, as many poses of the built-in arm are simulated. The last result is in
report.txt.
"""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

from rich.console import Console
from rich.table import Table

from elastocal.examples import ROBOT_FILE, actual_arm, measure
from elastocal.identification import CalibrationResult, calibrate
from elastocal.io import as_saved, load_measurements, load_robot
from elastocal.report.documents import calibration_report

UR10 = Path(os.environ.get("ELASTOCAL_UR10", Path(__file__).parents[2] / "shared" / "data" / "ur10"))

MOST_MEGABYTES, MOST_SECONDS = 8.0, 3.0

RUNS = 3


def results() -> dict[str, CalibrationResult]:
    """Calibrations of few and of many poses, without and with joint maps."""
    arm = load_robot(ROBOT_FILE)
    actual = actual_arm(arm)
    found = {"arm, 60 poses": calibrate(arm, measure(actual, 60), elastic={"2": "step", "3": "linear"})}
    robot, data = arm, None
    if (UR10 / "robot.toml").is_file():
        robot = load_robot(UR10 / "robot.toml")
        data = load_measurements([UR10 / "series_b.toml", UR10 / "series_c.toml"], robot)
    name, data = ("UR10" if data is not None else "arm"), data if data is not None else measure(actual, 4268)
    elastic = dict.fromkeys("23", "linear")
    found[f"{name}, {len(data)} poses"] = calibrate(robot, data, elastic=elastic, holdout=0.7)
    found[f"{name}, {len(data)} poses, maps of 60 orders"] = calibrate(
        robot, data, elastic=elastic, holdout=0.3, transmission=60
    )
    return found


def main() -> int:
    """Print the fastest of several runs; exit status 1 if a bar is missed."""
    table = Table("report", "saved and read again [s]", "written [s]", "size [MB]")
    missed = False
    for name, result in results().items():
        saving, writing, size = [], [], 0.0
        for _ in range(RUNS):
            began = time.perf_counter()
            saved = as_saved(result)
            saving.append(time.perf_counter() - began)
            began = time.perf_counter()
            size = len(calibration_report(saved).encode()) / 1e6
            writing.append(time.perf_counter() - began)
        table.add_row(name, f"{min(saving):.2f}", f"{min(writing):.2f}", f"{size:.2f}")
        missed = missed or size > MOST_MEGABYTES or min(saving) + min(writing) > MOST_SECONDS
    Console(width=100).print(table)
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
