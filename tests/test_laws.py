"""Laws of compliance by themselves: odd, linear in their coefficients, with the derivatives that they claim."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from elastocal.elasticity import CUBIC, CURVES, HARMONIC_DRIVE, HINGE, LAWS, LINEAR, STEP, Law, Load, Spring
from support.differences import central_difference

TORQUE = 100.0
"""The transition torque of steps and hinges, where it is not said otherwise."""

LOADS = np.array([0.0, 1e-9, 3.0, 47.0, 99.0, 101.0, 130.0, 1e3, 1e5])
"""Neither of them within a hundredth of the transition torque, so that a difference can be taken."""

DRIVE = (3e11, 4e5, 2e5, 3e3)
"""A soft wind-up of half the stiffness that fades out over 1/3 mrad, and a cubic that sets in at a few mrad."""

COEFFICIENTS = {
    "linear": (2e-6,),
    "step": (7e-6, 3e-6),
    "hinge": (7e-6, 3e-6),
    "cubic": (5e-6, -1e-17),
    "harmonic-drive": DRIVE,
}

TRANSITIONS = [STEP, HINGE]


def at(load: np.ndarray | float, transition: float = TORQUE, decisive: np.ndarray | float | None = None) -> Load:
    """A load, and the one that decides the side."""
    load = np.atleast_1d(np.asarray(load, dtype=float))
    return Load(load, load if decisive is None else np.broadcast_to(decisive, load.shape), transition)


def deflection(name: str, load: np.ndarray | float, transition: float = TORQUE) -> np.ndarray:
    """By the coefficients above."""
    return CURVES[name].respond(COEFFICIENTS[name], at(load, transition)).deflection


def test_laws_and_curves_are_registered_under_their_names():
    assert list(LAWS) == ["linear", "step", "hinge", "cubic"]
    assert list(CURVES) == [*LAWS, "harmonic-drive"]
    assert {name: law.name for name, law in CURVES.items()} == {name: name for name in CURVES}
    assert set(COEFFICIENTS) == set(CURVES)
    assert {law.name for law in CURVES.values() if law.transition} == {"step", "hinge"}


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_coefficients_powers_basis_and_slopes_of_a_law_are_as_many(law: Law):
    counts = {len(law.coefficients), len(law.powers), len(law.basis(at(LOADS))), len(law.slopes(at(LOADS)))}
    assert len(counts) == 1
    assert law.transition == (law in TRANSITIONS)


@pytest.mark.parametrize("name", CURVES)
@given(load=st.floats(-1e6, 1e6), transition=st.floats(1e-3, 1e5))
def test_turning_the_load_round_turns_the_deflection_round(name: str, load: float, transition: float):
    turned = -deflection(name, -load, transition)
    assert deflection(name, load, transition) == pytest.approx(turned, rel=1e-12, abs=1e-19 * abs(load))
    assert deflection(name, 0.0, transition) == 0.0


@pytest.mark.parametrize("name", LAWS)
def test_a_coefficient_has_the_unit_that_its_power_says(name: str):
    """Twice the load and twice the transition torque make a basis function 2^power times as large."""
    law = LAWS[name]
    once, twice = law.basis(at(LOADS)), law.basis(at(2.0 * LOADS, 2.0 * TORQUE))
    np.testing.assert_allclose(twice, once * 2.0 ** np.array(law.powers)[:, None], rtol=1e-15)


@pytest.mark.parametrize("law", TRANSITIONS, ids=lambda law: law.name)
@given(load=st.floats(-1e6, 1e6), transition=st.floats(1e-3, 1e5))
def test_the_two_basis_functions_of_step_and_hinge_add_up_to_the_load(law: Law, load: float, transition: float):
    low, high = law.basis(at(load, transition))
    assert low + high == pytest.approx(load, rel=1e-15)
    assert np.abs(low) <= np.abs(load)
    assert np.abs(high) <= np.abs(load)


@pytest.mark.parametrize("law", TRANSITIONS, ids=lambda law: law.name)
def test_with_equal_coefficients_step_and_hinge_are_the_linear_law(law: Law):
    ours, linear = law.respond((2e-6, 2e-6), at(LOADS)), LINEAR.respond((2e-6,), at(LOADS))
    np.testing.assert_allclose(ours.deflection, linear.deflection, rtol=1e-15)
    np.testing.assert_allclose(ours.compliance, linear.compliance, rtol=1e-15)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize("name", CURVES)
def test_the_compliance_is_the_slope_of_the_deflection(name: str, sign: float):
    loads = sign * LOADS[LOADS > 1e-6]
    steps = 1e-3 * np.abs(loads)
    found = CURVES[name].respond(COEFFICIENTS[name], at(loads)).compliance
    difference = central_difference(lambda t: deflection(name, loads + t * steps), 1.0) / steps
    np.testing.assert_allclose(found, difference, rtol=1e-8)


@pytest.mark.parametrize("name", LAWS)
def test_the_deflection_is_linear_in_its_coefficients_with_the_partials_as_factors(name: str):
    law, values = LAWS[name], np.array(COEFFICIENTS[name])
    partials = law.respond(tuple(values), at(LOADS)).partials[: len(values)]
    np.testing.assert_allclose(values @ partials, deflection(name, LOADS), rtol=1e-15)
    for k, unit in enumerate(np.eye(len(values))):
        np.testing.assert_array_equal(law.respond(tuple(unit), at(LOADS)).deflection, partials[k])


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_the_partial_of_a_hinge_by_its_transition_torque_is_the_slope_along_it(sign: float):
    loads = sign * LOADS
    partials = HINGE.respond(COEFFICIENTS["hinge"], at(loads)).partials
    difference = central_difference(lambda t: deflection("hinge", loads, TORQUE + t), 0.01)
    assert partials.shape == (3, len(LOADS))
    np.testing.assert_allclose(partials[2], difference, rtol=0, atol=1e-14)
    assert (np.abs(partials[2]) > 1e-6).tolist() == (LOADS > TORQUE).tolist()


@pytest.mark.parametrize("name", ["linear", "step", "cubic", "harmonic-drive"])
def test_the_other_laws_have_no_partial_by_a_transition_torque(name: str):
    partials = CURVES[name].respond(COEFFICIENTS[name], at(LOADS)).partials
    assert len(partials) == (len(LAWS[name].coefficients) if name in LAWS else 0)


def test_a_step_jumps_at_its_transition_torque_and_is_high_on_it():
    below, on = np.nextafter(TORQUE, 0.0), TORQUE
    c_low, c_high = COEFFICIENTS["step"]
    assert deflection("step", below) == pytest.approx(c_low * TORQUE, rel=1e-14)
    assert deflection("step", on) == pytest.approx(c_high * TORQUE, rel=1e-14)
    assert deflection("step", -below) == pytest.approx(-c_low * TORQUE, rel=1e-14)
    assert deflection("step", -on) == pytest.approx(-c_high * TORQUE, rel=1e-14)


@given(decisive=st.floats(-300.0, 300.0))
def test_the_side_of_a_step_is_that_of_the_load_that_decides(decisive: float):
    factor = COEFFICIENTS["step"][int(abs(decisive) >= TORQUE)]
    found = STEP.respond(COEFFICIENTS["step"], at(LOADS, decisive=decisive))
    np.testing.assert_allclose(found.deflection, factor * LOADS, rtol=1e-15)
    np.testing.assert_array_equal(found.compliance, factor)


@given(decisive=st.floats(-300.0, 300.0))
def test_a_hinge_does_not_mind_which_load_decides(decisive: float):
    np.testing.assert_array_equal(
        HINGE.respond(COEFFICIENTS["hinge"], at(LOADS, decisive=decisive)).deflection, deflection("hinge", LOADS)
    )


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_hinge_is_continuous_and_bends_at_its_transition_torque(sign: float):
    c_low, c_high = COEFFICIENTS["hinge"]
    near = TORQUE + np.array([-1e-7, 0.0, 1e-7])
    np.testing.assert_allclose(deflection("hinge", sign * near), sign * c_low * TORQUE, rtol=1e-8)
    slopes = HINGE.respond(COEFFICIENTS["hinge"], at(sign * near)).compliance
    assert slopes.tolist() == [c_low, c_high, c_high]


def test_a_hinge_follows_its_low_compliance_and_then_its_high_one():
    c_low, c_high = COEFFICIENTS["hinge"]
    assert deflection("hinge", 130.0) == pytest.approx(c_low * 100.0 + c_high * 30.0, rel=1e-14)
    assert deflection("hinge", -130.0) == pytest.approx(-c_low * 100.0 - c_high * 30.0, rel=1e-14)


def test_a_cubic_is_a_load_and_its_cube():
    assert CUBIC.respond((2.0, 3.0), at(-2.0)).deflection.tolist() == [-28.0]


DRIVES = {
    "ordinary": DRIVE,
    "with a wind-up almost as stiff as the drive": (3e11, 4e5, 3.9e5, 3e3),
    "without a wind-up": (3e11, 4e5, 0.0, 3e3),
    "without a cubic": (0.0, 4e5, 2e5, 3e3),
    "with a wind-up that never fades": (3e11, 4e5, 2e5, 0.0),
    "with a wind-up that fades at once": (3e11, 4e5, 2e5, 1e7),
    "with a cubic alone but for a trace": (3e11, 1.0, 0.0, 0.0),
}


@pytest.mark.parametrize("drive", DRIVES.values(), ids=DRIVES)
def test_the_deflection_of_a_harmonic_drive_is_the_inverse_of_its_curve(drive: tuple[float, ...]):
    sizes = np.concatenate([[0.0], np.geomspace(1e-6, 1e6, 200)])
    loads = np.concatenate([-sizes[:0:-1], sizes])
    torsion = HARMONIC_DRIVE.respond(drive, at(loads, 0.0)).deflection
    np.testing.assert_allclose(HARMONIC_DRIVE.torque(drive, torsion), loads, rtol=1e-12, atol=1e-12)
    assert (np.diff(torsion) > 0.0).all()


@pytest.mark.parametrize("drive", DRIVES.values(), ids=DRIVES)
def test_the_stiffness_of_a_harmonic_drive_is_the_slope_of_its_curve(drive: tuple[float, ...]):
    torsion = np.array([-5e-3, -1e-4, 1e-5, 2e-4, 1e-3, 1e-2])
    steps = 1e-3 * np.abs(torsion)
    slope = central_difference(lambda t: HARMONIC_DRIVE.torque(drive, torsion + t * steps), 1.0) / steps
    np.testing.assert_allclose(HARMONIC_DRIVE.stiffness(drive, torsion), slope, rtol=1e-6)
    assert HARMONIC_DRIVE.stiffness(drive, np.zeros(1)) == pytest.approx(drive[1] - drive[2])


def test_a_harmonic_drive_is_softer_near_zero_than_further_out():
    compliance = HARMONIC_DRIVE.respond(DRIVE, at([0.0, 50.0, 1e3], 0.0)).compliance
    assert compliance[0] == pytest.approx(1.0 / 2e5)
    assert (np.diff(compliance) < 0.0).all()


@pytest.mark.parametrize("name", LAWS)
def test_a_displaced_spring_differs_by_that_in_one_number(name: str):
    spring = Spring(LAWS[name], COEFFICIENTS[name], TORQUE if LAWS[name].transition else None)
    for k, value in enumerate(spring.coefficients):
        moved = spring.displaced(k, 0.5 * value)
        others = spring.coefficients[:k] + spring.coefficients[k + 1 :]
        assert moved.coefficients[k] == 1.5 * value
        assert moved.coefficients[:k] + moved.coefficients[k + 1 :] == others
        assert (moved.law, moved.transition) == (spring.law, spring.transition)
    if LAWS[name].transition:
        moved = spring.displaced(len(spring.coefficients), 5.0)
        assert (moved.transition, moved.coefficients) == (TORQUE + 5.0, spring.coefficients)
