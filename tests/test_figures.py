"""Figures of the public API: plotly accepts them, and what they draw is what the model and the data say."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.figures.compliance import law_at
from elastocal.figures.panel import MOST_POINTS, Panel, points
from elastocal.figures.parameters import MOST_CORRELATED, correlations
from elastocal.figures.robot import skeleton
from elastocal.figures.rows import Rows, binned, rows_of
from elastocal.figures.style import ON_DARK, dark_colors
from elastocal.identification import CalibrationResult, SavedResult
from elastocal.robot import Compliance, JointMap
from support.calibrations import measured
from support.robots import arm, placed, random_dh_robot

FIGURES = [name for name in ec.figures.__all__ if name != "joint_maps"]

COMPLIANCE = {"2.theta": Compliance("step", (5e-6, 2e-6), 200.0), "3.theta": Compliance("linear", (4e-6,))}


def calibrated(count: int = 60, noise: float = 1e-5, **options: object) -> CalibrationResult:
    """An arm with a step and a linear joint, calibrated."""
    actual = replace(placed(arm(), np.random.default_rng(0)), elastic=COMPLIANCE)
    data = measured(actual, count, 3, noise=noise)
    return ec.calibrate(arm(), data, elastic={"2": "step", "3": "linear"}, holdout=0.2, **options)


@pytest.fixture(scope="module")
def result() -> CalibrationResult:
    return calibrated()


@pytest.fixture(scope="module")
def saved(result: CalibrationResult, tmp_path_factory: pytest.TempPathFactory) -> SavedResult:
    folder = tmp_path_factory.mktemp("figures")
    ec.save_result(result, folder)
    return ec.load_result(folder)


@pytest.fixture(scope="module")
def rows(result: CalibrationResult) -> Rows:
    return rows_of(result)


@pytest.mark.parametrize("name", FIGURES)
def test_plotly_accepts_every_figure_of_a_result_and_of_a_saved_one(
    result: CalibrationResult, saved: SavedResult, name: str
):
    draw = getattr(ec.figures, name)
    one, other = draw(result), draw(saved)
    assert len(one.data) == len(other.data) > 0
    assert one.to_json()
    assert [trace.type for trace in one.data] == [trace.type for trace in other.data]


def test_a_figure_without_anything_to_draw_says_so(result: CalibrationResult, saved: SavedResult):
    with pytest.raises(ec.InputError, match="nothing to draw of joint maps: none were asked for"):
        ec.figures.joint_maps(result)
    with pytest.raises(ec.InputError, match=r"there is no residuals\.csv"):
        ec.figures.position_errors(replace(saved, errors=None))
    with pytest.raises(ec.InputError, match=r"'7': expected one of 2\.theta, 3\.theta"):
        ec.figures.torque_deflection(result, "7")


def test_one_panel_can_be_chosen(result: CalibrationResult):
    one, all_ = ec.figures.torque_deflection(result, "3"), ec.figures.torque_deflection(result)
    assert len(one.data) < len(all_.data)
    assert one.layout.title.text == "3.theta"


def test_scripts_need_plotly_only_when_they_draw():
    code = (
        "import sys, elastocal as ec; ec.figures.torque_deflection; import elastocal.report.html\n"
        "assert 'plotly' not in sys.modules, 'plotly'\n"
        "assert 'jinja2' not in sys.modules, 'jinja2'"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_the_band_is_the_covariances(result: CalibrationResult):
    """At the load τ a linear law's half width is Student's quantile times std times τ."""
    law = next(e for e in result.elastic if e.element == "3.theta")
    load = np.array([-100.0, 0.0, 50.0])
    value, spread = law_at(result, law, load)
    assert value == pytest.approx(law.coefficients[0] * load)
    interval = next(p.interval for p in result.parameters if p.name == "3.theta.c")
    half = 0.5 * (interval[1] - interval[0])
    assert spread == pytest.approx(half * np.abs(load))


def test_partial_residuals_lie_on_the_true_law(result: CalibrationResult, rows: Rows):
    """What the figure of torque against deflection draws as data is the truth but for the noise."""
    for element, compliance in COMPLIANCE.items():
        law = next(e for e in result.elastic if e.element == element)
        load = rows.loads[element]
        sure = np.isfinite(rows.motion[element])
        said = law_at(result, law, load)[0] + rows.motion[element]
        true = compliance.coefficients[0] * load
        if compliance.transition_torque is not None:
            true = np.where(np.abs(load) < compliance.transition_torque, true, compliance.coefficients[1] * load)
        assert np.abs(said - true)[sure].max() < 0.1 * np.abs(true).max()
        assert sure.sum() > 40


def test_a_motion_of_one_joint_is_found_as_that(result: CalibrationResult):
    """Add to the residuals what a turn of joint 3 by 20 µrad would: the figure shows 20 µrad."""
    moved = replace(result.robot, transmission={"3.theta": JointMap((0.0,), (0.0,))})
    before, _ = ec.predict(moved, result.errors.data.q)
    turned = result.robot.displaced({"3.theta": 2e-5})
    after, _ = ec.predict(turned, result.errors.data.q)
    left = replace(result.errors.calibrated, position=after - before)
    found = rows_of(replace(result, errors=replace(result.errors, calibrated=left)))
    motion = found.motion["3.theta"]
    assert motion[np.isfinite(motion)] == pytest.approx(2e-5, rel=1e-3)


def test_vectors_and_points_are_in_the_bases_frame(result: CalibrationResult, rows: Rows):
    base = result.robot.base
    position = (result.errors.data.position - base.translation) @ base.rotation
    assert rows.position == pytest.approx(position, abs=1e-9)
    assert np.linalg.norm(rows.before, axis=1) == pytest.approx(result.errors.nominal.norms)
    assert np.linalg.norm(rows.after, axis=1) == pytest.approx(result.errors.calibrated.norms)


@pytest.mark.parametrize("convention", ["modified-dh", "standard-dh"])
def test_the_drawn_robot_begins_at_its_base_and_ends_at_the_target(convention: str):
    rng = np.random.default_rng(1)
    for _ in range(5):
        robot = random_dh_robot(rng, convention, prismatic=0.3)
        q = rng.uniform(-1.0, 1.0, 6)
        path, joints = skeleton(robot, q)
        target, _ = ec.predict(robot, q[None])
        assert path[0] == pytest.approx(np.zeros(3), abs=1e-9)
        assert path[-1] == pytest.approx((target[0] - robot.base.translation) @ robot.base.rotation, abs=1e-9)
        assert joints.shape == (6, 3)


def test_means_explain_nothing_of_noise_and_all_of_a_curve():
    rng = np.random.default_rng(5)
    x = rng.uniform(0.0, 10.0, 2000)
    noise = binned(x, rng.normal(size=2000), np.ones(2000), 30)
    assert noise.share < 0.03
    assert noise.probability > 1e-3
    curve = binned(x, np.sin(x), np.ones(2000), 100)
    assert curve.share > 0.98
    assert curve.probability < 1e-9
    assert curve.mean == pytest.approx(np.sin(curve.at), abs=0.02)


def test_means_are_weighed_and_skip_what_is_not_finite():
    x, values = np.array([0.0, 0.0, 1.0, 1.0, 1.0, 1.0]), np.array([1.0, 4.0, np.nan, 2.0, 2.0, 2.0])
    found = binned(x, values, np.array([2.0, 1.0, 1.0, 1.0, 1.0, 0.0]), 1)
    assert found.mean == pytest.approx((2.0 + 4.0 + 2.0 + 2.0) / 5.0)
    assert len(binned(x[:0], x[:0], x[:0], 5).mean) == 0


def test_clouds_are_thinned_and_say_so():
    result = calibrated(1500)
    panel_figure = ec.figures.torque_deflection(result, "3")
    cloud = next(trace for trace in panel_figure.data if trace.mode == "markers" and trace.name == "rows")
    assert len(cloud.x) == MOST_POINTS
    from elastocal.figures.compliance import law_panels

    panel = law_panels(result, rows_of(result))[0]
    assert panel.note == f"{MOST_POINTS} of 1500 points drawn"
    few = rows_of(result, most=300)
    assert (len(few), few.total) == (300, 1500)


def test_maps_are_the_truth_where_measured_and_their_band_opens_beyond():
    rng = np.random.default_rng(0)
    waves = JointMap(tuple(1e-4 * rng.normal(size=8)), tuple(1e-4 * rng.normal(size=8)))
    actual = replace(placed(arm(), rng), transmission={"1.theta": waves})
    q = ec.random_poses(actual, 200, 4)
    q[:, 0] = np.where(q[:, 0] > 0.0, q[:, 0] * 0.2, q[:, 0])
    data = ec.simulate(actual, q, noise=1e-5, seed=4)
    figure = ec.figures.joint_maps(ec.calibrate(arm(), data, transmission=8), "1")
    line = next(trace for trace in figure.data if trace.name == "map")
    band = next(trace for trace in figure.data if trace.name == "95 % band")
    n = len(line.x)
    width = 0.5 * (band.y[:n] - band.y[n:][::-1])
    inner = (line.x > -150.0) & (line.x < 20.0)
    off = line.y - 1e6 * waves.at(np.radians(line.x))
    off -= off[inner].mean()  # a constant is the joint's offset
    assert np.abs(off[inner]).max() < 40.0
    assert width[line.x > 45.0].max() > 3.0 * np.median(width[inner])
    assert any(trace.type == "bar" for trace in figure.data)


def test_curves_of_the_search_have_the_torque_found_at_their_foot(result: CalibrationResult):
    figure = ec.figures.transition_search(result)
    curve = figure.data[0]
    found = next(e.transition_torque for e in result.elastic if e.element == "2.theta")
    assert curve.y.min() == 0.0
    assert curve.x[curve.y.argmin()] == pytest.approx(found, rel=0.05)


def test_generations_of_a_genetic_search_are_drawn():
    from elastocal.identification import GeneticSearch

    figure = ec.figures.transition_search(calibrated(transition=GeneticSearch(6, 4)))
    assert [len(trace.y) for trace in figure.data if trace.name == "best of each generation"] == [4]


def test_deviations_are_in_units_of_the_robots_tolerance():
    robot = replace(arm(), tolerance={"length": 1e-3, "angle": 5e-4, "offset": 5e-4})
    rng = np.random.default_rng(0)
    actual = placed(arm().displaced({"2.a": 2e-3, "3.alpha": -1e-3}), rng)
    figure = ec.figures.parameter_deviations(ec.calibrate(robot, measured(actual, 60, 3, noise=1e-6)))
    found = {name: x for trace in figure.data for name, x in zip(trace.y, trace.x, strict=True)}
    assert found["2.a"] == pytest.approx(2.0, abs=0.05)
    assert found["3.alpha"] == pytest.approx(-2.0, abs=0.05)
    assert "tolerance of 1 mm" in figure.to_json()


def test_a_long_correlation_matrix_keeps_the_strongest(result: CalibrationResult):
    names, matrix = correlations(result)
    assert np.diag(matrix) == pytest.approx(1.0)
    assert len(names) == len(result.names) < MOST_CORRELATED
    many = tuple(f"p{i}" for i in range(100))
    covariance = np.eye(100)
    covariance[3, 97] = covariance[97, 3] = 0.9
    figure = ec.figures.correlation(replace(result, names=many, covariance=covariance))
    shown = list(figure.data[0].x)
    assert len(shown) == MOST_CORRELATED
    assert {"p3", "p97"} <= set(shown)


def test_names_are_shown_to_the_letter():
    trace = points([0.0], [0.0], "<a href='javascript:x'>b</a>", "#0072b2")
    assert trace["name"] == "&lt;a href='javascript:x'&gt;b&lt;/a&gt;"
    figure = ec.figures.panel.figure([Panel("<i>", [trace], {})])
    assert figure.layout.title.text == "&lt;i&gt;"


def test_every_colour_has_a_dark_one_that_no_replacement_changes_again():
    colors = dark_colors()
    assert len(colors) == 2 * len(ON_DARK)
    assert not set(colors.values()) & set(colors)
