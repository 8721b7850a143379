"""Processes of this machine: what a lost one was at work on is run again, and none outlives its parent."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field
from functools import partial
from queue import SimpleQueue
from types import TracebackType
from typing import Any

from elastocal.errors import WorkerLostError

LOSSES = 2
"""After so many losses a task runs in a process of its own, so that only the one to blame is given up."""

KILLED = (
    "its process ended three times: does it need too much memory? A script that starts processes must keep its own "
    'work under `if __name__ == "__main__":`'
)


@dataclass
class _Task:
    """What was submitted, and what will become of it."""

    function: Callable[..., Any]
    args: tuple[Any, ...]
    kwargs: dict[str, Any]
    future: Future[Any] = field(default_factory=Future)
    losses: int = 0


class LocalProcesses(Executor):
    """An executor on processes of this machine.

    A process that is killed breaks a pool of the standard library: all that it had to do fails. Here a new pool takes
    over. A task whose processes were lost three times, the last time alone in its own, fails with WorkerLostError.

    Attributes:
        workers: how many processes.
        preload: a module that they have imported when they begin.
    """

    def __init__(self, workers: int, preload: str = "elastocal.identification") -> None:
        self.workers = workers
        self.preload = preload
        self._pool: ProcessPoolExecutor | None = None
        self._lock = threading.Lock()
        self._closed = False
        self._broken: SimpleQueue[tuple[_Task, ProcessPoolExecutor] | None] = SimpleQueue()
        self._mender = threading.Thread(target=self._mend, daemon=True)
        self._mender.start()

    def submit(self, function: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Have a function run; both it and its arguments are pickled."""
        task = _Task(function, args, kwargs)
        self._start(task)
        return task.future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes, after what they have to do if `wait`."""
        with self._lock:
            pool, self._closed = self._pool, True
        if pool is not None:
            pool.shutdown(wait=wait, cancel_futures=cancel_futures)
        self._broken.put(None)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the processes: at once if something went wrong."""
        if kind is not None:
            self._kill()
        self.shutdown(wait=kind is None, cancel_futures=kind is not None)

    def _kill(self) -> None:
        with self._lock:
            pool, self._closed = self._pool, True
        for process in list((getattr(pool, "_processes", None) or {}).values()):
            process.terminate()

    def _start(self, task: _Task) -> None:
        while True:
            with self._lock:
                if self._closed:
                    raise RuntimeError("the processes were shut down")
                pool = self._pool = self._pool or _pool(self.workers, self.preload)
            try:
                running = pool.submit(task.function, *task.args, **task.kwargs)
            except BrokenProcessPool:
                self._forget(pool)
                continue
            task.future.add_done_callback(partial(_cancel_too, running))
            running.add_done_callback(partial(self._ended, task, pool))
            return

    def _forget(self, pool: ProcessPoolExecutor) -> None:
        with self._lock:
            if self._pool is pool:
                self._pool = None

    def _ended(self, task: _Task, pool: ProcessPoolExecutor, running: Future[Any]) -> None:
        """Hand on what became of a task; called by the pool's thread, which must not wait for anything."""
        if running.cancelled():
            task.future.cancel()
            task.future.set_running_or_notify_cancel()
        elif task.future.cancelled() or not task.future.set_running_or_notify_cancel():
            pass
        elif isinstance(running.exception(), BrokenProcessPool) and not self._closed:
            self._broken.put((task, pool))
        else:
            _settle(task.future, running)

    def _mend(self) -> None:
        """In a thread: start again what was lost with its process."""
        while (found := self._broken.get()) is not None:
            task, pool = found
            self._forget(pool)
            lost, task.future = task.future, Future()
            task.losses += 1
            try:
                if task.losses <= LOSSES:
                    task.future.add_done_callback(partial(_settle, lost))
                    self._start(task)
                else:
                    self._alone(task, lost)
            except RuntimeError as error:
                lost.set_exception(error)

    def _alone(self, task: _Task, lost: Future[Any]) -> None:
        """Run a task in a process of its own."""
        with _pool(1, self.preload) as pool:
            running = pool.submit(task.function, *task.args, **task.kwargs)
            if isinstance(running.exception(), BrokenProcessPool):
                lost.set_exception(WorkerLostError(KILLED))
            else:
                _settle(lost, running)


def _cancel_too(running: Future[Any], cancelled: Future[Any]) -> None:
    """Cancel a future with another."""
    if cancelled.cancelled():
        running.cancel()


def _settle(future: Future[Any], ended: Future[Any]) -> None:
    """Give one future the outcome of another."""
    try:
        future.set_result(ended.result())
    except Exception as error:
        future.set_exception(error)


def _pool(workers: int, preload: str) -> ProcessPoolExecutor:
    """A pool whose processes inherit no threads: from a server that has imported what they need, if there is one."""
    server = "forkserver" in multiprocessing.get_all_start_methods()
    context = multiprocessing.get_context("forkserver" if server else "spawn")
    if server:
        context.set_forkserver_preload([preload])
    return ProcessPoolExecutor(workers, mp_context=context, initializer=_begin)


def _begin() -> None:
    """In a new process: leave ctrl-C to the parent, and end with it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
