"""Without noise, every kept parameter comes back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.identification import calibrate
from elastocal.parameters import parameters_of
from elastocal.robot import Frame
from support.calibrations import ALL_LINEAR, actual_in_gauge, gauge_of, measured
from support.robots import arm, random_dh_robot

KINDS = [("position",), ("position", "orientation"), ("distance",)]

SCALE = {"m": 1e-3, "rad": 1e-3, "rad/(N·m)": 1e-6, "m/N": 1e-6}
"""What counts as the size of a parameter whose nominal value is zero."""


@pytest.mark.parametrize("kinds", KINDS, ids="+".join)
@pytest.mark.parametrize("elastic", [{}, ALL_LINEAR], ids=["rigid", "elastic"])
@pytest.mark.parametrize("seed", range(4))
def test_noise_free_data_give_back_every_kept_parameter(kinds, elastic, seed):
    rng = np.random.default_rng(seed)
    convention = ("modified-dh", "standard-dh")[seed % 2]
    drawn = random_dh_robot(rng, convention, prismatic=0.2 * (seed == 3))
    nominal = arm() if seed == 0 else replace(drawn, base=Frame(), tool=Frame(), gravity=(0.0, 0.0, -9.81))
    gauge = gauge_of(nominal, kinds, elastic)
    actual = actual_in_gauge(nominal, gauge, rng)
    result = calibrate(nominal, measured(actual, 120, seed, kinds=kinds), elastic=elastic)

    assert result.status == "converged"
    assert result.gauge.kept == gauge.kept
    assert result.residuals["calibrated"].max < 1e-12
    truth = parameters_of(actual)
    for parameter in result.parameters:
        if parameter.name not in gauge.kept or ("distance" in kinds and parameter.name.startswith("base")):
            continue  # distances leave the instrument's own frame open, so that the base's depends on it
        true = truth[parameter.name].nominal
        if parameter.unit == "rad" and parameter.name.startswith("base"):
            continue  # roll, pitch and yaw: compared as a rotation below
        assert abs(parameter.identified - true) <= 1e-9 * max(abs(true), SCALE[parameter.unit]), parameter.name
    if "distance" not in kinds:
        assert np.abs(result.robot.base.rotation - actual.base.rotation).max() < 1e-11
