"""One process for each fit; what is done is kept."""

from __future__ import annotations

import csv
import hashlib
import json
import math
import os
import subprocess
import tempfile
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, fields
from pathlib import Path

from environments import Environment
from tools import ENDED, HERE, Tool

SECONDS = 900
"""That one fit may take."""

BATCH = 16
"""So many arms at most are fitted by processes forked from one that has loaded the tool."""

THREADS = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


@dataclass(frozen=True)
class Result:
    """One fit.

    Attributes:
        tool, setting, law, seed: which.
        status: "done" or "failed".
        mean, largest: of the held-out errors [mm].
        fit_seconds: of the processor, for reading the files and fitting.
        process_seconds: of the processor, from the start of Python to the predictions.
        note: what the tool says, or why it failed.
    """

    tool: str
    setting: str
    law: str
    seed: int
    status: str
    mean: float
    largest: float
    fit_seconds: float
    process_seconds: float
    note: str


@dataclass(frozen=True, eq=False)
class Job:
    """A fit to do, and where its result is kept."""

    tool: Tool
    setting: str
    law: str
    seed: int
    environment: Environment
    arm: Path
    kept: Path


def run_all(jobs: Sequence[Job], workers: int, on_done: Callable[[int, int], None]) -> list[Result]:
    """Run jobs side by side, each in a process of its own; kept results are used again."""
    found = {job: result for job in jobs if (result := _kept(job)) is not None}
    on_done(len(found), len(jobs))

    def run(batch: list[Job]) -> None:
        for job, result in run_batch(batch):
            _keep(job, result)
            found[job] = result
            on_done(len(found), len(jobs))

    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(run, _batches([job for job in jobs if job not in found])))
    return [found[job] for job in jobs]


def _batches(jobs: Iterable[Job]) -> list[list[Job]]:
    """Jobs of one setting of one tool together, in their order, at most BATCH of them."""
    batches: dict[tuple[str, str, int], list[Job]] = {}
    counted: Counter[tuple[str, str]] = Counter()
    for job in jobs:
        which = (job.tool.name, job.setting)
        batches.setdefault((*which, counted[which] // BATCH), []).append(job)
        counted[which] += 1
    return list(batches.values())


def _kept(job: Job) -> Result | None:
    """The kept result, unless the script, the arm or what is installed has changed."""
    if not job.kept.exists():
        return None
    kept = json.loads(job.kept.read_text(encoding="utf-8"))
    return Result(**kept["result"]) if kept["mark"] == _mark(job) else None


def _keep(job: Job, result: Result) -> None:
    job.kept.parent.mkdir(parents=True, exist_ok=True)
    part = job.kept.with_name(f"{job.kept.name}.{os.getpid()}")
    part.write_text(json.dumps({"mark": _mark(job), "result": asdict(result)}), encoding="utf-8")
    part.replace(job.kept)


def _mark(job: Job) -> str:
    digest = hashlib.sha256(job.environment.mark.encode())
    for path in (job.tool.script, HERE / "exchange.py", *sorted(job.arm.iterdir())):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def run_batch(batch: Sequence[Job]) -> Iterator[tuple[Job, Result]]:
    """Fit arms with one setting of one tool, which is loaded once; each as soon as it is there."""
    first, waiting = batch[0], {job.arm.name: job for job in batch}
    if first.environment.error:
        yield from ((job, _failed(job, f"not installed: {first.environment.error}")) for job in batch)
        return
    with tempfile.TemporaryDirectory(prefix="elastocal-peers-") as name:
        scratch = Path(name)
        command = [
            first.environment.python,
            first.tool.script,
            first.setting,
            scratch,
            SECONDS,
            *(j.arm for j in batch),
        ]
        with (scratch / "messages").open("w+", encoding="utf-8") as messages:
            with subprocess.Popen(
                [str(part) for part in command],
                stdout=subprocess.PIPE,
                stderr=messages,
                text=True,
                cwd=scratch,
                env={**os.environ, **THREADS},
            ) as process:
                for line in process.stdout or ():
                    if line.startswith(ENDED):
                        job = waiting.pop(line.removeprefix(ENDED).strip())
                        yield job, _judged(job, scratch / job.arm.name)
            messages.seek(0)
            last = (messages.read().strip().splitlines() or ["no message"])[-1]
        yield from ((job, _failed(job, last)) for job in waiting.values())


def _failed(job: Job, note: str) -> Result:
    return Result(job.tool.name, job.setting, job.law, job.seed, "failed", *[math.nan] * 4, note)


def _judged(job: Job, scratch: Path) -> Result:
    """What an arm's process left behind."""
    if (scratch / "error.txt").exists():
        return _failed(job, (scratch / "error.txt").read_text(encoding="utf-8").splitlines()[0])
    if not (scratch / "outcome.json").exists():
        return _failed(job, f"killed, or not done after {SECONDS} s")
    outcome = json.loads((scratch / "outcome.json").read_text(encoding="utf-8"))
    mean, largest = errors(outcome["predicted"], read_points(job.arm / "truth.csv"))
    if not math.isfinite(mean):
        return _failed(job, "predictions are not finite")
    return Result(
        job.tool.name,
        job.setting,
        job.law,
        job.seed,
        "done",
        round(mean, 6),
        round(largest, 6),
        round(outcome["fit_seconds"], 4),
        round(outcome["process_seconds"], 3),
        "; ".join(outcome["notes"]),
    )


def errors(predicted: Iterable[Sequence[float]], truth: Iterable[Sequence[float]]) -> tuple[float, float]:
    """Mean and largest distance [mm] of points [m]."""
    distances = [1e3 * math.dist(p, t) for p, t in zip(predicted, truth, strict=True)]
    return sum(distances) / len(distances), max(distances)


def read_points(path: Path) -> list[list[float]]:
    """The numbers below a CSV file's header."""
    return [[float(value) for value in line.split(",")] for line in path.read_text(encoding="utf-8").split()[1:]]


def write_results(path: Path, results: Iterable[Result]) -> None:
    """Write a CSV file, one row a fit."""
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.DictWriter(stream, [field.name for field in fields(Result)], lineterminator="\n")
        writer.writeheader()
        writer.writerows(asdict(result) for result in results)


def read_results(path: Path) -> list[Result]:
    """Read what `write_results` wrote."""
    numbers = ("mean", "largest", "fit_seconds", "process_seconds")
    with path.open(encoding="utf-8", newline="") as stream:
        return [
            Result(**{**row, "seed": int(row["seed"]), **{name: float(row[name]) for name in numbers}})  # type: ignore[arg-type]
            for row in csv.DictReader(stream)
        ]
