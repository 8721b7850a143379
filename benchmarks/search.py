"""Seconds that the search for two transition torques takes: `python benchmarks/search.py`, on an idle machine.

The arm of studies/transition_recovery.py, a step and a hinge in joints 2 and 3. The last result is in search.txt.
"""

from __future__ import annotations

import sys
from pathlib import Path

from rich.console import Console
from rich.table import Table

sys.path.insert(0, str(Path(__file__).parents[1] / "studies"))

from transition_recovery import JOINTS, NOISE, actual_arm

from elastocal.examples import ROBOT_FILE
from elastocal.identification import calibrate
from elastocal.io import load_robot
from elastocal.simulation import random_poses, simulate

RUNS = 5


def main() -> None:
    """Print the fastest of several runs."""
    table = Table("law", "poses", "combinations", "search [ms]", "calibrate [ms]")
    for law in ("step", "hinge"):
        for poses in (45, 60, 1000, 4000):
            actual = actual_arm(law, 0)
            data = simulate(actual, random_poses(actual, poses, 0), noise=NOISE, seed=0)
            found = [calibrate(load_robot(ROBOT_FILE), data, elastic=dict.fromkeys(JOINTS, law)) for _ in range(RUNS)]
            search, whole = min(r.search.seconds for r in found), min(r.seconds for r in found)
            compared = " x ".join(str(min(e.transition.below + e.transition.above - 5, 1000)) for e in found[0].elastic)
            table.add_row(law, str(poses), compared, f"{1e3 * search:.0f}", f"{1e3 * whole:.0f}")
    Console(width=80).print(table)


if __name__ == "__main__":
    main()
