"""One function on many items, on any executor: results in the order of the items, or as they come."""

from __future__ import annotations

import hashlib
import pickle
from collections import OrderedDict
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Executor, Future, wait
from itertools import islice
from typing import Any, TypeVar

from elastocal.errors import ClusterLostError, WorkerLostError

Item = TypeVar("Item")
Result = TypeVar("Result")

Numbered = tuple[int, Any]

AHEAD = 2
"""So many tasks for each worker are handed over at a time: one runs, the next waits."""

FUNCTIONS_KEPT = 8
"""So many functions, with all that they hold, a worker keeps unpacked."""


def width(executor: Executor | None) -> int:
    """How many items an executor works on at a time; 1 if there is none, 4 if it does not say."""
    if executor is None:
        return 1
    found = getattr(executor, "workers", None) or getattr(executor, "_max_workers", None)
    return int(found or 4)


def in_order(
    function: Callable[[Item], Result], items: Sequence[Item], executor: Executor | None = None, chunk: int = 0
) -> Iterator[Result]:
    """The function of each item, in the order of the items.

    Args:
        function: that can be pickled, with all that it holds: it is sent once, not with each item.
        items: which can be pickled.
        executor: where it runs; None: here, one after the other.
        chunk: so many items go together; 0: such that each worker gets about four lots.
    """
    chunk = chunk or max(1, -(-len(items) // (4 * width(executor))))
    early: dict[int, Result] = {}
    expected = 0
    for number, result in completed(function, items, executor, chunk=chunk):
        early[number] = result
        while expected in early:
            yield early.pop(expected)
            expected += 1


def completed(
    function: Callable[[Item], Result],
    items: Iterable[Item],
    executor: Executor | None = None,
    *,
    chunk: int = 1,
    lost: Callable[[Item, WorkerLostError], Result] | None = None,
) -> Iterator[tuple[int, Result]]:
    """The number of each item and the function of it, as they come; items are drawn as workers need them.

    Which items go together, and where they run, changes no result. If the iteration is left or interrupted, what has
    not begun is cancelled.

    Args:
        function: that can be pickled, with all that it holds: it is sent once, not with each item.
        items: which can be pickled.
        executor: where it runs; None: here, one after the other.
        chunk: so many items go together.
        lost: the result of an item that has cost several workers their lives; None: that is raised.

    Raises:
        WorkerLostError: an item has cost several workers their lives.
        ClusterLostError: the scheduler of a cluster is gone.
    """
    if executor is None:
        for number, item in enumerate(items):
            yield number, function(item)
        return
    packed = _packed(function, executor)
    numbered = enumerate(items)
    lots = iter(lambda: list(islice(numbered, chunk)), [])
    running: dict[Future[list[Result]], list[tuple[int, Item]]] = {}
    try:
        while True:
            for lot in islice(lots, max(0, AHEAD * width(executor) - len(running))):
                running[_submitted(executor, packed, lot)] = lot
            if not running:
                return
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                lot = running.pop(future)
                results = _outcome(future, lot, lost)
                if results is None:  # one of them is to blame: each by itself
                    running |= {_submitted(executor, packed, [one]): [one] for one in lot}
                else:
                    yield from zip((number for number, _ in lot), results, strict=True)
    finally:
        for future in running:
            future.cancel()


def _packed(function: Callable[..., Any], executor: Executor) -> tuple[str, Any]:
    """The function as bytes with a name for them; on a cluster, where these are."""
    content = pickle.dumps(function, protocol=pickle.HIGHEST_PROTOCOL)
    share = getattr(executor, "share", None)
    return hashlib.sha256(content).hexdigest(), share(content) if share else content


def _submitted(executor: Executor, packed: tuple[str, Any], lot: Sequence[Numbered]) -> Future[list[Any]]:
    name, content = packed
    return executor.submit(_work, name, content, [item for _, item in lot])


def _outcome(
    future: Future[list[Result]],
    lot: Sequence[tuple[int, Item]],
    lost: Callable[[Item, WorkerLostError], Result] | None,
) -> list[Result] | None:
    """The results of a lot; None if it lost its workers and its items are to be tried one by one.

    Raises:
        WorkerLostError: a single item lost its workers.
        ClusterLostError: the executor has given it up.
        Exception: what it raised.
    """
    try:
        return future.result()
    except CancelledError:
        raise ClusterLostError("the cluster's scheduler is gone: start it, and run the same again to go on") from None
    except WorkerLostError as error:
        if len(lot) > 1:
            return None
        if lost is None:
            raise
        return [lost(lot[0][1], error)]


_functions: OrderedDict[str, Callable[[Any], Any]] = OrderedDict()
"""What this worker has unpacked, the last used last."""


def _work(name: str, content: bytes, items: Sequence[Any]) -> list[Any]:
    """In a worker: the function of each item."""
    function = _functions.pop(name, None) or pickle.loads(content)
    _functions[name] = function
    while len(_functions) > FUNCTIONS_KEPT:
        _functions.popitem(last=False)
    return [function(item) for item in items]
