"""Fleets and studies here, on processes and on a cluster: `python benchmarks/parallel.py [CALIBRATIONS] [ROBOTS]`.

On an idle machine with two cores. A cluster of one scheduler and two worker processes on 127.0.0.1 is started as
docs/cluster.md says. Results must be the same bit for bit in all parameters; a worker is killed half-way, and the
command is killed half-way and started again. The last result is in parallel.txt; exit status 1 if a bar is missed.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import polars as pl

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from elastocal.identification import calibrate
from elastocal.io.study_files import read_study
from elastocal.studies.item import Calibrations, Lot, options_of, simulated
from elastocal.studies.run import TOGETHER
from support.clusters import cluster
from support.fleets import save_fleet

CALIBRATIONS, ROBOTS = 2000, 200

STUDY = """\
format = "elastocal-study/1"
name = "benchmark"
repeats = {repeats}
[actual]
geometry_error = "1mm,1mrad"
[actual.elastic.2]
compliance = [1.5e-6, 3e-6]
[actual.elastic.3]
compliance = [3e-6, 6e-6]
[setting]
noise = "0.03mm"
poses = 45
[grid]
law = ["linear"]
"""

COMMAND = [sys.executable, "-m", "elastocal"]
rows: list[tuple[str, str, str, bool]] = []


def told(what: str, found: str, bar: str, kept: bool) -> None:
    """Print a figure beside its bar."""
    rows.append((what, found, bar, kept))
    print(f"{what:66} {found:>16}   {bar:12} {'kept' if kept else 'MISSED'}", flush=True)


def timed(folder: Path, *arguments: str) -> float:
    """Seconds that a command takes."""
    began = time.perf_counter()
    subprocess.run([*COMMAND, *arguments], cwd=folder, check=True, capture_output=True)
    return time.perf_counter() - began


def killed(folder: Path, pattern: str, count: int, *arguments: str) -> dict[Path, int]:
    """Kill a command (kill -9) once so many results are there; when they were written."""
    process = subprocess.Popen([*COMMAND, *arguments], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while len(list(folder.glob(pattern))) < count:
        time.sleep(0.01)
    process.send_signal(signal.SIGKILL)
    process.wait()
    return {path: path.stat().st_mtime_ns for path in folder.glob(pattern)}


def results(folder: Path) -> pl.DataFrame:
    """A study's results, but for the time that they took."""
    return pl.scan_parquet(folder / "parts" / "*.parquet").sort("cell", "repeat").collect().drop("seconds")


def parameters(folder: Path) -> dict[str, object]:
    """Every number that a fleet's calibrations identified."""
    found = {str(path.relative_to(folder)): json.loads(path.read_text()) for path in folder.rglob("result.json")}
    return {name: (values["parameters"], values["covariance"]) for name, values in found.items()}


def overhead(folder: Path, calibrations: int) -> None:
    """A study on one process against its bare calibrations, and on two against one; side by side, in turn.

    Processor time says what the work costs, whoever else is at work on the machine; elapsed time what is gained.
    """
    study = read_study(folder / "study.toml")
    work, bare, whole = Calibrations.of(study), 0.0, 0.0
    for first in range(0, min(calibrations, 400), TOGETHER):
        lot = Lot(study.settings[0], tuple(range(first, first + TOGETHER)))
        made = [simulated(study, lot, repeat, work.reach) for repeat in lot.repeats]
        began = time.process_time()
        for one in made:
            calibrate(study.robot, one.data, held_out=one.held_out, **options_of(study, lot.setting, one.actual))
        between = time.process_time()
        work(lot)
        bare += between - began
        whole += time.process_time() - between
    ratio = whole / bare
    told("one process / sum of bare calibrate() calls, processor time", f"{ratio:.3f}", "<= 1.15", ratio <= 1.15)
    one = timed(folder, "study", "study.toml", "-o", "one", "--jobs", "1")
    two = timed(folder, "study", "study.toml", "-o", "two", "--jobs", "2")
    told(f"{calibrations} calibrations of 45 poses: one process / two", f"{one:.1f} s / {two:.1f} s", "", True)
    told("as many times as fast on two processes", f"{one / two:.2f}", ">= 1.8", one / two >= 1.8)
    same = results(folder / "one").equals(results(folder / "two"))
    told("two processes give the same, bit for bit", str(same), "True", same)


