"""Choosing poses: the update formulas, what an exchange reaches, and the rules that it keeps."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from elastocal.design.criteria import CRITERIA, Accuracy, Averaged, Determinant, criterion_of
from elastocal.design.exchange import Pool, best_choice, exchange, greedy_choice
from elastocal.design.rules import Rules, random_choice, rules_of
from elastocal.errors import InputError


@pytest.fixture(autouse=True, scope="module")
def _one_thread() -> Iterator[None]:
    with threadpool_limits(1):
        yield


def free_rules(n: int, rng: np.random.Generator, count: int = 10) -> Rules:
    return rules_of(rng.standard_normal((n, 3)), np.full(3, 1e-9), np.empty((0, 3)), {}, {}, count)


def pool_of(channels: int, p: int, n: int, seed: int, rules: Rules | None = None) -> Pool:
    rng = np.random.default_rng(seed)
    rows = rng.standard_normal((channels, p, n)) * rng.uniform(0.1, 3.0, (p, 1)) * rng.uniform(0.3, 2.0, n)
    return Pool(rows, np.zeros((p, p)), rules or free_rules(n, rng))


def wanted(p: int, seed: int = 9) -> np.ndarray:
    root = np.random.default_rng(seed).standard_normal((p, p))
    return root @ root.T


@pytest.mark.parametrize("channels", [1, 3, 6])
@pytest.mark.parametrize("name", CRITERIA)
def test_the_gain_of_an_exchange_is_the_difference_of_the_scores(name: str, channels: int):
    pool, criterion = pool_of(channels, 7, 40, seed=channels), criterion_of(name, wanted(7))
    chosen, entering = np.arange(12), np.arange(12, 40)
    gram = pool.gram(chosen)
    gains = criterion.exchanged(gram, pool.rows[:, :, chosen], pool.rows[:, :, entering])
    computed = np.argwhere(np.isfinite(gains))
    assert len(computed) >= 100
    for out, come in computed:
        after = np.append(np.delete(chosen, out), entering[come])
        direct = criterion.score(pool.gram(after)) - criterion.score(gram)
        assert gains[out, come] == pytest.approx(direct, rel=1e-7, abs=1e-10)


@pytest.mark.parametrize("name", ["O1", "accuracy"])
def test_views_count_by_their_mean(name: str):
    one, other = (pool_of(3, 7, 40, seed) for seed in (1, 2))
    both = Pool(np.stack([one.rows, other.rows]), np.stack([one.known, other.known]), one.rules)
    criteria = tuple(criterion_of(name, wanted(7, seed)) for seed in (3, 4))
    averaged = Averaged(criteria)
    chosen = np.arange(12)
    scores = [c.score(pool.gram(chosen)) for c, pool in zip(criteria, both.views, strict=True)]
    assert averaged.score(both.gram(chosen)) == pytest.approx(np.mean(scores))
    gains = averaged.exchanged(both.gram(chosen), both.rows[..., chosen], both.rows[..., 12:])
    for out, come in ((0, 0), (5, 17), (11, 27)):
        after = np.append(np.delete(chosen, out), 12 + come)
        direct = averaged.score(both.gram(after)) - averaged.score(both.gram(chosen))
        assert gains[out, come] == pytest.approx(direct, rel=1e-7, abs=1e-10)
    found = exchange(both, averaged, chosen)
    assert averaged.score(both.gram(found)) > averaged.score(both.gram(exchange(one, criteria[0], chosen)))


@pytest.mark.parametrize("name", CRITERIA)
def test_the_slope_is_the_derivative_of_the_score(name: str):
    """Central differences; the smallest eigenvalue of O2 to O4 stands far from the next, so that nothing is shared."""
    pool, criterion = pool_of(3, 6, 30, seed=1), criterion_of(name, wanted(6))
    root = pool.gram(np.arange(8))
    values, vectors = np.linalg.eigh(root)
    gram = (vectors * np.where(np.arange(6) == 0, 1e-3 * values, values)) @ vectors.T
    change = 1e-6 * np.outer(pool.rows[0, :, 9], pool.rows[0, :, 9])
    rate = (criterion.score(gram + change) - criterion.score(gram - change)) / 2.0
    assert float((criterion.slope(gram) * change).sum()) == pytest.approx(rate, rel=1e-4)


def test_the_scores_are_the_indices():
    gram = pool_of(3, 5, 20, seed=2).gram(np.arange(6))
    singular = np.sqrt(np.linalg.eigvalsh(gram))
    indices = {
        "O1": np.prod(singular) ** 0.2,
        "O2": singular[0] / singular[-1],
        "O3": singular[0],
        "O4": singular[0] ** 2 / singular[-1],
        "O5": 1.0 / (1.0 / singular).sum(),
        "accuracy": 1.0 / np.sqrt(np.trace(np.linalg.inv(gram) @ wanted(5))),
    }
    found = {name: np.exp(criterion_of(name, wanted(5)).score(gram)) for name in CRITERIA}
    assert found == pytest.approx(indices, rel=1e-9)


@pytest.mark.parametrize("name", CRITERIA)
def test_an_exchange_never_lowers_the_score_and_ends_where_no_single_exchange_raises_it(name: str):
    pool, criterion = pool_of(3, 7, 60, seed=3), criterion_of(name, wanted(7))
    start = np.arange(8)
    chosen = exchange(pool, criterion, start)
    assert len(set(chosen.tolist())) == 8
    assert criterion.score(pool.gram(chosen)) > criterion.score(pool.gram(start))
    if name in ("O1", "accuracy"):  # of the others the most promising exchanges only are computed
        gains = criterion.exchanged(pool.gram(chosen), pool.rows[:, :, chosen], pool.rows)
        assert gains[pool.rules.allowed(chosen, np.arange(60))].max() < 1e-6


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("name", CRITERIA)
def test_the_best_of_all_choices_is_found_or_nearly(name: str, seed: int):
    pool, criterion = pool_of(3, 5, 12, seed), criterion_of(name, wanted(5))
    every = np.array(list(combinations(range(12), 4)))
    best = max(criterion.score(pool.gram(choice)) for choice in every)
    found = best_choice(pool, criterion, 4, 12, np.random.default_rng(0))
    assert criterion.score(pool.gram(found)) >= best + np.log(0.98)


def test_choices_with_fewer_equations_than_parameters_are_compared_too():
    pool = pool_of(3, 12, 60, seed=5)
    for criterion in (Determinant(), Accuracy(np.eye(12))):
        found = best_choice(pool, criterion, 2, 3, np.random.default_rng(0))
        assert np.linalg.matrix_rank(pool.rows[:, :, found].transpose(1, 0, 2).reshape(12, -1)) == 6


def test_what_is_known_already_counts():
    """One parameter that is known to perfection: poses that tell it alone are of no use."""
    rng = np.random.default_rng(6)
    rows = np.zeros((1, 2, 40))
    rows[0, 0, :20], rows[0, 1, 20:] = 10.0, rng.uniform(0.5, 1.0, 20)
    for known, expected in ((np.zeros((2, 2)), 3), (np.diag([1e9, 0.0]), 0)):
        pool = Pool(rows, known, free_rules(40, rng))
        found = best_choice(pool, Determinant(), 6, 3, rng)
        assert (found < 20).sum() == expected


def test_poses_keep_their_distance_to_one_another_and_to_those_measured():
    rng = np.random.default_rng(7)
    q = rng.uniform(-1.0, 1.0, (300, 2))
    taken = np.array([[0.0, 0.0]])
    rules = rules_of(q, np.array([0.3, 0.3]), taken, {}, {}, 9)
    pool = pool_of(2, 4, 300, 7, rules)
    for start in (greedy_choice(pool, 9, rng), random_choice(rules, 9, rng)):
        chosen = exchange(pool, Determinant(), start)
        places = np.vstack([q[chosen], taken])
        apart = np.abs(places[:, None] - places[None]).max(axis=2)[~np.eye(10, dtype=bool)]
        assert apart.min() >= 0.3
    with pytest.raises(InputError, match=r"found \d+ of 40 poses that keep their distance: of 300 candidates"):
        random_choice(rules, 40, rng)


def test_copies_of_a_pose_are_never_chosen_twice():
    rng = np.random.default_rng(8)
    q = np.repeat(rng.uniform(-1.0, 1.0, (10, 3)), 5, axis=0)
    rules = rules_of(q, np.full(3, 1e-3), np.empty((0, 3)), {}, {}, 10)
    rows = np.repeat(rng.standard_normal((3, 4, 10)), 5, axis=2)
    chosen = best_choice(Pool(rows, np.zeros((4, 4)), rules), Determinant(), 10, 2, rng)
    assert sorted((chosen // 5).tolist()) == list(range(10))


@pytest.mark.parametrize("torques", [{}, {"a": 3.0}])
def test_loads_lie_in_every_bin(torques: dict[str, float]):
    """The information is all where loads are large: without rules no small load would be chosen."""
    rng = np.random.default_rng(10)
    loads = {"a": rng.uniform(-10.0, 10.0, 2000), "b": rng.uniform(0.0, 5.0, 2000)}
    rules = rules_of(rng.standard_normal((2000, 3)), np.full(3, 1e-6), np.empty((0, 3)), loads, torques, 45)
    rows = rng.standard_normal((3, 6, 2000)) * np.abs(loads["a"]) ** 2 * loads["b"] ** 2
    pool = Pool(rows, np.zeros((6, 6)), rules)
    for start in (greedy_choice(pool, 45, rng), random_choice(rules, 45, rng)):
        chosen = exchange(pool, Determinant(), start)
        sizes = np.sort(np.abs(loads["a"][chosen]))
        if torques:
            assert min((sizes < 3.0).sum(), (sizes >= 3.0).sum()) >= 9
        else:
            assert np.diff(sizes).max() < 2.0 and sizes[0] < 1.0 and sizes[-1] > 9.0
        assert np.diff(np.sort(loads["b"][chosen])).max() < 1.0


def test_the_same_seed_gives_the_same_choice():
    pool = pool_of(3, 6, 500, seed=11)
    one, other = (best_choice(pool, Determinant(), 10, 3, np.random.default_rng(4)) for _ in range(2))
    assert np.array_equal(one, other)


def test_a_criterion_that_does_not_exist_is_refused():
    with pytest.raises(InputError, match=r"no criterion 'O6'; did you mean 'O5'\? \(valid: O1, O2, O3, O4, O5, acc"):
        criterion_of("O6", np.eye(2))


@pytest.mark.parametrize("name", ["O1", "accuracy"])
def test_a_few_starts_are_as_good_as_the_best_of_twenty_long_runs(name: str):
    """The bar of benchmarks/plan.py, on a smaller problem: an efficiency of 0.98."""
    pool, criterion = pool_of(3, 15, 600, seed=12), criterion_of(name, wanted(15))
    starts = (random_choice(pool.rules, 20, np.random.default_rng(seed)) for seed in range(20))
    runs = [criterion.score(pool.gram(exchange(pool, criterion, start, 1e-9))) for start in starts]
    found = best_choice(pool, criterion, 20, 4, np.random.default_rng(99))
    power = 2.0 if name == "O1" else 1.0
    assert np.exp(power * (criterion.score(pool.gram(found)) - max(runs))) >= 0.98
