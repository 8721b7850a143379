"""Throughput and memory of compensation: `python benchmarks/compensate.py`, on an idle machine.

Times are of the processor, the least of several runs, on one thread, and stand beside that of one forward pass with
Jacobian (`Model.parts`) of the same rows; exit status 1 if a bar is missed.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = os.environ["OMP_NUM_THREADS"] = "1"

import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import polars as pl
from rich.console import Console
from rich.table import Table
from scipy.spatial.transform import Rotation

import elastocal as ec
from elastocal.compensation import Targets
from elastocal.examples import ROBOT_FILE, actual_arm
from elastocal.parameters import parameters_of
from elastocal.prediction import Model
from elastocal.robot import Compliance, Frame, Robot

BAR = 60.0
MEMORY = 500.0


def fastest(function: Callable[[], object], runs: int) -> float:
    """Seconds of processor time of the fastest of several runs."""
    times = []
    for _ in range(runs):
        began = time.process_time()
        function()
        times.append(time.process_time() - began)
    return min(times)


def robots() -> tuple[Robot, Robot]:
    """The nominal example arm and the actual one with hinges, both on the same base with the same tool."""
    nominal = ec.load_robot(ROBOT_FILE)
    here = Frame((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), known=True)
    actual = replace(actual_arm(nominal), base=here, targets={})
    laws = {"2.theta": Compliance("hinge", (4e-6, 2e-6), 150.0), "3.theta": Compliance("linear", (5e-6,))}
    return replace(nominal, base=here, tool=actual.tool, targets={}), replace(actual, elastic=laws)


def throughput(count: int) -> list[tuple[str, float, float]]:
    """Times of one target over those of one pass, for each kind of target."""
    nominal, actual = robots()
    q = ec.random_poses(nominal, count, 1)
    positions, rotations = ec.predict(nominal, q)
    data = ec.simulate(actual, q, kinds=("position", "orientation"))
    names = tuple(parameters_of(actual))
    model, zero = Model(actual, names, data), np.zeros(len(names))
    one = fastest(lambda: list(model.parts(zero)), 9)
    rows = [
        (f"one pass of {count} rows with Jacobian, {len(names)} parameters [µs per row]", 1e6 * one / count, np.inf)
    ]
    kinds = {
        "joint program": Targets(q=q),
        "poses": Targets(positions, rotations),
        "points": Targets(positions),
    }
    for name, targets in kinds.items():
        found = fastest(lambda: ec.compensate(actual, targets, nominal=nominal), 5)  # noqa: B023
        rows.append((f"{count} targets, {name} [µs per target]", 1e6 * found / count, np.inf))
        rows.append((f"{count} targets, {name} / one pass", found / one, BAR))
    return rows


def long_run(count: int) -> list[tuple[str, float, float]]:
    """The command on long tables: time and peak memory of the whole process."""
    nominal, actual = robots()
    q = ec.random_poses(nominal, count, 2)
    poses = ec.predict(nominal, q[: count // 10])
    tables = {
        "joint positions": ("out.csv", {f"q{i}": values for i, values in enumerate(q.T, start=1)}),
        "poses": ("out.parquet", pose_columns(*poses)),
    }
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        ec.save_robot(nominal, here / "robot.toml")
        ec.save_robot(actual, here / "actual.toml")
        for kind, (out, columns) in tables.items():
            frame = pl.DataFrame(columns)
            frame.write_csv(here / "targets.csv")
            seconds, peak = command(here, out)
            written = pl.scan_csv(here / out) if out.endswith("csv") else pl.scan_parquet(here / out)
            assert written.select(pl.len()).collect().item() == frame.height
            rows.append((f"command, {frame.height} {kind} to {out} [s]", seconds, np.inf))
            rows.append(("    peak memory of the process [MB]", peak, MEMORY))
    return rows


def pose_columns(positions: np.ndarray, rotations: np.ndarray) -> dict[str, np.ndarray]:
    """A table of targets, SI."""
    quaternions = Rotation.from_matrix(rotations).as_quat()
    columns = dict(zip("xyz", positions.T, strict=True))
    return columns | dict(zip(("qx", "qy", "qz", "qw"), quaternions.T, strict=True))


def command(here: Path, out: str) -> tuple[float, float]:
    """Seconds of processor time and peak memory [MB] of one command; Linux."""
    script = (
        "import re, sys, time; from pathlib import Path; from elastocal.cli.main import main; "
        f"main(['compensate', 'actual.toml', 'targets.csv', '--nominal', 'robot.toml', '-o', '{out}']); "
        "peak = re.search(r'VmHWM:\\s*(\\d+)', Path('/proc/self/status').read_text())[1]; "
        "print(time.process_time(), int(peak) / 1024, file=sys.stderr)"
    )
    ran = subprocess.run([sys.executable, "-c", script], cwd=here, capture_output=True, text=True, check=True)
    seconds, peak = map(float, ran.stderr.split()[-2:])
    return seconds, peak


def main() -> int:
    """Run all, print a table, say whether every bar is kept."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    rows = [row for size in (1000, 10_000) for row in throughput(size)] + long_run(count)
    table = Table("figure", "found", "bar", title=f"NumPy {np.__version__}, one thread")
    for name, found, bar in rows:
        shown = f"[{'green' if found <= bar else 'red'}]{found:.4g}"
        table.add_row(name, shown, f"≤ {bar:g}" if np.isfinite(bar) else "")
    Console(width=110).print(table)
    return int(any(found > bar for _, found, bar in rows))


if __name__ == "__main__":
    sys.exit(main())
