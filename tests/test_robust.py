"""Weights of rows, robust losses and studentised residuals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from elastocal.errors import InputError
from elastocal.identification import calibrate, choose_gauge, fit_frames, robust
from elastocal.identification.influence import influence
from elastocal.identification.request import requested, with_laws
from elastocal.identification.robust import MEDIAN, TUNING, fit_robustly, weights_of
from elastocal.identification.solver import Normal, fit
from elastocal.identification.studentised import least_score
from elastocal.identification.sums import KindSums, normal_sums
from elastocal.identification.transition import problem_of, with_known_torques
from elastocal.identification.transition.profile import profile_of
from elastocal.measurements import Measurements, concatenate
from elastocal.prediction import Model
from elastocal.simulation import random_poses, simulate
from support.calibrations import distances
from support.outliers import NOISE, as_built, laws, spoiled
from support.robots import arm

ONES = {"position": 1.0, "orientation": 1.0, "distance": 1.0}


def measured(seed: int, count: int = 40, kinds: tuple[str, ...] = ("position",), **options: object) -> Measurements:
    actual = as_built(seed, "rigid")
    return simulate(actual, random_poses(actual, count, seed), kinds=kinds, noise=NOISE, seed=seed, **options)


def model_of(data: Measurements) -> Model:
    """A rigid arm's model of data, at the aligned nominal arm."""
    gauge = choose_gauge(arm(), data, requested(arm(), ()))
    return Model(fit_frames(arm(), data, gauge), gauge.kept, data)


def assert_same(found: KindSums, expected: KindSums) -> None:
    np.testing.assert_allclose(found.gram, expected.gram, rtol=1e-9, atol=1e-12)
    assert (found.count, found.stated) == (expected.count, expected.stated)
    assert found.curvature == pytest.approx(expected.curvature)


@pytest.mark.parametrize("state_sigma", [False, True])
def test_a_weight_is_so_many_rows_and_none_leaves_the_row_out(state_sigma: bool):
    data = measured(0, 12, ("position", "orientation"), noise_angle=1e-4, state_sigma=state_sigma)
    model, weights = model_of(data), np.array([0.0, 1.0, 2.0, 1.0] * 3)
    copies = data.take(np.repeat(np.arange(12), weights.astype(int)))
    at = np.zeros(len(model.names))
    found, expected = (normal_sums(m, at, ONES) for m in (replace(model, weights=weights), replace(model, data=copies)))
    for kind in ("position", "orientation"):
        assert_same(found[kind], expected[kind])


def test_a_kind_that_only_rows_without_weight_observe_is_not_there():
    parts = measured(0, 10), measured(0, 6, ("distance",))
    data = concatenate(parts)
    model = replace(model_of(data), weights=np.repeat([1.0, 0.0], [10, 6]))
    assert list(normal_sums(model, np.zeros(len(model.names)), ONES)) == ["position"]


def test_a_row_is_as_far_from_the_others_whether_it_is_in_the_fit_or_not():
    """To first order; and what it gains when left out is its squared distance over that distance's variance."""
    model = model_of(measured(1, 40))
    rows, variances = np.arange(40), dict(ONES, position=NOISE**2)
    inside = fit(model, np.zeros(len(model.names))).displacements
    before = influence(model, inside, Normal.of(normal_sums(model, inside, variances)).covariance, variances, rows)
    for row in (0, 17):
        without = replace(model, weights=np.where(rows == row, 0.0, 1.0))
        outside = fit(without, inside).displacements
        normal = Normal.of(normal_sums(without, outside, variances))
        after = influence(without, outside, normal.covariance, variances, rows)
        assert after.gain[row] == pytest.approx(before.gain[row], rel=2e-2)
        np.testing.assert_allclose(after.left_out["position"][row], before.left_out["position"][row], atol=1e-6)


@pytest.mark.parametrize("loss", ["huber", "cauchy"])
@pytest.mark.parametrize("coordinates", [1, 3, 4, 6, 7])
def test_tuning_leaves_95_percent_efficiency(loss: str, coordinates: int):
    u = np.linspace(1e-6, 15.0, 20001)
    density = stats.chi.pdf(u, coordinates)
    weights = weights_of(loss, u, np.full(len(u), coordinates))
    mean_slope = np.trapezoid((weights + np.gradient(weights, u) * u / coordinates) * density, u)
    assert mean_slope**2 / np.trapezoid(weights**2 * u**2 * density, u) * coordinates == pytest.approx(0.95, abs=2e-3)


def test_medians_are_those_of_chi_square():
    assert {c: pytest.approx(stats.chi2.median(c), abs=1e-4) for c in MEDIAN} == MEDIAN


