"""Where a command's work runs: here, on local processes, or on a Dask cluster."""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager

from elastocal.errors import InputError

SCHEDULER = "ELASTOCAL_SCHEDULER"
"""In the environment: the address of a scheduler, for commands that are given none."""


def cores() -> int:
    """How many processes this one may keep busy."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def workers(
    jobs: int | None, scheduler: str | None, preload: str = "elastocal.identification", spread: bool = True
) -> Iterator[Executor | None]:
    """The executor that options ask for; None: here, one after the other.

    Args:
        jobs: local processes; None: as many as there are cores.
        scheduler: address of a Dask scheduler; None: that of the environment, unless `jobs` is given.
        preload: a module that the work needs.
        spread: whether there is anything to spread.

    Raises:
        InputError: both are given, or the cluster cannot do the work.
    """
    from elastocal.parallel import Cluster, LocalProcesses

    if jobs is not None and scheduler is not None:
        raise InputError("--jobs is of local processes, --scheduler of a cluster: give one of the two")
    address = scheduler or (os.environ.get(SCHEDULER) if jobs is None else None)
    count = cores() if jobs is None else jobs
    if spread and address:
        with Cluster(address) as cluster:
            yield cluster
    elif spread and count > 1:
        with LocalProcesses(count, preload) as processes:
            yield processes
    else:
        yield None
