"""One function on many items: in order, on any executor, whatever becomes of its workers."""

from __future__ import annotations

import pickle
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import elastocal as ec
from elastocal.errors import EquilibriumError, InputError, WorkerLostError
from elastocal.parallel import LocalProcesses, completed, in_order, width
from support.calibrations import measured
from support.robots import arm, placed
from support.work import Marking, fail, slow, square

LINEAR = {"2": "linear"}


@pytest.fixture(scope="module")
def processes() -> Iterator[Executor]:
    """Two processes of this machine."""
    with LocalProcesses(2) as found:
        yield found


def test_results_are_in_the_order_of_the_items(processes: Executor):
    expected = [x * x for x in range(40)]
    assert list(in_order(square, range(40))) == expected
    assert list(in_order(square, range(40), processes)) == expected
    assert list(in_order(square, range(40), processes, chunk=3)) == expected
    with ThreadPoolExecutor(3) as threads:
        assert list(in_order(square, range(40), threads)) == expected
    assert list(in_order(square, [], processes)) == []


def test_every_item_is_done_once_and_numbered(processes: Executor, tmp_path: Path):
    found = dict(completed(Marking(tmp_path), range(5, 25), processes, chunk=2))
    assert found == {i: (i + 5) ** 2 for i in range(20)}
    assert Counter(path.name for path in tmp_path.iterdir()) == {f"{x}-0": 1 for x in range(5, 25)}


def test_an_error_of_the_function_is_raised(processes: Executor):
    with pytest.raises(ValueError, match="three"):
        list(in_order(fail, range(6), processes))
    assert list(in_order(square, range(4), processes)) == [0, 1, 4, 9]


def test_a_killed_worker_loses_nothing_and_counts_nothing_twice(tmp_path: Path):
    with LocalProcesses(2) as processes:
        found = list(completed(Marking(tmp_path, once=(3, 8)), range(12), processes, chunk=2))
    assert sorted(found) == [(x, x * x) for x in range(12)]
    assert (tmp_path / "3-1").exists()
    assert (tmp_path / "8-1").exists()


def test_only_the_item_that_kills_its_workers_is_given_up(tmp_path: Path):
    with LocalProcesses(2) as processes:
        lost = dict(completed(Marking(tmp_path, always=(5,)), range(9), processes, chunk=3, lost=lambda x, _: -x))
    assert lost == {x: -5 if x == 5 else x * x for x in range(9)}
    with LocalProcesses(1) as processes, pytest.raises(WorkerLostError, match="ended three times"):
        list(completed(Marking(tmp_path, always=(5,)), [5], processes))


def test_an_iteration_that_is_left_ends_the_processes_at_once():
    def left() -> None:
        with LocalProcesses(2) as processes:
            for _ in completed(slow, [0.0, 60.0, 60.0, 60.0], processes):
                raise KeyboardInterrupt

    began = time.perf_counter()
    with pytest.raises(KeyboardInterrupt):
        left()
    assert time.perf_counter() - began < 30.0


def test_items_are_drawn_as_workers_need_them(processes: Executor):
    drawn = []

    def items() -> Iterator[int]:
        for x in range(1000):
            drawn.append(x)
            yield x

    next(completed(square, items(), processes))
    assert len(drawn) < 20


def test_width_is_that_of_the_executor(processes: Executor):
    assert (width(None), width(processes)) == (1, 2)
    with ThreadPoolExecutor(3) as threads:
        assert width(threads) == 3


@pytest.mark.parametrize("error", [InputError("one", "two"), EquilibriumError("2.theta", 4, "row 5")])
def test_errors_come_back_from_workers_as_they_were(error: Exception):
    again = pickle.loads(pickle.dumps(error))
    assert str(again) == str(error)
    assert vars(again) == vars(error)


def same_parameters(one: ec.CalibrationResult, other: ec.CalibrationResult) -> bool:
    told = [[(p.name, p.identified, p.std, p.interval) for p in result.parameters] for result in (one, other)]
    return told[0] == told[1]


def test_bootstrap_and_genetic_search_are_the_same_on_processes(processes: Executor):
    data = measured(placed(arm(), np.random.default_rng(0)), 30, 1, noise=2e-5)
    linear = {"elastic": LINEAR, "bootstrap": 20, "seed": 3}
    counted: list[tuple[int, int]] = []
    found = ec.calibrate(arm(), data, executor=processes, on_sample=lambda *one: counted.append(one), **linear)
    assert same_parameters(found, ec.calibrate(arm(), data, **linear))
    assert counted == [(i, 20) for i in range(1, 21)]
    genetic = {"elastic": {"2": "step"}, "transition": ec.GeneticSearch(6, 3), "seed": 4}
    one, other = ec.calibrate(arm(), data, **genetic), ec.calibrate(arm(), data, executor=processes, **genetic)
    assert same_parameters(one, other)
    assert one.search.history == other.search.history
    assert one.search.fits == other.search.fits


def test_comparison_is_the_same_on_processes(processes: Executor):
    data = measured(placed(arm(), np.random.default_rng(0)), 40, 1, noise=2e-5)
    options = {"elastic": ["2"], "models": ["rigid", "linear"], "folds": 4}
    counted: list[tuple[int, int]] = []
    found = ec.compare(arm(), data, executor=processes, on_fit=lambda *one: counted.append(one), **options)
    assert found == ec.compare(arm(), data, **options)
    assert counted == [(i, 10) for i in range(1, 11)]


@pytest.mark.parametrize("criterion", ["O1", "O3", "accuracy"])
def test_plans_are_the_same_on_processes(processes: Executor, criterion: str):
    candidates = ec.random_poses(arm(), 60, 1)
    one, other = (
        ec.select_poses(arm(), candidates, 15, criterion=criterion, executor=executor) for executor in (None, processes)
    )
    assert np.array_equal(one.rows, other.rows)
