"""The command `compare`: its table, its JSON, what it refuses."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.robot import Compliance
from elastocal.simulation import random_poses, simulate
from support.files import Desk, contents, desk
from support.robots import arm, placed

__all__ = ["desk"]


@pytest.fixture
def arm_measured(desk: Desk) -> Desk:
    """An arm with a step in joint 2, measured at 50 poses."""
    actual = replace(
        placed(arm().displaced({"3.a": 1e-3, "5.theta": 2e-3}), np.random.default_rng(4)),
        elastic={"2.theta": Compliance("step", (6e-6, 2e-6), 300.0)},
    )
    ec.save_robot(arm(), desk.folder / "robot.toml")
    data = simulate(actual, random_poses(actual, 50, 4), noise=3e-5, seed=4)
    ec.save_measurements(data, arm(), desk.folder / "fit.csv")
    return desk


def test_table_and_json_say_the_same(arm_measured: Desk):
    command = "compare robot.toml fit.csv --elastic 2 --folds 3"
    found = json.loads(arm_measured.done(f"{command} --json"))
    told = arm_measured.done(command)
    assert found["format"] == "elastocal-comparison/1"
    assert found["recommended"] == "step"
    assert [m["model"] for m in found["models"]] == ["rigid", "linear", "step", "hinge", "cubic"]
    for model in found["models"]:
        line = next(line for line in told.splitlines() if line.split()[:1] == [model["model"]])
        figures = [f"{1e3 * model[key]['mean']:.4f}" for key in ("residual", "cross_validated")]
        assert line.split()[1:4] == [str(model["parameters"]), *figures]
        assert line.rstrip().endswith("best") == (model["model"] == "step")
    assert max(map(len, told.splitlines())) <= 80
    assert "Recommended: step on 2; it explains more than it costs" in " ".join(told.split())


def test_without_folds_nothing_is_cross_validated(arm_measured: Desk):
    found = json.loads(
        arm_measured.done("compare robot.toml fit.csv --elastic 2 --folds 0 --models linear,step --json")
    )
    assert [m["cross_validated"] for m in found["models"]] == [None, None]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ("--elastic 2:step", "--elastic 2:step: compare tries the laws itself: name elements only, as 2,3"),
        ("--elastic 2 --models stp", "no model 'stp'; did you mean 'step'? (valid: rigid, linear, step, hinge, cubic)"),
        ("--elastic 9", "no element '9'"),
        ("--elastic 2 --folds 1", "folds is 1: expected at least 2, and at most as many as there are poses"),
        ("--elastic 2 --fix nothing", "--fix no parameter matches 'nothing'"),
    ],
)
def test_what_makes_no_sense_is_refused(arm_measured: Desk, options: str, message: str):
    before = contents(arm_measured.folder)
    ran = arm_measured.run(f"compare robot.toml fit.csv {options}")
    assert ran.status == 2
    assert ran.out == ""
    assert message in ran.err
    assert contents(arm_measured.folder) == before
