"""Every instrument has a variance of its own where the data come from several stations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.identification import calibrate
from elastocal.measurements import Measurements, concatenate
from elastocal.robot import Frame
from elastocal.simulation import random_poses, simulate
from support.robots import arm, placed

NOISE = {"north": 2e-5, "south": 3e-4}


def two_stations(seed: int) -> tuple[Measurements, Measurements]:
    """Positions from a good and from a bad instrument, and new poses from the first."""
    rng = np.random.default_rng(seed)
    stations = {name: Frame(tuple(rng.uniform(-3, 3, 3)), tuple(rng.uniform(-1, 1, 3)), known=True) for name in NOISE}
    actual = replace(placed(arm().displaced({"3.a": 1e-3, "4.alpha": 1e-3}), rng), stations=stations)
    parts = [
        simulate(actual, random_poses(actual, 60, seed + i), noise=noise, station=name, seed=seed + i)
        for i, (name, noise) in enumerate(NOISE.items())
    ]
    return concatenate(parts), simulate(actual, random_poses(actual, 200, seed + 9), station="north")


def test_each_instrument_is_weighed_by_its_own_noise():
    nominal = replace(arm(), stations={name: Frame() for name in NOISE})
    ratios = []
    for seed in range(3):
        data, new = two_stations(seed)
        both = calibrate(nominal, data, held_out=new)
        assert both.status == "converged"
        for name, noise in NOISE.items():
            assert both.model_sigma[f"position {name}"] == pytest.approx(noise, rel=0.25)
        assert both.chi2_reduced == pytest.approx(1.0, abs=0.01)
        good = calibrate(nominal, data.take(np.arange(60)), held_out=new)
        ratios.append(both.residuals["held_out"].mean / good.residuals["held_out"].mean)
    assert max(ratios) < 1.05  # the bad instrument does no harm


def test_one_instrument_has_one_variance_by_kind():
    data, _ = two_stations(0)
    one = replace(data.take(np.arange(60)), station=None)
    assert set(calibrate(arm(), one).model_sigma) == {"position"}
