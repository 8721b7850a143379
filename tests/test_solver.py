"""The solver: damping, weights, rank, and what it says when it cannot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.identification import calibrate
from elastocal.identification.alignment import align
from elastocal.identification.solver import Normal
from elastocal.identification.sums import normal_sums
from elastocal.measurements import KINDS, Measurements, concatenate
from elastocal.prediction import Model
from elastocal.robot import Robot
from elastocal.simulation import random_poses, simulate
from support.calibrations import actual_in_gauge, gauge_of, measured
from support.robots import arm

POINT = ("position",)
ONES = dict.fromkeys(KINDS, 1.0)


def far_off(seed: int, size: float, poses: int) -> Measurements:
    """Measurements of an arm whose offsets are off by `size` rad, twists and lengths accordingly."""
    rng = np.random.default_rng(seed)
    offsets = {f"{i}.theta": size * rng.choice([-1.0, 1.0]) for i in range(2, 6)}
    lengths = {f"{i}.a": 0.1 * size * rng.standard_normal() for i in range(2, 6)}
    twists = {f"{i}.alpha": 0.3 * size * rng.standard_normal() for i in range(2, 6)}
    actual = actual_in_gauge(arm(), gauge_of(arm(), POINT), rng, size=0.0)
    return measured(actual.displaced(offsets | lengths | twists), poses, seed, noise=1e-5)


def plain_gauss_newton(nominal: Robot, data: Measurements, names: tuple[str, ...]) -> float:
    """Root mean square residual after fifty undamped steps from the same alignment."""
    model, x = Model(align(nominal, data), names, data), np.zeros(len(names))
    for _ in range(50):
        x = x + Normal.of(normal_sums(model, x, ONES)).step(0.0)
    sums = normal_sums(model, x, ONES)
    return float(np.sqrt(sums["position"].misfit / sums["position"].count))


def test_damped_steps_arrive_wherever_plain_gauss_newton_does_and_where_it_does_not():
    """Ten poses for 27 parameters, offsets 17 deg off: plain steps leave the arm in some cases, damped ones in none."""
    damped, plain = [], []
    for seed in (0, 1, 2, 3, 7, 11, 16, 17):
        data = far_off(seed, size=0.3, poses=10)
        result = calibrate(arm(), data)
        damped.append(result.residuals["calibrated"].mean < 2e-5)
        plain.append(plain_gauss_newton(arm(), data, result.gauge.kept) < 1e-3)
    assert all(damped)
    assert plain.count(False) >= 3


def test_offsets_of_half_a_radian_are_found_from_forty_poses():
    for seed in range(5):
        result = calibrate(arm(), far_off(seed, size=0.5, poses=40))
        assert result.status == "converged"
        assert result.residuals["calibrated"].mean < 2e-5


def test_fewer_equations_than_parameters_is_a_value_with_a_remedy():
    actual = actual_in_gauge(arm(), gauge_of(arm(), POINT), np.random.default_rng(0))
    result = calibrate(arm(), measured(actual, 5, 0))
    assert result.status == "not_identifiable"
    assert result.observability.rank < result.observability.parameters == 27
    assert any(
        "15 observed coordinates cannot determine 27 parameters: measure at least 4 more poses" in w
        for w in result.warnings
    )


def test_a_joint_that_never_moved_is_reported_and_the_gauge_stays():
    actual = actual_in_gauge(arm(), gauge_of(arm(), POINT), np.random.default_rng(0))
    data = measured(actual, 60, 0, noise=1e-5)
    q = data.q.copy()
    q[:, 3] = 0.3
    still = simulate(actual, q, noise=1e-5)
    result = calibrate(arm(), still)
    assert result.status == "not_identifiable"
    assert result.gauge.kept == gauge_of(arm(), POINT).kept
    unseen = {p.name for p in result.parameters if p.verdict == "unobservable" and p.name in result.gauge.kept}
    assert {"4.a", "4.alpha"} <= unseen
    assert all(p.std is None for p in result.parameters if p.name in unseen)
    assert any("joint 4 moved over 0 deg only" in warning for warning in result.warnings)
    assert result.residuals["calibrated"].mean < 5e-5


def test_standard_deviations_match_the_scatter_of_repeated_calibrations():
    actual = actual_in_gauge(arm(), gauge_of(arm(), POINT), np.random.default_rng(3))
    results = [calibrate(arm(), measured(actual, 40, seed, noise=3e-5)) for seed in range(40)]
    names = [name for name in results[0].gauge.kept if name.startswith(tuple("123456"))]
    found = np.array([[p.identified for p in r.parameters if p.name in names] for r in results])
    std = np.array([[p.std for p in r.parameters if p.name in names] for r in results])
    ratio = found.std(axis=0, ddof=1) / np.sqrt((std**2).mean(axis=0))
    assert 0.9 < np.sqrt((ratio**2).mean()) < 1.1


def test_doubling_noise_and_stated_deviations_doubles_the_standard_deviations():
    actual = actual_in_gauge(arm(), gauge_of(arm(), POINT), np.random.default_rng(4))
    small = calibrate(arm(), measured(actual, 60, 0, noise=2e-5, state_sigma=True))
    large = calibrate(arm(), measured(actual, 60, 0, noise=4e-5, state_sigma=True))
    ratios = [b.std / a.std for a, b in zip(small.parameters, large.parameters, strict=True) if a.std]
    assert ratios == pytest.approx([2.0] * len(ratios), rel=3e-2)


def test_stated_deviations_too_small_do_not_make_uncertainties_too_small():
    actual = actual_in_gauge(arm(), gauge_of(arm(), POINT), np.random.default_rng(4))
    data = measured(actual, 60, 0, noise=3e-5)
    stated = calibrate(arm(), replace(data, sigma=np.full((60, 3), 1e-6)))
    plain = calibrate(arm(), data)
    ratios = [b.std / a.std for a, b in zip(plain.parameters, stated.parameters, strict=True) if a.std]
    assert ratios == pytest.approx([1.0] * len(ratios), rel=0.05)


def test_stated_deviations_too_large_are_believed():
    actual = actual_in_gauge(arm(), gauge_of(arm(), POINT), np.random.default_rng(4))
    data = measured(actual, 60, 0, noise=3e-5)
    stated = calibrate(arm(), replace(data, sigma=np.full((60, 3), 3e-4)))
    plain = calibrate(arm(), data)
    ratios = [b.std / a.std for a, b in zip(plain.parameters, stated.parameters, strict=True) if a.std]
    assert np.median(ratios) == pytest.approx(10.0, rel=0.2)


def test_weights_of_positions_and_orientations_are_estimated_from_the_data():
    actual = actual_in_gauge(arm(), gauge_of(arm(), ("position", "orientation")), np.random.default_rng(5))
    data = measured(actual, 200, 0, kinds=("position", "orientation"), noise=3e-5, noise_angle=2e-4)
    sigma = calibrate(arm(), data).model_sigma
    assert sigma["position"] == pytest.approx(3e-5, rel=0.1)
    assert sigma["orientation"] == pytest.approx(2e-4, rel=0.1)


def test_model_variance_is_what_stated_deviations_leave_unexplained():
    actual = actual_in_gauge(arm(), gauge_of(arm(), POINT), np.random.default_rng(6))
    data = replace(measured(actual, 300, 0, noise=5e-5), sigma=np.full((300, 3), 3e-5))
    assert calibrate(arm(), data).model_sigma["position"] == pytest.approx(4e-5, rel=0.1)


def test_rows_with_large_stated_deviations_count_less():
    actual = actual_in_gauge(arm(), gauge_of(arm(), POINT), np.random.default_rng(7))
    good = measured(actual, 60, 0, noise=1e-5, state_sigma=True)
    bad = measured(actual, 60, 1, noise=2e-3, state_sigma=True)
    held_out = simulate(actual, random_poses(actual, 100, 9))
    both = calibrate(arm(), concatenate([good, bad]), held_out=held_out).residuals["held_out"].mean
    alone = calibrate(arm(), good, held_out=held_out).residuals["held_out"].mean
    assert both < 1.3 * alone
