"""Transition torques worth trying: in the gaps between loads, enough loads on either side."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from elastocal.identification.transition import grid as grids
from elastocal.identification.transition.grid import DENSE, FEWEST, SAME, ZOOM, grids_of, load_grid
from elastocal.identification.transition.search import search_exactly
from support.calibrations import measured
from support.robots import arm
from support.transitions import actual_arm, one_blas_thread, problem

__all__ = ["one_blas_thread"]

SIZES = st.lists(st.floats(-300.0, 300.0).filter(lambda x: abs(x) > 1e-3), min_size=1, max_size=40)


def groups(loads: np.ndarray) -> list[np.ndarray]:
    """Loads by size, in groups between which there is a gap."""
    ordered = np.sort(np.abs(loads))
    return np.split(ordered, np.flatnonzero(np.diff(ordered) > SAME * ordered[-1]) + 1)


def dense(loads: np.ndarray) -> bool:
    """Whether there are so many loads without a gap that they are divided all the same."""
    return max(group[-1] - group[0] for group in groups(loads)) > DENSE * SAME * np.abs(loads).max()


@given(SIZES)
def test_there_is_one_torque_in_the_middle_of_every_gap_that_leaves_enough_loads_on_both_sides(values: list[float]):
    loads = np.array(values)
    found = groups(loads)
    assume(len(found) >= 2 * FEWEST)
    assume(not dense(loads))
    grid = load_grid(loads, smooth=False)
    middles = [0.5 * (one[-1] + other[0]) for one, other in pairwise(found)]
    np.testing.assert_array_equal(grid.torques, middles[FEWEST - 1 : len(middles) - FEWEST + 1])
    assert grid.whole
    for torque in grid.torques:
        below, above = (sum(group[i] < torque for group in found) for i in (-1, 0))
        assert below == above
        assert FEWEST <= below <= len(found) - FEWEST


@given(SIZES, st.integers(1, 5), st.floats(0.0, 0.9))
def test_a_pose_that_is_measured_again_is_never_split_from_itself(values: list[float], repeats: int, jitter: float):
    once = np.array(values)
    largest = np.abs(once).max()
    again = np.concatenate([once] + [np.abs(once) - jitter * SAME * largest / repeats * i for i in range(1, repeats)])
    assume(not dense(again))
    grid = load_grid(again, smooth=False)
    sides = np.abs(again)[:, None] >= grid.torques
    if len(grid.torques) > 1:
        assert (sides.reshape(repeats, len(once), -1) == sides[: len(once)]).all()


@given(SIZES)
def test_too_few_different_loads_leave_one_torque_in_the_middle_of_their_range(values: list[float]):
    loads = np.array(values)
    found = groups(loads)
    assume(len(found) < 2 * FEWEST)
    grid = load_grid(loads, smooth=False)
    assert grid.torques.tolist() == [0.5 * (found[0][0] + found[-1][-1])]
    assert grid.whole


def test_an_element_without_any_load_has_one_torque_above_zero():
    assert load_grid(np.zeros(20), smooth=False).torques.tolist() == [1.0]


@given(st.permutations(range(12)), st.lists(st.sampled_from([-1.0, 1.0]), min_size=12, max_size=12))
def test_neither_order_nor_sign_of_loads_matters(order: list[int], signs: list[float]):
    loads = np.linspace(3.0, 90.0, 12) ** 1.5
    grid = load_grid(loads[order] * signs, smooth=True)
    np.testing.assert_array_equal(grid.torques, load_grid(loads, smooth=True).torques)


@given(SIZES)
def test_bins_say_how_many_torques_put_a_row_on_the_high_side(values: list[float]):
    grid = load_grid(np.array(values), smooth=False)
    high = np.abs(values)[:, None] >= grid.torques
    np.testing.assert_array_equal(grid.bins, high.sum(axis=1))
    for row, count in zip(high, grid.bins, strict=True):
        assert row[:count].all()


LOADS = np.cumsum(np.random.default_rng(0).uniform(0.5, 2.0, 200))


@pytest.mark.parametrize("most", [2, 7, 50])
def test_of_many_gaps_some_are_chosen_evenly_the_first_and_the_last_among_them(most: int):
    every, some = load_grid(LOADS, smooth=False), load_grid(LOADS, smooth=False, most=most)
    assert len(some.torques) == most
    assert not some.whole
    places = np.searchsorted(every.torques, some.torques)
    np.testing.assert_array_equal(every.torques[places], some.torques)
    assert (places[0], places[-1]) == (0, len(every.torques) - 1)
    assert np.ptp(np.diff(places)) <= 1


def test_elements_that_are_many_have_fewer_torques_each(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(grids, "MOST", 50)
    monkeypatch.setattr(grids, "MOST_OF_MANY", 20)
    for count, expected in ((1, 50), (2, 50), (3, 20)):
        laws = {f"{i}.theta": "step" for i in range(count)}
        found = grids_of(dict.fromkeys(laws, LOADS), laws)
        assert [len(grid.torques) for grid in found.values()] == [expected] * count


def test_a_closer_look_at_a_thinned_grid_shows_every_gap_between_the_neighbours():
    every, some = load_grid(LOADS, smooth=False), load_grid(LOADS, smooth=False, most=11)
    for i in range(11):
        low, high = some.torques[max(i - 1, 0)], some.torques[min(i + 1, 10)]
        closer = some.zoomed(i)
        between = (low <= every.torques) & (every.torques <= high)
        np.testing.assert_array_equal(closer.torques, every.torques[between])
        assert closer.whole
        assert closer.zoomed(3) is closer


def test_a_closer_look_at_a_hinge_shows_torques_between_its_neighbours_too():
    grid = load_grid(LOADS, smooth=True)
    closer = grid.zoomed(5)
    np.testing.assert_allclose(closer.torques, np.linspace(grid.torques[4], grid.torques[6], ZOOM + 1), rtol=1e-15)
    np.testing.assert_array_equal(closer.loads, grid.loads)


@pytest.mark.parametrize("law", ["step", "hinge"])
@pytest.mark.parametrize("seed", range(3))
def test_a_thinned_grid_leads_to_the_same_optimum(monkeypatch: pytest.MonkeyPatch, law: str, seed: int):
    laws = {"2": law, "3": law}
    data = measured(actual_arm(arm(), laws, seed), 80, seed, noise=1e-5)
    whole = search_exactly(problem(arm(), data, laws))[0]
    monkeypatch.setattr(grids, "MOST", 15)
    posed = problem(arm(), data, laws)
    assert [len(grid.torques) for grid in posed.grids.values()] == [15, 15]
    thinned = search_exactly(posed)[0]
    assert thinned.misfit <= whole.misfit * 1.001
    for element, torque in whole.torques.items():
        assert thinned.torques[element] == pytest.approx(torque, rel=1e-9 if law == "step" else 1e-2)