@pytest.mark.parametrize("tail", [1e-2, 1.6e-4, 1e-8])
@pytest.mark.parametrize("freedom", [1, 7.5, 150, 1e5])
@pytest.mark.parametrize("coordinates", [1, 3, 6])
def test_the_least_score_of_an_outlier_is_the_root_of_f(coordinates: int, freedom: float, tail: float):
    assert least_score(coordinates, freedom, tail) ** 2 == pytest.approx(
        stats.f.isf(tail, coordinates, freedom), rel=1e-6
    )


def test_without_degrees_of_freedom_nothing_is_an_outlier():
    assert least_score(3, 0.5, 1e-3) == np.inf


def test_huber_with_an_infinite_constant_is_least_squares(monkeypatch: pytest.MonkeyPatch):
    model = model_of(spoiled(measured(2), 2)[0])
    monkeypatch.setattr(robust, "TUNING", {"huber": dict.fromkeys(TUNING["huber"], 1e9)})
    weighed, found = fit_robustly(model, np.zeros(len(model.names)), "huber")
    np.testing.assert_allclose(found.displacements, fit(model, np.zeros(len(model.names))).displacements, atol=1e-9)
    assert weighed.weights.min() == 1.0


@pytest.mark.parametrize("kinds", [("position",), ("position", "orientation"), ("distance",)])
@pytest.mark.parametrize("loss", ["huber", "cauchy"])
def test_a_robust_fit_withstands_what_least_squares_does_not(loss: str, kinds: tuple[str, ...]):
    actual = as_built(3, "rigid")
    clean = measured(3, 120, kinds, noise_angle=1e-4)
    wrong = np.random.default_rng(0).choice(120, 12, replace=False)
    kind = kinds[0]
    values = getattr(clean, kind).copy()
    values[wrong] += 20e-3
    model = model_of(replace(clean, **{kind: values}))
    start, held_out = np.zeros(len(model.names)), simulate(actual, random_poses(actual, 100, 9), kinds=(kind,))
    weighed, solution = fit_robustly(model, start, loss)
    assert solution.converged
    assert weighed.weights[wrong].max() < 0.1 < np.median(weighed.weights)
    robustly, plainly = (
        distances(model.displaced(x), held_out).mean()
        for x in (solution.displacements, fit(model, start).displacements)
    )
    assert robustly < 0.1 * plainly


def test_the_robust_scale_adds_to_what_is_stated():
    """Where deviations are stated, the model's variance is what they do not explain."""
    data = measured(4, 200)
    for stated, expected in ((1e-5, NOISE**2 - 1e-10), (2.0 * NOISE, 0.0)):
        model = model_of(replace(data, sigma=np.full((200, 3), stated)))
        variance = fit_robustly(model, np.zeros(len(model.names)), "cauchy")[1].variances["position"]
        assert variance == pytest.approx(expected, rel=0.25, abs=1e-11)


def test_the_order_of_rows_changes_nothing():
    data, _ = spoiled(measured(5, 60), 5)
    order = np.random.default_rng(1).permutation(60)
    one, other = (calibrate(arm(), rows, loss="cauchy") for rows in (data, data.take(order)))
    assert {o.index for o in one.outliers} == {int(order[o.index]) for o in other.outliers}
    values = [[p.identified for p in result.parameters] for result in (one, other)]
    np.testing.assert_allclose(*values, atol=2e-9)


def test_a_loss_that_does_not_exist_is_named_with_those_that_do():
    with pytest.raises(InputError, match=r"loss: no loss 'cauchi'; did you mean 'cauchy'\? \(valid: linear, huber, ca"):
        calibrate(arm(), measured(0), loss="cauchi")


@pytest.mark.parametrize("law", ["step", "hinge"])
def test_the_search_for_transition_torques_counts_rows_by_their_weights(law: str):
    actual = as_built(6, law)
    data = simulate(actual, random_poses(actual, 40, 6), noise=NOISE)
    weights = np.resize([1.0, 2.0, 3.0], 40)
    copies = data.take(np.repeat(np.arange(40), weights.astype(int)))
    wished, springs = with_laws(arm(), laws(law))
    gauge = choose_gauge(wished, data, requested(wished, springs))
    start = with_known_torques(fit_frames(wished, data, gauge), {})
    asked = dict.fromkeys(springs, law)
    weighed = problem_of(start, gauge.kept, data, asked, weights)
    copied = problem_of(start, gauge.kept, copies, asked)
    np.testing.assert_allclose(weighed.start, copied.start, rtol=1e-6, atol=1e-12)
    profiles = [
        profile_of(problem.model(problem.torques), problem.start, problem.variances, asked, problem.grids)
        for problem in (weighed, copied)
    ]
    np.testing.assert_allclose(*(profile.all_misfits() for profile in profiles), rtol=1e-6)
