"""A Dask cluster as an executor."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Callable
from concurrent.futures import Executor, Future
from importlib import import_module
from importlib.metadata import version
from types import TracebackType
from typing import Any

from elastocal.errors import InputError, WorkerLostError

PATIENCE = 5.0
"""A scheduler answers within so many seconds, or there is none."""

KILLED = "it cost several workers their lives: does it need too much memory?"


class Cluster(Executor):
    """An executor on the workers of a Dask cluster.

    What a lost worker was at work on, the scheduler gives to another one. A task that has cost several workers their
    lives fails with WorkerLostError.

    Attributes:
        address: of the scheduler, tcp://HOST:PORT.
        workers: how many tasks run at a time.

    Raises:
        InputError: Dask is not installed, no scheduler answers, it has no workers, or they have another elastocal.
    """

    def __init__(self, address: str) -> None:
        self.address = address
        self._client = _client(address)
        try:
            self.workers = self._checked_workers()
        except BaseException:
            self._client.close()
            raise
        self._inner: Executor = self._client.get_executor()

    def _checked_workers(self) -> int:
        """How many tasks run at a time, if the workers can do the work.

        Raises:
            InputError: they cannot.
        """
        found = self._client.nthreads()
        if not found:
            raise InputError(
                f"scheduler {self.address} has no workers: start some with `dask worker {self.address} --nthreads 1`"
            )
        own = version("elastocal")
        told = self._client.run(_version, on_error="return")
        faults = [
            f"worker {worker} has elastocal {other}, expected {own}, as here: install it there"
            if isinstance(other, str)
            else f"worker {worker} has no elastocal: install version {own} there, as here"
            for worker, other in told.items()
            if other != own
        ]
        if faults:
            raise InputError(*faults)
        return sum(found.values())

    def submit(self, function: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Have a function run; both it and its arguments are pickled."""
        outer: Future[Any] = Future()
        inner = self._inner.submit(function, *args, **kwargs)

        def ended(done: Future[Any]) -> None:
            if done.cancelled() or not outer.set_running_or_notify_cancel():
                outer.cancel()
                outer.set_running_or_notify_cancel()
                return
            error = done.exception()
            if error is None:
                outer.set_result(done.result())
            elif type(error).__name__ == "KilledWorker":
                outer.set_exception(WorkerLostError(KILLED))
            else:
                outer.set_exception(error)

        outer.add_done_callback(lambda future: inner.cancel() if future.cancelled() else None)
        inner.add_done_callback(ended)
        return outer

    def share(self, value: object) -> object:
        """Send a value to the cluster once; what is returned stands for it among the arguments of `submit`.

        It is the result of a task, so that the scheduler can make it again when the workers that hold it are lost.
        """
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that it may be large
            return self._client.submit(_itself, value, pure=False)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Leave the cluster, after what it has to do if `wait`; it goes on running."""
        self._inner.shutdown(wait=wait and not cancel_futures)
        self._client.close()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Leave the cluster: at once if something went wrong."""
        self.shutdown(wait=kind is None)


def _client(address: str) -> Any:
    """A client of the scheduler there."""
    try:
        connect: Any = import_module("distributed").Client  # imported late: it is large, and few need it
    except ImportError:
        raise InputError("a cluster needs Dask: install it with python -m pip install 'elastocal[cluster]'") from None
    for name in ("distributed", "distributed.client", "tornado.application"):
        logging.getLogger(name).setLevel(logging.CRITICAL)  # what they say of lost workers is said here
    try:
        return connect(address, timeout=PATIENCE)
    except (OSError, TimeoutError):
        raise InputError(
            f"scheduler {address}: none answers there within {PATIENCE:g} s: start one with `dask scheduler`, and give "
            "the address that it prints, as tcp://192.168.0.10:8786"
        ) from None
    except ValueError as error:
        raise InputError(f"scheduler {address}: expected an address as tcp://HOST:PORT: {error}") from None


def _version() -> str:
    return version("elastocal")


def _itself(value: object) -> object:
    return value
