"""Every law in a robot file: written and read again, and each way of writing it wrong."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import elastocal as ec
from elastocal.parameters import Group, parameters_of
from elastocal.robot import Compliance
from support.files import ROBOT, TABLE, Desk, desk
from support.robots import arm

__all__ = ["desk"]

COMPLIANCES = {
    "linear": Compliance("linear", (2.1e-6,)),
    "step": Compliance("step", (7.2e-6, 6.0e-6), 222.0),
    "hinge": Compliance("hinge", (7.2e-6, 1.0 / 3.0 * 1e-6), 1.0 / 3.0),
    "cubic": Compliance("cubic", (5e-6, -1e-12)),
    "harmonic-drive": Compliance("harmonic-drive", (3e11, 4e5, 2e5, 3e3)),
}

ENTRY = '\n[elastic."elbow.theta"]\nlaw = "{}"\ncoefficients = {}\n'
PLACE = 'robot.toml: elastic."elbow.theta"'
TOO_MANY, TOO_FEW = "[1e-6, 2e-6, 3e-6]", "[1e-6]"

FAULTS = {
    "a law that does not exist": (
        ENTRY.format("stepp", "[1e-6, 2e-6]\ntransition_torque = 20.0"),
        f"{PLACE}.law: no law 'stepp'; did you mean 'step'? (valid: linear, step, hinge, cubic, harmonic-drive)",
    ),
    **{
        f"a {law} with {found} coefficients": (
            ENTRY.format(law, f"{values}\ntransition_torque = 20.0"),
            f"{PLACE}.coefficients: expected [c_low, c_high] of law '{law}', found {found} numbers",
        )
        for law in ("step", "hinge")
        for found, values in ((1, TOO_FEW), (3, TOO_MANY))
    },
    **{
        f"a cubic with {found} coefficients": (
            ENTRY.format("cubic", values),
            f"{PLACE}.coefficients: expected [c1, c3] of law 'cubic', found {found} numbers",
        )
        for found, values in ((1, TOO_FEW), (3, TOO_MANY))
    },
    **{
        f"a {law} without a transition torque": (
            ENTRY.format(law, "[1e-6, 2e-6]"),
            f"{PLACE}: 'transition_torque' is missing: law '{law}' has one",
        )
        for law in ("step", "hinge")
    },
    **{
        f"a {law} with a transition torque": (
            ENTRY.format(law, f"{values}\ntransition_torque = 20.0"),
            f"{PLACE}.transition_torque: law '{law}' has none: leave it out",
        )
        for law, values in (("cubic", "[1e-6, 2e-6]"), ("harmonic-drive", "[3e11, 4e5, 2e5, 3e3]"))
    },
    **{
        f"a transition torque of {torque}": (
            ENTRY.format("step", f"[1e-6, 2e-6]\ntransition_torque = {torque}"),
            f"{PLACE}.transition_torque: expected",
        )
        for torque in ("0.0", "-20.0", "nan", "inf", '"20"')
    },
}


@pytest.mark.parametrize("element", ["2.theta", "2.alpha", "3.a"])
@pytest.mark.parametrize("law", COMPLIANCES)
def test_a_law_written_and_read_again_is_the_same_to_the_last_digit(tmp_path: Path, law: str, element: str):
    robot = replace(arm(), elastic={element: COMPLIANCES[law]})
    ec.save_robot(robot, tmp_path / "robot.toml")
    assert ec.load_robot(tmp_path / "robot.toml").elastic == robot.elastic


def test_a_robot_with_every_law_predicts_the_same_when_read_again(tmp_path: Path):
    elastic = {f"{i}.theta": compliance for i, compliance in enumerate(COMPLIANCES.values(), start=2)}
    robot = replace(arm(), elastic=elastic)
    ec.save_robot(robot, tmp_path / "robot.toml")
    again = ec.load_robot(tmp_path / "robot.toml")
    q = np.random.default_rng(0).uniform(-2.0, 2.0, (20, 6))
    for ours, theirs in zip(ec.predict(again, q), ec.predict(robot, q), strict=True):
        np.testing.assert_array_equal(ours, theirs)


def test_the_parameters_of_a_law_have_its_names_units_and_values():
    elastic = {"2.theta": COMPLIANCES["step"], "3.a": COMPLIANCES["hinge"], "4.theta": COMPLIANCES["cubic"]}
    found = parameters_of(replace(arm(), elastic={**elastic, "5.theta": COMPLIANCES["harmonic-drive"]}))
    told = {n: (p.unit, p.nominal) for n, p in found.items() if p.group in (Group.COMPLIANCE, Group.TRANSITION)}
    assert told == {
        "2.theta.c_low": ("rad/(N·m)", 7.2e-6),
        "2.theta.c_high": ("rad/(N·m)", 6.0e-6),
        "2.theta.transition_torque": ("N·m", 222.0),
        "3.a.c_low": ("m/N", 7.2e-6),
        "3.a.c_high": ("m/N", 1.0 / 3.0 * 1e-6),
        "3.a.transition_torque": ("N", 1.0 / 3.0),
        "4.theta.c1": ("rad/(N·m)", 5e-6),
        "4.theta.c3": ("rad/(N·m)^3", -1e-12),
    }


@pytest.mark.parametrize("case", FAULTS)
def test_a_law_written_wrong_is_told(desk: Desk, case: str):
    added, fault = FAULTS[case]
    desk.write(robot_toml=ROBOT + added, fit_csv=TABLE)
    (told,) = desk.refused("validate robot.toml fit.csv")
    assert told.startswith(fault)


def test_a_harmonic_drive_cannot_be_asked_for(desk: Desk):
    desk.write(robot_toml=ROBOT, fit_csv=TABLE)
    (told,) = desk.refused("calibrate robot.toml fit.csv --elastic elbow:harmonic-drive")
    assert told == "element elbow: no law 'harmonic-drive' (valid: linear, step, hinge, cubic)"
