"""Speed and memory as ratios within one run: `python benchmarks/speed.py`, on an idle machine.

Each figure is the fastest of several runs, on one thread, and stands beside its bar; exit status 1 if one is missed.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = "1"

import resource
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from rich.console import Console
from rich.table import Table

from elastocal.examples import ROBOT_FILE, actual_arm
from elastocal.identification import Gauge, calibrate, choose_gauge
from elastocal.identification.calibration import fit_frames
from elastocal.identification.request import requested, with_laws
from elastocal.identification.sums import normal_sums
from elastocal.io import load_robot
from elastocal.measurements import KINDS, Measurements
from elastocal.prediction import Model
from elastocal.robot import Robot
from elastocal.simulation import random_poses, simulate

ELASTIC = dict.fromkeys("2345", "linear")
NOISE = 3e-5
ONES = dict.fromkeys(KINDS, 1.0)


def fastest(function: Callable[[], object], runs: int) -> float:
    """Seconds of the fastest of several runs."""
    times = []
    for _ in range(runs):
        began = time.perf_counter()
        function()
        times.append(time.perf_counter() - began)
    return min(times)


def example(poses: int) -> tuple[Robot, Measurements]:
    """The nominal example arm, and measured positions of one target of the actual one."""
    nominal = load_robot(ROBOT_FILE)
    actual = actual_arm(nominal)
    return nominal, simulate(actual, random_poses(actual, poses, 0), noise=NOISE)


def prepared(nominal: Robot, data: Measurements) -> tuple[Model, Gauge]:
    """The model of a fit at its start: frames fitted, 31 parameters."""
    wished, springs = with_laws(nominal, ELASTIC)
    gauge = choose_gauge(wished, data, requested(wished, springs))
    model = Model(fit_frames(wished, data, gauge), gauge.kept, data)
    return replace(model, robot=model.robot.displaced({f"{i}.theta.c": 2e-6 for i in range(2, 6)})), gauge


def large_blas() -> tuple[Model, float]:
    """A model of 100,000 poses, and the time of J J^T alone on a Jacobian of its size in memory."""
    model, gauge = prepared(*example(100_000))
    jacobian = np.random.default_rng(0).standard_normal((len(gauge.kept), 3 * len(model.data)))
    return model, fastest(lambda: jacobian @ jacobian.T, 9)


def block_sums() -> list[tuple[str, float, float]]:
    """One evaluation of a large fit: all that a step needs of the data."""
    model, blas = large_blas()
    x = np.zeros(len(model.names))
    held = fastest(lambda: normal_sums(model, x, ONES, held=True), 9)
    settled = fastest(lambda: normal_sums(model, x, ONES), 9)
    what = f"100,000 poses, {len(x)} parameters: prediction, Jacobian, loads, normal equations / J·Jᵀ alone"
    return [
        (f"{what}, at given deflections", held / blas, 4.0),
        (f"{what}, equilibrium iterated", settled / blas, 10.0),
    ]


def whole_calibration() -> list[tuple[str, float, float]]:
    """From request to verdict, alignment and standard deviations included."""
    nominal, data = example(60)
    result = calibrate(nominal, data, elastic=ELASTIC)
    jacobian = np.random.default_rng(0).standard_normal((result.coordinates, len(result.gauge.kept)))
    svd = fastest(lambda: np.linalg.svd(jacobian, full_matrices=False), 300)
    found = fastest(lambda: calibrate(nominal, data, elastic=ELASTIC), 60)
    return [("calibrate() of 60 poses / one SVD of its stacked Jacobian", found / svd, 150.0)]


def growth() -> list[tuple[str, float, float]]:
    """Time for ten times the poses, and memory above the data."""
    rows = []
    times = {}
    for poses, runs in ((10_000, 5), (100_000, 3), (1_000_000, 2)):
        nominal, data = example(poses)
        before = resident()
        times[poses] = fastest(lambda: calibrate(nominal, data, elastic=ELASTIC), runs)  # noqa: B023
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    rows.append(("calibrate() of 100,000 poses / of 10,000", times[100_000] / times[10_000], 11.0))
    rows.append(("calibrate() of 1,000,000 poses / of 100,000", times[1_000_000] / times[100_000], 11.0))
    rows.append(("memory of calibrate() of 1,000,000 poses above the data [MB]", peak - before, 300.0))
    return rows


def resident() -> float:
    """Resident memory of this process [MB], Linux."""
    pages = int(open("/proc/self/statm").read().split()[1])  # noqa: SIM115, PTH123
    return pages * resource.getpagesize() / 2**20


def start_up() -> list[tuple[str, float, float]]:
    """Whole processes."""

    def run(*command: str) -> float:
        return fastest(lambda: subprocess.run(command, check=True, capture_output=True), 15)

    executable = os.path.join(os.path.dirname(sys.executable), "elastocal")  # noqa: PTH118, PTH120
    ratio = run(executable, "--help") / run(sys.executable, "-c", "import numpy")
    return [("elastocal --help / python -c 'import numpy'", ratio, 3.0)]


def main() -> int:
    """Run all, print a table, say whether every bar is kept."""
    rows = [row for part in (block_sums, whole_calibration, start_up, growth) for row in part()]
    table = Table("figure", "found", "bar", title=f"NumPy {np.__version__}, one thread")
    for name, found, bar in rows:
        table.add_row(name, f"[{'green' if found <= bar else 'red'}]{found:.3g}", f"≤ {bar:g}")
    Console(width=110).print(table)
    return int(any(found > bar for _, found, bar in rows))


if __name__ == "__main__":
    sys.exit(main())
