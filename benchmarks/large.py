"""Time and memory of a data set larger than memory need be: `python benchmarks/large.py`, on an idle machine.

Simulated poses of the example arm in Parquet files, 1 and 20 million, each fitted by a process of its own with linear
compliance in four joints, part by part, and 1 million in memory beside it. It needs 1.6 GB in the temporary folder and
about ten minutes; exit status 1 if a bar is missed. The last result is in large.txt. What a process has of a file is
read, not mapped, so that the peak of its resident memory has no pages of files but those of libraries.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

import elastocal as ec
from elastocal.examples import ROBOT_FILE, actual_arm

FEW, MANY = 1_000_000, 20_000_000
ELASTIC = dict.fromkeys("2345", "linear")
MEMORY = 1000.0
"""Most resident memory [MB]."""

UNSEEN = 2000
"""Poses that the identified robot is compared with the actual one at."""


@dataclass(frozen=True)
class Run:
    """A fit in a process of its own: seconds by the clock and of the processor, peak memory [MB], what it found."""

    poses: int
    how: str
    clock: float
    processor: float
    peak: float
    found: dict[str, float]


def simulate(folder: Path, poses: int) -> tuple[Path, float, float]:
    """A Parquet file of so many poses, the seconds it took and the peak memory [MB]."""
    path = folder / f"{poses}.parquet"
    options = ["--poses", str(poses), "--actual", "actual.toml", "--noise", "0.03mm", "--seed", "1", "-o", str(path)]
    clock, _, peak, _ = timed([sys.executable, "-m", "elastocal", "simulate", str(ROBOT_FILE), *options], folder)
    return path, clock, peak


def timed(command: list[str], folder: Path) -> tuple[float, float, float, str]:
    """Seconds by the clock and of the processor, and peak memory [MB], of a command; what it prints."""
    began = time.perf_counter()
    with subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True) as process:
        out = process.stdout.read() if process.stdout else ""
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, command)
    return time.perf_counter() - began, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024.0, out


def fit(path: Path, how: str) -> None:
    """In a process of its own: fit a file, and print what was found."""
    nominal = ec.load_robot(ROBOT_FILE)
    load = ec.scan_measurements if how == "in parts" else ec.load_measurements
    result = ec.calibrate(nominal, load(path, nominal), elastic=ELASTIC)
    actual = actual_arm(nominal)
    q = ec.random_poses(actual, UNSEEN, 99)
    apart = np.linalg.norm(ec.predict(result.robot, q)[0] - ec.predict(actual, q)[0], axis=1)
    softness = {e.element: e.coefficients[0] / actual.elastic[e.element].coefficients[0] - 1.0 for e in result.elastic}
    found = {"iterations": result.iterations, "residual": result.residuals["calibrated"].mean}
    worst = max(abs(value) for value in softness.values())
    print(json.dumps({**found, "apart": float(apart.mean()), "softness": worst}))


def measured(path: Path, poses: int, how: str) -> Run:
    """A fit of a file in a process of its own."""
    clock, processor, peak, out = timed([sys.executable, str(Path(__file__).resolve()), str(path), how], path.parent)
    return Run(poses, how, clock, processor, peak, json.loads(out))


def show(runs: list[Run], written: list[str]) -> None:
    """Print what was found."""
    head = ("poses", "fitted", "clock [s]", "CPU [s]", "µs/pose", "CPU µs/pose", "peak [MB]", "residual [µm]")
    table = Table(*head, "off [µm]", "compliance off")
    for run in runs:
        each = (1e6 * seconds / run.poses for seconds in (run.clock, run.processor))
        found = run.found
        table.add_row(
            f"{run.poses:,}",
            run.how,
            f"{run.clock:.1f}",
            f"{run.processor:.1f}",
            *(f"{seconds:.2f}" for seconds in each),
            f"{run.peak:.0f}",
            f"{1e6 * found['residual']:.3f}",
            f"{1e6 * found['apart']:.3f}",
            f"{100.0 * found['softness']:.3f} %",
        )
    console = Console(width=130)
    console.print(table)
    for line in written:
        console.print(line, highlight=False)


def main() -> int:
    """Run all, print all; the exit status."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        ec.save_robot(actual_arm(ec.load_robot(ROBOT_FILE)), folder / "actual.toml")
        files, written = {}, []
        for poses in (FEW, MANY):
            files[poses], clock, peak = simulate(folder, poses)
            size = files[poses].stat().st_size / 1e6
            written.append(
                f"simulate -o FILE.parquet: {poses:,} poses, {clock:.0f} s, peak {peak:.0f} MB, {size:.0f} MB"
            )
        asked = [(FEW, "in memory"), (FEW, "in parts"), (MANY, "in parts")]
        runs = [measured(files[poses], poses, how) for poses, how in asked]
    _, few, many = runs
    growth = (many.processor / MANY) / (few.processor / FEW)
    bars = [
        (f"peak memory of {MANY:,} poses [MB]", many.peak, MEMORY),
        (f"CPU time per pose, {MANY:,} / {FEW:,}", growth, 1.0),
    ]
    written += [f"{what}: {value:.3g}, bar {bar:g}" for what, value, bar in bars]
    written.append(
        "off: of the identified from the actual robot, mean over 2,000 unseen poses; compliance: the worst of four"
    )
    show(runs, written)
    return 0 if all(value <= bar for _, value, bar in bars) else 1


if __name__ == "__main__":
    if len(sys.argv) == 3:
        fit(Path(sys.argv[1]), sys.argv[2])
    else:
        sys.exit(main())