def on_cluster(folder: Path, address: str, name: str) -> None:
    """Study and fleet on a cluster equal those here."""
    seconds = timed(folder, "study", "study.toml", "-o", f"study-{name}", "--scheduler", address)
    same = results(folder / "one").equals(results(folder / f"study-{name}"))
    told(f"study on the {name}, {seconds:.1f} s: the same, bit for bit", str(same), "True", same)
    seconds = timed(folder, "fleet", "fleet.csv", "-o", f"fleet-{name}", "--scheduler", address)
    same = parameters(folder / "fleet") == parameters(folder / f"fleet-{name}")
    told(f"fleet on the {name}, {seconds:.1f} s: the same, bit for bit", str(same), "True", same)


def worker_killed(folder: Path) -> None:
    """A worker is killed half-way through a study."""
    with cluster(2, folder) as running:
        line = [*COMMAND, "study", "study.toml", "-o", "half", "--scheduler", running.address]
        process = subprocess.Popen(line, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        parts = len(list((folder / "one" / "parts").iterdir()))
        while len(list(folder.glob("half/parts/*.parquet"))) < parts // 2:
            time.sleep(0.01)
        running.workers[0].send_signal(signal.SIGKILL)
        process.wait()
    same = process.returncode == 0 and results(folder / "one").equals(results(folder / "half"))
    told("a worker of two killed half-way: nothing lost or counted twice", str(same), "True", same)


def command_killed(folder: Path, robots: int) -> None:
    """The command is killed half-way and started again."""
    parts = len(list((folder / "one" / "parts").iterdir()))
    before = killed(folder, "again/parts/*.parquet", parts // 2, "study", "study.toml", "-o", "again", "--jobs", "2")
    timed(folder, "study", "study.toml", "-o", "again", "--jobs", "2")
    kept = all(path.stat().st_mtime_ns == when for path, when in before.items())
    same = kept and results(folder / "one").equals(results(folder / "again"))
    told(f"study killed after {len(before)} of {parts} parts: none repeated, same results", str(same), "True", same)
    before = killed(folder, "fleet-again/*/*/result.json", robots // 2, "fleet", "fleet.csv", "-o", "fleet-again")
    timed(folder, "fleet", "fleet.csv", "-o", "fleet-again")
    kept = all(path.stat().st_mtime_ns == when for path, when in before.items())
    same = kept and parameters(folder / "fleet") == parameters(folder / "fleet-again")
    told(f"fleet killed after {len(before)} of {robots} rows: none repeated, same results", str(same), "True", same)


def faulty_row(folder: Path, robots: int) -> None:
    """One faulty row stops no other."""
    (folder / "0-2025-03-01.csv").write_text("q1,x\n1,2\n")
    ran = subprocess.run([*COMMAND, "fleet", "fleet.csv", "-o", "faulty"], cwd=folder, capture_output=True, check=False)
    done = len(list((folder / "faulty").glob("*/*/result.json")))
    good = ran.returncode == 1 and done == robots - 1 and b"S000" in ran.stdout
    told(f"one faulty row of {robots}: done, exit status", f"{done}, {ran.returncode}", f"{robots - 1}, 1", good)


def main(arguments: list[str]) -> int:
    """Run all; say whether every bar is kept."""
    calibrations, robots = (int(text) for text in (*arguments, *map(str, (CALIBRATIONS, ROBOTS)[len(arguments) :])))
    print(f"{calibrations} calibrations, {robots} robots, {os.cpu_count()} cores")
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        (folder / "study.toml").write_text(STUDY.format(repeats=calibrations))
        save_fleet(folder, robots)
        overhead(folder, calibrations)
        seconds = timed(folder, "fleet", "fleet.csv", "-o", "fleet", "--jobs", "1")
        told(f"fleet of {robots} robots on one process", f"{seconds:.1f} s", "", True)
        with cluster(2, folder) as running:
            on_cluster(folder, running.address, "cluster")
        worker_killed(folder)
        command_killed(folder, robots)
        faulty_row(folder, robots)
    return int(not all(kept for *_, kept in rows))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
