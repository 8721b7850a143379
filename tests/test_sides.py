"""The side of a step is decided once: by the load of the undeflected configuration, or by loads given for it.

On a level axis hangs a beam, soft enough that its load changes by a percent as it sinks.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from elastocal.measurements import Measurements
from elastocal.prediction import Model, predict
from elastocal.robot import Compliance, Frame, Payload, Robot
from support.robots import arm

MASS, LENGTH = 30.0, 0.4
WEIGHT = 9.81 * MASS * LENGTH
"""The load [N m] of the level beam; at an angle q below the horizontal it is WEIGHT cos q."""

LOW, HIGH = 3e-4, 1e-4
"""Compliances of a step: the beam sinks by 2 and by 0.7 deg."""

ANGLES = np.array([-1.1, -0.5, -0.1, 0.02, 0.3, 0.6, 1.2])


def beam(law: str, *coefficients: float, torque: float | None = None) -> Robot:
    """The beam, its tip a metre from the axis."""
    rows = (arm().rows[0], replace(arm().rows[1], mass=MASS, com=(LENGTH, 0.0, 0.0)))
    compliance = Compliance(law, coefficients, torque)
    tip = Frame((1.0, 0.0, 0.0), known=True)
    return replace(arm(), rows=rows, tool=tip, tool_load=Payload(), elastic={"2.theta": compliance})


def posed(angles: np.ndarray | float) -> np.ndarray:
    """Joint positions (poses, 2)."""
    angles = np.atleast_1d(np.asarray(angles, dtype=float))
    return np.stack([np.zeros_like(angles), angles], axis=1)


def model_of(robot: Robot, angles: np.ndarray | float, sides: dict[str, np.ndarray] | None = None) -> Model:
    q = posed(angles)
    return Model(robot, (), Measurements(q, position=np.zeros((len(q), 3))), sides or {})


def sunk(robot: Robot, angles: np.ndarray | float, sides: dict[str, np.ndarray] | None = None) -> np.ndarray:
    """How far the beam sinks, (poses,), from where the model sees its tip."""
    (part,) = model_of(robot, angles, sides).parts(np.zeros(0), derivatives=False)
    return _below_level(-part.residual) - np.atleast_1d(angles)


def _below_level(tip: np.ndarray) -> np.ndarray:
    """The angle of the beam, from its tip (3, poses)."""
    x, _, z = tip
    return np.arctan2(0.45 - z, x - 0.15)


def hanging(compliance: float, angle: float) -> float:
    """How far a beam on a linear spring sinks: the root of one equation."""
    return brentq(lambda x: x - compliance * WEIGHT * np.cos(angle + x), -0.2, 0.2, xtol=1e-16, rtol=1e-15)


@pytest.mark.parametrize("angle", ANGLES)
def test_a_beam_hangs_where_its_one_spring_holds_it(angle: float):
    assert sunk(beam("linear", HIGH), angle) == pytest.approx(hanging(HIGH, angle), abs=1e-13)


def test_undeflected_loads_are_those_of_the_joint_positions_however_soft_the_beam():
    for robot in (beam("linear", 0.0), beam("linear", LOW), beam("step", LOW, HIGH, torque=100.0)):
        found = model_of(robot, ANGLES).undeflected_loads(np.zeros(0))
        np.testing.assert_allclose(found["2.theta"], WEIGHT * np.cos(ANGLES), rtol=1e-13)


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("share", [0.99, 0.999, 1.001, 1.01])
def test_the_undeflected_load_decides_where_the_deflected_one_is_on_the_other_side_too(angle: float, share: float):
    """Sinking lowers the load of a beam that hangs, and raises that of one that points up."""
    load = WEIGHT * np.cos(angle)
    compliance = HIGH if share < 1.0 else LOW
    found = sunk(beam("step", LOW, HIGH, torque=share * load), angle)
    assert found == pytest.approx(hanging(compliance, angle), abs=1e-13)


def test_the_cases_above_include_loads_that_change_sides_as_the_beam_sinks():
    for compliance, share in ((HIGH, 0.99), (LOW, 1.01)):
        after = np.cos(ANGLES + [hanging(compliance, angle) for angle in ANGLES]) / np.cos(ANGLES)
        assert ((after < share) if share < 1.0 else (after > share)).any()


@pytest.mark.parametrize("angle", ANGLES)
def test_at_the_transition_a_step_jumps_and_a_hinge_does_not(angle: float):
    load = float(WEIGHT * np.cos(angle))
    just = load * (1.0 + np.array([-1e-9, 1e-9]))
    high, low = (sunk(beam("step", LOW, HIGH, torque=torque), angle) for torque in just)
    assert high == pytest.approx(hanging(HIGH, angle), abs=1e-13)
    assert low == pytest.approx(hanging(LOW, angle), abs=1e-13)
    below, above = (sunk(beam("hinge", LOW, HIGH, torque=torque), angle) for torque in just)
    assert below == pytest.approx(above, abs=1e-10)


@pytest.mark.parametrize("angle", ANGLES)
def test_a_hinge_answers_to_the_deflected_load(angle: float):
    torque = 0.9 * WEIGHT * np.cos(angle)

    def sinks(x: float) -> float:
        load = WEIGHT * np.cos(angle + x)
        return x - LOW * min(load, torque) - HIGH * max(load - torque, 0.0)

    root = brentq(sinks, -0.2, 0.2, xtol=1e-16, rtol=1e-15)
    assert sunk(beam("hinge", LOW, HIGH, torque=torque), angle) == pytest.approx(root, abs=1e-12)


@pytest.mark.parametrize("law", ["step", "hinge"])
def test_every_pose_around_the_transition_settles(law: str):
    """Also those whose load passes the transition torque as the beam sinks."""
    angles = np.linspace(-1.2, 1.2, 2001)
    found = sunk(beam(law, LOW, HIGH, torque=100.0), angles)
    assert np.isfinite(found).all()
    jumps = np.abs(np.diff(found)) > 1e-3
    assert jumps.sum() == (2 if law == "step" else 0)
    if law == "step":
        at = angles[:-1][jumps]
        np.testing.assert_allclose(np.abs(at), np.arccos(100.0 / WEIGHT), atol=2.0 * (angles[1] - angles[0]))


def test_loads_that_are_given_decide_the_sides_and_nan_leaves_it_to_the_undeflected_ones():
    robot = beam("step", LOW, HIGH, torque=100.0)
    angles = np.array([0.0, 0.0, 0.0, 1.2, 1.2, 1.2, 0.0])
    given = np.array([99.9, 100.0, np.nan, 99.9, -100.0, np.nan, -99.9])
    found = sunk(robot, angles, {"2.theta": given})
    compliances = [LOW, HIGH, HIGH, LOW, HIGH, LOW, LOW]
    expected = [hanging(c, angle) for c, angle in zip(compliances, angles, strict=True)]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13)


def test_sides_of_another_element_change_nothing():
    robot = beam("step", LOW, HIGH, torque=100.0)
    np.testing.assert_array_equal(sunk(robot, ANGLES, {"1.theta": np.zeros(len(ANGLES))}), sunk(robot, ANGLES))


def test_given_loads_leave_the_sides_where_they_are_while_parameters_move():
    robot = beam("step", LOW, HIGH, torque=100.0)
    model = replace(model_of(robot, 0.0, {"2.theta": np.array([99.0])}), names=("2.theta", "2.theta.c_low"))
    (part,) = model.parts(np.array([0.05, 1e-5]), derivatives=False)
    assert _below_level(-part.residual) - 0.05 == pytest.approx(hanging(LOW + 1e-5, 0.05), abs=1e-13)


def test_predict_and_the_model_agree_on_the_sides():
    robot = beam("step", LOW, HIGH, torque=100.0)
    np.testing.assert_allclose(
        _below_level(predict(robot, posed(ANGLES))[0].T) - ANGLES, sunk(robot, ANGLES), rtol=0, atol=1e-14
    )
