"""calibrate() with steps, hinges and cubics: what the result says, and what it warns of."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.elasticity import LAWS as LAWS_BY_NAME
from elastocal.errors import InputError
from elastocal.identification import CalibrationResult, IdentifiedParameter, calibrate
from elastocal.identification.transition.grid import SAME
from elastocal.measurements import Measurements
from elastocal.prediction import Model
from elastocal.robot import Compliance, Robot
from support.calibrations import measured
from support.robots import arm
from support.transitions import actual_arm

LAWS = {"2": "step", "3": "cubic", "5": "hinge", "4": "linear"}

TRUE = {
    "2.theta": Compliance("step", (5e-6, 2e-6), 222.0),
    "3.theta": Compliance("cubic", (1e-5, -1.5e-10)),
    "4.theta": Compliance("linear", (2e-5,)),
    "5.theta": Compliance("hinge", (5e-5, 2e-5), 9.0),
}


def with_springs(elastic: dict[str, Compliance]) -> Robot:
    return replace(actual_arm(arm(), {}), elastic=elastic)


def of(result: CalibrationResult, name: str) -> IdentifiedParameter:
    return next(p for p in result.parameters if p.name == name)


@pytest.fixture(scope="module")
def mixed() -> tuple[Measurements, CalibrationResult]:
    """An arm with every law, calibrated with them."""
    data = measured(with_springs(TRUE), 80, 0, noise=1e-5)
    return data, calibrate(arm(), data, elastic=LAWS)


def test_every_law_at_once_is_identified_within_its_deviations(mixed):
    _, result = mixed
    assert result.status == "converged"
    assert {element.verdict for element in result.elastic} == {"identified"}
    for element in result.elastic:
        true = TRUE[element.element]
        assert element.law == true.law
        for found, std, expected in zip(element.coefficients, element.std, true.coefficients, strict=True):
            assert abs(found - expected) < 4.0 * std < 0.5 * abs(expected)
        if true.transition_torque is not None:
            assert abs(element.transition_torque - true.transition_torque) < 4.0 * element.transition_std


def test_elements_with_a_transition_have_its_fields_and_others_do_not(mixed):
    _, result = mixed
    for element in result.elastic:
        fields = (element.transition_torque, element.transition_std, element.transition)
        if element.law in ("step", "hinge"):
            assert None not in fields
            assert element.transition.searched
        else:
            assert fields == (None, None, None)


def test_the_gap_and_the_numbers_of_loads_are_those_of_the_identified_robot(mixed):
    data, result = mixed
    loads = Model(result.robot, (), data).undeflected_loads(np.zeros(0))
    for element in result.elastic:
        if element.transition is None:
            continue
        sizes = np.sort(np.abs(loads[element.element]))
        below, above = sizes[sizes < element.transition_torque], sizes[sizes >= element.transition_torque]
        assert element.transition.gap == pytest.approx((below[-1], above[0]), rel=1e-6)
        different = [1 + int((np.diff(side) > SAME * sizes[-1]).sum()) for side in (below, above)]
        assert [element.transition.below, element.transition.above] == different


def test_the_torque_of_a_hinge_is_a_parameter_with_covariance_and_that_of_a_step_is_not(mixed):
    _, result = mixed
    torques = [name for name in result.names if name.endswith("transition_torque")]
    assert torques == ["5.theta.transition_torque"]
    assert result.covariance.shape == (len(result.names),) * 2
    deviation = np.sqrt(result.covariance[-1, -1])
    assert of(result, torques[0]).std == pytest.approx(deviation)
    assert len(result.names) == len(result.gauge.kept) + 1


def test_the_identified_robot_has_the_laws_and_what_was_found_of_them(mixed):
    data, result = mixed
    for element in result.elastic:
        found = result.robot.elastic[element.element]
        assert found == Compliance(element.law, element.coefficients, element.transition_torque)
        keys = LAWS_BY_NAME[element.law].coefficients
        assert tuple(of(result, f"{element.element}.{key}").identified for key in keys) == element.coefficients
        if element.transition_torque is not None:
            row = of(result, f"{element.element}.transition_torque")
            assert (row.identified, row.std) == (element.transition_torque, element.transition_std)
    again = Model(result.robot, (), data)
    residual = np.concatenate([p.residual.ravel() for p in again.parts(np.zeros(0), derivatives=False)])
    assert np.sqrt((residual**2).sum() / len(data)) == pytest.approx(result.residuals["calibrated"].rms, rel=1e-9)


def test_a_step_says_which_loads_it_cannot_tell_about(mixed):
    _, result = mixed
    (note,) = [note for note in result.notes if note.startswith("no measured load on")]
    low, high = next(e.transition.gap for e in result.elastic if e.law == "step")
    assert note.startswith(f"no measured load on 2.theta lies between {low:.4g} and {high:.4g} N·m")


def test_elastic_elements_that_were_known_and_not_asked_for_stay_as_they_are():
    nominal = replace(arm(), elastic={"3.theta": TRUE["3.theta"], "5.theta": TRUE["5.theta"]})
    data = measured(with_springs(TRUE), 60, 0, noise=1e-5)
    result = calibrate(nominal, data, elastic={"2": "step"})
    assert result.robot.elastic["3.theta"] == TRUE["3.theta"]
    assert result.robot.elastic["5.theta"] == TRUE["5.theta"]
    assert result.elastic[0].element == "3.theta"
    assert {e.element: e.verdict for e in result.elastic} == {
        "2.theta": "identified",
        "3.theta": "fixed",
        "5.theta": "fixed",
    }


def test_a_law_that_the_robot_has_already_is_identified_to_the_same_as_from_scratch():
    laws = {"2": "step", "3": "hinge"}
    data = measured(actual_arm(arm(), laws), 60, 0, noise=3e-5)
    once = calibrate(arm(), data, elastic=laws)
    guess = {"2.theta": Compliance("step", (1e-6, 9e-6), 400.0), "3.theta": Compliance("hinge", (1e-6, 2e-6), 20.0)}
    again = calibrate(replace(arm(), elastic=guess), data, elastic=laws)
    for one, other in zip(once.elastic, again.elastic, strict=True):
        assert one.transition_torque == pytest.approx(other.transition_torque, rel=1e-3)
        assert one.coefficients == pytest.approx(other.coefficients, rel=1e-3)
    assert of(again, "2.theta.transition_torque").nominal == 400.0
    assert of(once, "2.theta.transition_torque").nominal is None


LINEAR = {"2.theta": Compliance("linear", (3e-6,)), "3.theta": Compliance("linear", (5e-6,))}


def test_where_there_is_no_transition_a_hinge_is_told_to_be_linear():
    """Of ten linear robots, one may look bent by chance."""
    silent = 0
    for seed in range(10):
        data = measured(with_springs(LINEAR), 50, seed, noise=3e-5)
        result = calibrate(arm(), data, elastic={"2": "hinge", "3": "linear"})
        row = of(result, "2.theta.transition_torque")
        told = [warning for warning in result.warnings if warning.startswith("no transition is seen at 2.theta")]
        assert (row.verdict == "insignificant") == (len(told) == 1)
        silent += not told
        if told:
            assert "make its law linear" in told[0]
            assert row.reason == "the compliances on its two sides are the same within their uncertainty"
    assert silent <= 2


def test_where_there_is_a_transition_nothing_is_told_to_be_linear(mixed):
    _, result = mixed
    assert not any("no transition" in warning for warning in result.warnings)
    assert of(result, "2.theta.transition_torque").verdict == "identified"


@pytest.mark.parametrize(("torque", "key", "where"), [(60.0, "c_low", "below"), (500.0, "c_high", "above")])
def test_a_coefficient_that_rests_on_few_loads_is_told(torque: float, key: str, where: str):
    data = measured(with_springs(TRUE), 40, 0, noise=1e-5)
    result = calibrate(arm(), data, elastic={"2": "step"}, transition=[torque])
    count = getattr(result.elastic[0].transition, where)
    assert 0 < count < 6
    loads = "load" if count == 1 else "loads"
    expected = f"2.theta.{key} rests on {count} different {loads} {where} {torque:g} N·m: measure more poses"
    (told,) = [warning for warning in result.warnings if "rests on" in warning]
    assert told.startswith(expected)


def test_repeats_do_not_make_few_loads_many():
    data = measured(with_springs(TRUE), 40, 0, noise=1e-5)
    repeated = data.take(np.repeat(np.arange(40), 3))
    counts = [
        (e.below, e.above)
        for rows in (data, repeated)
        for e in [calibrate(arm(), rows, elastic={"2": "step"}, transition=[60.0]).elastic[0].transition]
    ]
    assert counts[0] == counts[1]


@pytest.mark.parametrize("law", ["step", "hinge", "cubic"])
@pytest.mark.parametrize("others", [{}, {"2": "step"}])
def test_compliance_about_a_vertical_axis_is_unobservable_with_every_law(law: str, others: dict[str, str]):
    data = measured(with_springs(TRUE), 40, 0, noise=1e-5)
    result = calibrate(arm(), data, elastic={"1": law, **others})
    assert result.status == "converged"
    (first,) = [element for element in result.elastic if element.element == "1.theta"]
    assert (first.verdict, first.coefficients, first.std) == ("unobservable", (0.0, 0.0), (None, None))
    assert first.transition is None
    told = [w for w in result.warnings if w.startswith("compliance 1.theta") and "axis is vertical" in w]
    assert len(told) == 2
    assert (result.search is None) == (not others)


def test_an_element_that_is_fixed_keeps_what_the_robot_file_says():
    known = Compliance("step", (4e-6, 1e-6), 150.0)
    data = measured(with_springs(TRUE), 40, 0, noise=1e-5)
    nominal = replace(arm(), elastic={"2.theta": known})
    result = calibrate(nominal, data, elastic={"2": "step", "5": "hinge"}, fix=["2.theta.*"])
    assert result.robot.elastic["2.theta"] == known
    assert {p.verdict for p in result.parameters if p.name.startswith("2.theta.")} == {"fixed"}
    assert result.elastic[0].transition is None


@pytest.mark.parametrize("key", ["c_low", "c_high"])
def test_one_of_two_coefficients_cannot_be_fixed_alone(key: str):
    data = measured(with_springs(TRUE), 20, 0)
    with pytest.raises(InputError) as error:
        calibrate(arm(), data, elastic={"2": "step", "3": "hinge"}, fix=[f"2.theta.{key}"])
    assert error.value.faults == ("2.theta: identify both coefficients of its law, or fix both (--fix '2.theta.*')",)


@pytest.mark.parametrize("law", ["step", "hinge", "cubic"])
def test_laws_go_on_links_and_prismatic_joints_too(law: str):
    springs = {"2.alpha": Compliance(law, (4e-6, 1e-6) if law != "cubic" else (4e-6, 5e-12), None)}
    if law != "cubic":
        springs = {"2.alpha": replace(springs["2.alpha"], transition_torque=60.0)}
    leaning = replace(arm(), gravity=(4.0, -5.0, -7.5))
    actual = replace(with_springs(springs), gravity=leaning.gravity)
    result = calibrate(leaning, measured(actual, 60, 0), elastic={"2.alpha": law})
    assert result.residuals["calibrated"].max < 1e-9
    assert result.elastic[0].coefficients == pytest.approx(springs["2.alpha"].coefficients, rel=1e-4)
