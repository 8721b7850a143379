"""A Dask cluster of real processes on this machine, started as docs/cluster.md says."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from elastocal.errors import InputError
from elastocal.parallel import Cluster

PATIENCE = 180.0
"""Seconds in which a cluster must be there."""


@dataclass
class RunningCluster:
    """A scheduler with workers.

    Attributes:
        address: of the scheduler.
        scheduler: its process.
        workers: their processes, started by `dask worker --no-nanny`, so that a killed one stays dead.
    """

    address: str
    scheduler: subprocess.Popen[bytes]
    workers: list[subprocess.Popen[bytes]]


@contextmanager
def cluster(workers: int, folder: Path) -> Iterator[RunningCluster]:
    """A scheduler and workers of one thread each; tests/ is importable there."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    port = address.rpartition(":")[2]
    dask = str(Path(sys.executable).with_name("dask"))
    tests = str(Path(__file__).parents[1])
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([tests, os.environ.get("PYTHONPATH", "")])}
    started = []

    def start(*command: str) -> subprocess.Popen[bytes]:
        log = (folder / f"dask-{len(started)}.log").open("wb")
        with log:
            started.append(subprocess.Popen([dask, *command], cwd=folder, env=environment, stdout=log, stderr=log))
        return started[-1]

    try:
        scheduler = start("scheduler", "--host", "127.0.0.1", "--port", port, "--no-dashboard")
        own = (
            "--nthreads",
            "1",
            "--no-dashboard",
            "--no-nanny",
            "--death-timeout",
            "60",
            "--local-directory",
            str(folder),
        )
        found = RunningCluster(address, scheduler, [start("worker", address, *own) for _ in range(workers)])
        _wait(found, workers)
        yield found
    finally:
        for process in started:
            process.kill()
        for process in started:
            process.wait()


def _wait(found: RunningCluster, workers: int) -> None:
    end = time.monotonic() + PATIENCE
    while True:
        try:
            with Cluster(found.address) as there:
                if there.workers == workers:
                    return
        except InputError:
            pass
        if time.monotonic() > end:
            raise TimeoutError(f"no cluster of {workers} workers at {found.address} after {PATIENCE:g} s")
        time.sleep(0.2)
