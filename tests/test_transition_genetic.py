"""The genetic algorithm of the paper: repeatable, never getting worse, and no better than the exact search."""

from __future__ import annotations

import numpy as np
import pytest

from elastocal.identification import GeneticSearch, calibrate
from elastocal.identification.transition.genetic import search_genetically
from elastocal.identification.transition.search import search_exactly
from elastocal.measurements import Measurements
from support.calibrations import measured
from support.robots import arm
from support.transitions import actual_arm, one_blas_thread, problem

__all__ = ["one_blas_thread"]

SMALL = GeneticSearch(population=10, generations=6)

CASES = [
    ({"2": "step", "3": "step"}, 0),
    ({"2": "hinge", "3": "step"}, 1),
    ({"2": "step", "3": "hinge", "5": "step"}, 2),
]


def data_of(laws: dict[str, str], seed: int) -> Measurements:
    return measured(actual_arm(arm(), laws, seed), 40, seed, noise=1e-4)


@pytest.mark.parametrize(("laws", "seed"), CASES)
def test_it_never_gets_worse_and_the_exact_search_is_at_least_as_good(laws: dict[str, str], seed: int):
    posed = problem(arm(), data_of(laws, seed), laws)
    calls: list[tuple[int, int]] = []
    found, search = search_genetically(posed, SMALL, seed, lambda *call: calls.append(call))
    assert (search.method, search.proven) == ("ga", False)
    assert len(search.history) == SMALL.generations
    assert calls == [(i, SMALL.generations) for i in range(1, SMALL.generations + 1)]
    assert SMALL.population < search.fits <= SMALL.population * SMALL.generations
    assert (np.diff(search.history) <= 0.0).all()
    assert found.misfit <= posed.misfit * search.history[-1] ** 2 * (1.0 + 1e-9)
    assert search_exactly(posed)[0].misfit <= found.misfit * 1.001


def test_the_same_seed_gives_the_same_result_and_another_one_another_search():
    laws = {"2": "step", "3": "hinge"}
    data = data_of(laws, 3)
    once, again, other = (
        calibrate(arm(), data, elastic=laws, transition=GeneticSearch(6, 3), seed=seed) for seed in (1, 1, 2)
    )
    assert once.search.history == again.search.history
    assert once.search.history != other.search.history
    np.testing.assert_array_equal(once.covariance, again.covariance)
    assert once.robot == again.robot


def test_its_torques_lie_in_gaps_as_those_of_the_exact_search_do():
    laws = {"2": "step"}
    result = calibrate(arm(), data_of(laws, 0), elastic=laws, transition=GeneticSearch(6, 3))
    (element,) = result.elastic
    assert element.transition_torque == pytest.approx(np.mean(element.transition.gap), rel=1e-9)
    assert min(element.transition.below, element.transition.above) >= 3


def test_what_was_asked_for_is_in_the_settings():
    laws = {"2": "step"}
    result = calibrate(arm(), data_of(laws, 0), elastic=laws, transition=GeneticSearch(4, 2))
    assert result.settings["transition"] == {"method": "ga", "population": 4, "generations": 2}
    assert len(result.search.history) == 2
