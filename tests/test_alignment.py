"""The first alignment needs no first guess of the instrument's place or of the tool."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.identification import calibrate, residuals
from elastocal.identification.alignment import align
from elastocal.measurements import concatenate
from elastocal.robot import Frame
from elastocal.simulation import random_poses, simulate
from support.robots import arm, placed

KINDS = [("position",), ("position", "orientation"), ("distance",)]


@pytest.mark.parametrize("kinds", KINDS, ids="+".join)
@pytest.mark.parametrize("seed", range(10))
def test_alignment_of_a_perfect_robot_is_exact(kinds, seed):
    """Any orientation and place of the instrument, offsets of up to half a metre along each axis."""
    actual = placed(arm(), np.random.default_rng(seed), offset=0.5)
    data = simulate(actual, random_poses(actual, 30, seed), kinds=kinds)
    found = residuals(align(arm(), data), data)
    assert found.norms.max() < 1e-9
    if "orientation" in kinds:
        assert found.angles.max() < 1e-9


@pytest.mark.parametrize("seed", range(10))
def test_alignment_of_an_imperfect_robot_leaves_its_own_errors(seed):
    rng = np.random.default_rng(seed)
    actual = placed(arm(), rng, offset=0.5)
    actual = actual.displaced({e.name: 2e-3 * rng.standard_normal() for row in actual.row_elements for e in row})
    data = simulate(actual, random_poses(actual, 20, seed), noise=3e-5, seed=seed)
    assert np.sqrt((residuals(align(arm(), data), data).norms ** 2).mean()) < 0.02


@pytest.mark.parametrize("poses", [4, 5, 8])
def test_few_poses_are_aligned_too(poses):
    worst = 0.0
    for seed in range(10):
        rng = np.random.default_rng(seed)
        actual = placed(arm(), rng, offset=0.3)
        data = simulate(actual, random_poses(actual, poses, seed), noise=3e-5, seed=seed)
        result = calibrate(arm(), data, identify=["base.*"])
        worst = max(worst, result.residuals["calibrated"].mean)
    assert worst < 6e-5


def test_known_frames_stay_where_they_are():
    actual = placed(arm(), np.random.default_rng(0))
    data = simulate(actual, random_poses(actual, 20, 0))
    base_known = align(replace(arm(), base=actual.base), data)
    assert base_known.base == actual.base
    assert np.abs(base_known.tool.translation - actual.tool.translation).max() < 1e-10
    tool_known = align(replace(arm(), tool=actual.tool), data)
    assert tool_known.tool == actual.tool
    assert np.abs(tool_known.base.translation - actual.base.translation).max() < 1e-10


def test_distances_from_a_known_place_tell_the_tool():
    actual = placed(arm(), np.random.default_rng(2))
    data = simulate(actual, random_poses(actual, 20, 0), kinds=("distance",))
    aligned = align(replace(arm(), base=actual.base), data)
    assert aligned.base == actual.base
    assert np.abs(aligned.tool.translation - actual.tool.translation).max() < 1e-9


def test_a_tool_of_known_targets_is_placed_from_them():
    actual = placed(arm(), np.random.default_rng(1))
    targets = {n: Frame(xyz, known=True) for n, xyz in {"a": (0.1, 0, 0), "b": (0, 0.1, 0), "c": (0, 0, 0.1)}.items()}
    actual = replace(actual, targets=targets)
    data = concatenate([simulate(actual, random_poses(actual, 20, i), target=n) for i, n in enumerate(targets)])
    aligned = align(replace(arm(), targets=targets), data)
    assert np.abs(aligned.tool.rotation - actual.tool.rotation).max() < 1e-9
    assert np.abs(aligned.tool.translation - actual.tool.translation).max() < 1e-9


def test_an_instrument_pitched_by_ninety_degrees_is_no_special_case():
    actual = replace(
        arm(), base=Frame((1.0, 2.0, 3.0), (0.3, np.pi / 2, -0.4), known=True), tool=Frame((0.1, 0.0, 0.2), known=True)
    )
    data = simulate(actual, random_poses(actual, 60, 0), noise=1e-5)
    result = calibrate(arm(), data)
    assert result.status == "converged"
    assert result.residuals["calibrated"].mean < 3e-5
    assert result.observability.rank == 27
