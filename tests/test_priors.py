"""Fits with priors: marginal likelihood finds what is there, and no more; joint maps and tolerances end to end."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.errors import InputError
from elastocal.identification import calibrate
from elastocal.identification.evidence import NOTHING, Prior, most_likely
from elastocal.identification.priors import bands, with_maps
from elastocal.identification.sums import KindSums
from elastocal.measurements import Measurements
from elastocal.robot import JointMap, Robot
from elastocal.simulation import random_poses, simulate
from support.files import Desk, desk
from support.robots import arm, placed

__all__ = ["desk"]


def linear_data(seed: int, spread: tuple[float, ...], rows: int = 400, noise: float = 0.1) -> KindSums:
    """Sums of a linear problem, ten parameters to a group with standard deviations `spread`."""
    rng = np.random.default_rng(seed)
    x = np.repeat(spread, 10) * rng.standard_normal(10 * len(spread))
    matrix = rng.standard_normal((rows, len(x)))
    whole = np.column_stack([matrix, matrix @ x + noise * rng.standard_normal(rows)])
    return KindSums(whole.T @ whole, rows, 0.0, False)


def flat_prior(groups: int, optional: bool = True) -> Prior:
    names = tuple(str(i) for i in range(groups))
    flags = np.full(groups, optional)
    return Prior(
        names,
        np.repeat(np.arange(groups), 10),
        np.ones(groups),
        np.zeros(groups, dtype=bool),
        flags,
        np.full(groups, NOTHING),
    )


def test_variances_of_groups_and_of_the_noise_are_found():
    found = []
    for seed in range(20):
        posterior = most_likely({"position": linear_data(seed, (1.0, 0.1, 3.0))}, np.zeros(30), flat_prior(3))
        found.append([*np.sqrt(posterior.prior.variances), np.sqrt(posterior.factors["position"])])
    np.testing.assert_allclose(np.mean(found, axis=0), [1.0, 0.1, 3.0, 0.1], rtol=0.12)


def test_a_group_of_nothing_is_estimated_to_be_nothing():
    small = [
        most_likely({"position": linear_data(seed, (1.0, 0.0))}, np.zeros(20), flat_prior(2)).prior.variances[1]
        for seed in range(10)
    ]
    assert max(small) < 0.05**2
    assert min(small) == NOTHING


def test_evidence_prefers_the_groups_that_are_there():
    sums = {"position": linear_data(3, (1.0, 0.5))}
    both = most_likely(sums, np.zeros(20), flat_prior(2)).log_evidence
    prior = flat_prior(2)
    without = replace(prior, variances=np.array([1.0, NOTHING]), given=np.array([False, True]))
    assert both > most_likely(sums, np.zeros(20), without).log_evidence + 20.0


def test_evidence_is_the_density_of_the_data():
    """Of a small problem, against the normal density of all data with their covariance."""
    rng = np.random.default_rng(0)
    matrix, y = rng.standard_normal((6, 3)), rng.standard_normal(6)
    whole = np.column_stack([matrix, y])
    sums = {"position": KindSums(whole.T @ whole, 6, 0.0, True)}
    densities, evidences = [], []
    for spread in (0.5, 2.0):
        prior = Prior(
            ("a",),
            np.zeros(3, dtype=int),
            np.array([spread**2]),
            np.array([True]),
            np.array([False]),
            np.array([NOTHING]),
        )
        evidences.append(most_likely(sums, np.zeros(3), prior).log_evidence)
        covariance = np.eye(6) + spread**2 * matrix @ matrix.T
        densities.append(-0.5 * (np.linalg.slogdet(covariance)[1] + y @ np.linalg.solve(covariance, y)))
    assert evidences[1] - evidences[0] == pytest.approx(densities[1] - densities[0], rel=1e-9)


@pytest.mark.parametrize("orders", [1, 2, 5, 60, 61, 150])
def test_bands_cover_all_orders_once(orders: int):
    covered = [order for band in bands(orders) for order in range(band.first, band.last + 1)]
    assert covered == list(range(1, orders + 1))


def uneven(seed: int, poses: int, noise: float = 3e-5) -> tuple[Measurements, Measurements, Robot]:
    """An arm with waves of 0.1 mrad at orders 2 and 11 in every joint, measured, and new poses of it."""
    rng = np.random.default_rng(seed)
    maps = {}
    for row in arm().joints:
        sin, cos = (np.zeros(12) for _ in range(2))
        sin[[1, 10]], cos[[1, 10]] = 1e-4 * rng.standard_normal((2, 2))
        maps[row.joint_element] = JointMap(tuple(sin.tolist()), tuple(cos.tolist()))
    actual = replace(placed(arm().displaced({"3.a": 1e-3, "4.theta": 1e-3}), rng), transmission=maps)
    fit, new = random_poses(actual, poses, seed), random_poses(actual, 200, seed + 99)
    return simulate(actual, fit, noise=noise, seed=seed), simulate(actual, new), actual


def test_maps_take_most_of_a_transmission_error_away():
    data, new, actual = uneven(0, 200)
    plain = calibrate(arm(), data, held_out=new)
    mapped = calibrate(arm(), data, held_out=new, transmission=14)
    auto = calibrate(arm(), data, held_out=new, transmission="auto")
    assert mapped.status == auto.status == "converged"
    assert mapped.residuals["held_out"].mean < 0.35 * plain.residuals["held_out"].mean
    assert auto.prior.orders == 14
    assert auto.residuals["held_out"].mean == pytest.approx(mapped.residuals["held_out"].mean, rel=0.02)
    assert mapped.chi2_reduced == pytest.approx(1.0, abs=0.01)
    found, true = mapped.robot.transmission["2.theta"], actual.transmission["2.theta"]
    assert abs(found.sin[10] - true.sin[10]) < 3e-5


def test_maps_of_a_robot_without_transmission_error_cost_nothing():
    rng = np.random.default_rng(5)
    actual = placed(arm().displaced({"3.a": 1e-3}), rng)
    data = simulate(actual, random_poses(actual, 60, 5), noise=3e-5, seed=5)
    new = simulate(actual, random_poses(actual, 200, 6))
    plain, mapped = (calibrate(arm(), data, held_out=new, transmission=orders) for orders in (0, 20))
    assert mapped.residuals["held_out"].mean <= 1.05 * plain.residuals["held_out"].mean


def test_a_map_fades_where_the_joint_was_not_measured():
    data, _, _ = uneven(1, 150)
    near = data.take(np.flatnonzero(data.q[:, 0] > 0.0))
    result = calibrate(arm(), near, transmission=14)
    error = result.robot.transmission["1.theta"]
    inside, outside = (np.abs(error.at(np.linspace(*ends, 200))).max() for ends in ((0.2, 3.0), (-2.6, -0.6)))
    assert outside < 3.0 * inside
    assert outside < 5e-4


def test_few_poses_and_tolerances_make_a_usable_robot():
    ratios = []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        deltas = {e.name: 5e-4 * rng.standard_normal() for row in arm().row_elements for e in row}
        actual = placed(arm().displaced(deltas), rng)
        data = simulate(actual, random_poses(actual, 10, seed), noise=5e-5, seed=seed)
        new = simulate(actual, random_poses(actual, 200, seed + 50))
        plain, prior = (calibrate(arm(), data, held_out=new, prior=wanted) for wanted in (False, True))
        assert prior.status == "converged"
        ratios.append(prior.residuals["held_out"].mean / plain.residuals["held_out"].mean)
    assert np.mean(ratios) < 0.9


def test_stated_tolerances_are_kept_and_shares_told():
    rng = np.random.default_rng(1)
    actual = placed(arm().displaced({"3.a": 1e-3}), rng)
    data = simulate(actual, random_poses(actual, 40, 1), noise=5e-5, seed=1)
    stated = replace(arm(), tolerance={"length": 5e-4, "angle": 1e-3, "offset": 1e-3})
    result = calibrate(stated, data, prior=True)
    assert result.prior.tolerances == pytest.approx(dict(stated.tolerance))
    shares = {p.name: p.data_share for p in result.parameters}
    assert shares["3.a"] > 0.9
    assert min(share for share in shares.values() if share is not None) < 0.1  # 1.d is the base's height
    assert shares["base.tx"] is None
    assert any("the tolerance says more than the data" in note for note in result.notes)


def test_orders_that_make_no_sense_are_refused():
    data, _, _ = uneven(2, 20)
    for wrong in (-1, 1000, "many"):
        with pytest.raises(InputError, match=f"transmission is {wrong}: expected orders from 0 to 360, or auto"):
            calibrate(arm(), data, transmission=wrong)


def test_with_maps_keeps_what_a_robot_knows():
    known = replace(arm(), transmission={"2.theta": JointMap((1e-4,), (2e-4,))})
    found = with_maps(known, 3).transmission
    assert found["2.theta"] == JointMap((1e-4, 0.0, 0.0), (2e-4, 0.0, 0.0))
    assert found["1.theta"] == JointMap((0.0,) * 3, (0.0,) * 3)


def test_the_command_writes_maps_and_tolerances(desk: Desk):
    data, _, _ = uneven(3, 60)
    ec.save_robot(replace(arm(), tolerance={"length": 5e-4}), desk.folder / "robot.toml")
    ec.save_measurements(data, arm(), desk.folder / "fit.csv")
    told = desk.done("calibrate robot.toml fit.csv --transmission 14 --prior -o result")
    assert "Joint maps" in told
    assert max(map(len, told.splitlines())) <= 80
    result = json.loads((desk.folder / "result" / "result.json").read_text())
    assert result["transmission"]["orders"] == 14
    assert result["tolerance"]["length"] == pytest.approx(5e-4)
    robot = ec.load_robot(desk.folder / "result" / "robot.toml")
    assert len(robot.transmission["1.theta"].sin) == 14
    assert robot.tolerance == {"length": 5e-4}
    ran = desk.run("calibrate robot.toml fit.csv --transmission some")
    assert ran.status == 2
    assert "--transmission some: expected a number of orders, as 60, or auto" in ran.err
