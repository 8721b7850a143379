"""A compliant arm calibrated from 60 measured points is as accurate as the noise lets any model of it be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from elastocal.identification import calibrate
from elastocal.identification.calibration import fit_frames
from elastocal.identification.solver import fit
from elastocal.prediction import Model
from elastocal.robot import Robot
from elastocal.simulation import random_poses, simulate
from support.calibrations import ALL_LINEAR, distances, measured
from support.robots import ARM_COMPLIANCE, arm, placed

NOISE = 3e-5


def drawn(seed: int) -> Robot:
    """An actual arm: geometry off by 1 mm and 1 mrad everywhere, all joints compliant, 10 kg tool, unknown frames."""
    rng = np.random.default_rng(seed)
    deltas = {e.name: 1e-3 * rng.standard_normal() for row in arm().row_elements for e in row}
    return placed(arm(elastic=True).displaced(deltas), rng)


def attainable(actual: Robot, data, held_out) -> float:
    """Held-out error of the true model structure, fitted from the true robot."""
    opened = actual.with_frames({p: replace(actual.frames[p], known=False) for p in ("base", "tool")})
    gauge = calibrate(opened, data, elastic=ALL_LINEAR).gauge
    start = fit_frames(opened, data, gauge)
    model = Model(start, gauge.kept, data)
    return float(distances(model.displaced(fit(model, np.zeros(len(gauge.kept))).displacements), held_out).mean())


def test_error_is_within_ten_percent_of_what_the_true_structure_attains():
    ratios = []
    for seed in range(20):
        actual = drawn(seed)
        data = measured(actual, 60, seed, noise=NOISE)
        held_out = simulate(actual, random_poses(actual, 200, seed + 1000))
        result = calibrate(arm(), data, held_out=held_out, elastic=ALL_LINEAR)
        assert result.status == "converged"
        ratios.append(result.residuals["held_out"].mean / attainable(actual, data, held_out))
    assert np.mean(ratios) < 1.10
    assert max(ratios) < 1.20


def test_compliances_come_out_within_their_uncertainty():
    deviations = []
    for seed in range(10):
        result = calibrate(arm(), measured(drawn(seed), 60, seed, noise=NOISE), elastic=ALL_LINEAR)
        for element in result.elastic[1:]:
            true = ARM_COMPLIANCE[int(element.element[0]) - 1]
            deviations.append((element.coefficients[0] - true) / element.std[0])
    assert np.abs(deviations).max() < 4.5
    assert 0.7 < np.std(deviations) < 1.3
