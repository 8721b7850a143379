"""Benchmark against the peers: `python benchmarks/peers/run.py`.

Installs each tool in a virtual environment of its own, simulates the arms, fits every arm with every setting of every
tool, and writes results.csv and versions.json beside this file, docs/benchmarks.md and docs/images/benchmarks.svg.
What is done is kept in the work folder: a run that was stopped goes on where it was. Standard library only.
"""

from __future__ import annotations

import argparse
import datetime
import hashlib
import json
import os
import platform
import subprocess
import sys
from pathlib import Path

from environments import Environment, environment
from figure import figure
from page import page
from runs import Job, Result, errors, read_points, read_results, run_all, write_results
from tools import HERE, SOURCE, TOOLS

LAWS = ("rigid", "linear", "step", "hinge")
SEEDS = 20
RESULTS, VERSIONS = HERE / "results.csv", HERE / "versions.json"
PAGE, FIGURE = SOURCE / "docs" / "benchmarks.md", SOURCE / "docs" / "images" / "benchmarks.svg"


def default_work() -> Path:
    """The cache folder."""
    return Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "elastocal-peers"


def make_arms(elastocal: Environment, folder: Path, seeds: int) -> None:
    """Simulate the arms, by elastocal's environment."""
    made_by = b"".join((HERE / name).read_bytes() for name in ("arms.py", "urdf.py"))
    mark = f"{elastocal.mark}, {hashlib.sha256(made_by).hexdigest()}"
    command = [str(elastocal.python), str(HERE / "arms.py"), str(folder), str(seeds), mark]
    subprocess.run(command, check=True)


def jobs_of(environments: dict[str, Environment], work: Path, seeds: int) -> list[Job]:
    """All fits, those of a tool spread among the others', so that all see the same machine; few-seed settings last."""
    jobs = [
        Job(
            tool,
            setting,
            law,
            seed,
            environments[tool.name],
            work / "arms" / f"{law}-{seed:02d}",
            work / "results" / f"{tool.name}, {setting}, {law}, {seed}.json",
        )
        for seed in range(seeds)
        for law in LAWS
        for tool in TOOLS
        for setting, count in tool.settings.items()
        if seed < count
    ]
    return sorted(jobs, key=lambda job: job.tool.settings[job.setting], reverse=True)


def nominal_results(work: Path, seeds: int) -> list[Result]:
    """The nominal robot where it stands: no calibration at all."""
    found = []
    for law in LAWS:
        for seed in range(seeds):
            arm = work / "arms" / f"{law}-{seed:02d}"
            mean, largest = errors(read_points(arm / "nominal.csv"), read_points(arm / "truth.csv"))
            found.append(
                Result("nominal", "aligned", law, seed, "done", round(mean, 6), round(largest, 6), 0.0, 0.0, "")
            )
    return found


def progress(done: int, total: int) -> None:
    """One line that counts."""
    if done == total or done % 10 == 0:
        print(f"\r{done} of {total} fits", end="\n" if done == total else "", file=sys.stderr, flush=True)


def measure(work: Path, workers: int, seeds: int) -> tuple[list[Result], dict]:
    """Install, simulate, fit."""
    environments = {tool.name: environment(tool, work / "environments" / tool.name) for tool in TOOLS}
    for name, found in environments.items():
        if found.error:
            print(f"{name} could not be installed: {found.error}", file=sys.stderr)
    make_arms(environments["elastocal"], work / "arms", seeds)
    results = nominal_results(work, seeds) + run_all(jobs_of(environments, work, seeds), workers, progress)
    order = {name: i for i, name in enumerate(("nominal", *(tool.name for tool in TOOLS)))}
    results.sort(key=lambda r: (order[r.tool], r.setting, LAWS.index(r.law), r.seed))
    versions = {
        "date": datetime.date.today().isoformat(),
        "python": platform.python_version(),
        "machine": f"{platform.system()} {platform.machine()}, {os.cpu_count()} cores",
        "workers": workers,
        "tools": {name: {"versions": found.versions, "error": found.error} for name, found in environments.items()},
    }
    return results, versions


def stored() -> tuple[list[Result], dict]:
    """The last full run."""
    return read_results(RESULTS), json.loads(VERSIONS.read_text(encoding="utf-8"))


def main() -> int:
    """Run, write, say where."""
    parser = argparse.ArgumentParser(description="Benchmark elastocal against figaroh, robotkinecal and pybotics.")
    parser.add_argument("--work", type=Path, default=default_work(), help="environments, arms, kept results")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="fits side by side")
    parser.add_argument("--seeds", type=int, default=SEEDS, help="fewer for a trial, which writes only to WORK")
    parser.add_argument("--render", action="store_true", help="page and figure anew from results.csv")
    given = parser.parse_args()
    if not given.render:
        results, versions = measure(given.work.resolve(), given.jobs, given.seeds)
        place = HERE if given.seeds == SEEDS else given.work
        write_results(place / RESULTS.name, results)
        (place / VERSIONS.name).write_text(json.dumps(versions, indent=1) + "\n", encoding="utf-8")
        if given.seeds != SEEDS:
            print(f"a trial of {given.seeds} seeds: see {place / RESULTS.name}")
            return 0
    results, versions = stored()
    FIGURE.parent.mkdir(parents=True, exist_ok=True)
    FIGURE.write_text(figure(results), encoding="utf-8")
    PAGE.write_text(page(results, versions), encoding="utf-8")
    print(f"written: {PAGE}, {FIGURE}")
    return int(any(found["error"] for found in versions["tools"].values()))


if __name__ == "__main__":
    sys.exit(main())
