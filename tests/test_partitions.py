"""Partitions are calibrated as if all their rows were in memory, with the same parameters, statistics and verdicts."""

from __future__ import annotations

import pickle
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context

import numpy as np
import pytest
from numpy.typing import NDArray

from elastocal.errors import EquilibriumError, InputError
from elastocal.identification import CalibrationResult, calibrate
from elastocal.identification.judged import Rule
from elastocal.identification.moments import Moments
from elastocal.identification.partitioned import packed, unpacked
from elastocal.identification.statistics import statistics_of
from elastocal.identification.step_torques import Near, best_torque
from elastocal.measurements import Measurements, concatenate
from elastocal.partitions import FEWEST, drawn
from elastocal.robot import Compliance, Frame, Robot
from elastocal.simulation import random_poses, simulate
from support.outliers import NOISE, as_built, laws, spoiled
from support.partitions import in_parts, numbered
from support.robots import arm

POINTS = {"a": Frame((0.1, 0.0, 0.0)), "b": Frame((0.0, 0.1, 0.02)), "c": Frame((-0.08, 0.0, 0.05))}
STATIONS = {"north": Frame((1.0, 2.0, 0.1), (0.1, 0.2, 0.3)), "south": Frame((-2.0, 1.0, 0.3), (0.2, -0.1, 1.0))}


def measured(actual: Robot, count: int, seed: int = 0, **options: object) -> Measurements:
    return simulate(actual, random_poses(actual, count, seed), seed=seed, **{"noise": NOISE, **options})


def moved(one: CalibrationResult, other: CalibrationResult) -> float:
    """The largest difference of two results' parameters, in standard deviations."""
    pairs = zip(one.parameters, other.parameters, strict=True)
    return max(abs(p.identified - q.identified) / p.std for p, q in pairs if p.std)


def assert_alike(whole: CalibrationResult, parts: CalibrationResult, accuracy: float = 1e-3) -> None:
    """Check that two results are the same: values to so many standard deviations."""
    assert parts.status == whole.status == "converged"
    assert parts.names == whole.names
    assert [p.verdict for p in parts.parameters] == [p.verdict for p in whole.parameters]
    assert moved(whole, parts) < accuracy
    pairs = zip(whole.parameters, parts.parameters, strict=True)
    spread = max(abs(p.std / q.std - 1.0) for p, q in pairs if p.std)
    assert spread < 0.1 * accuracy  # the angles of frames are about another start
    assert (parts.coordinates, parts.freedom) == (whole.coordinates, pytest.approx(whole.freedom))
    assert parts.chi2_reduced == pytest.approx(whole.chi2_reduced, rel=1e-6)
    assert parts.model_sigma == pytest.approx(whole.model_sigma, rel=1e-3)
    assert parts.observability.condition == pytest.approx(whole.observability.condition, rel=1e-4)
    for name in ("nominal", "calibrated"):
        one, other = whole.residuals[name], parts.residuals[name]
        for first, second in ((one, other), (one.angle, other.angle)):
            if first is not None and second is not None:
                assert second.n == first.n
                for key in ("mean", "max", "rms", "std"):
                    least = 1e-3 if name == "nominal" else 1e-4  # its frames are one step from those of the sample
                    assert getattr(second, key) == pytest.approx(getattr(first, key), rel=least)


@pytest.mark.parametrize("law", ["rigid", "linear", "hinge"])
def test_parts_are_calibrated_like_the_whole(law: str):
    actual = as_built(1, law)
    data = measured(actual, 2500)
    whole = calibrate(arm(), data, elastic=laws(law))
    parts = calibrate(arm(), in_parts(data, 900, 600), elastic=laws(law))
    assert_alike(whole, parts)
    assert parts.streamed is not None
    assert (parts.streamed.rows, parts.streamed.parts) == (2500, 3)
    assert len(parts.errors.data) == parts.streamed.sample == 600
    assert "all 2500 rows were fitted, read in 3 parts" in " ".join(parts.notes)


@pytest.mark.parametrize("law", ["rigid", "linear"])
def test_with_all_rows_in_the_sample_nothing_differs(law: str):
    data = measured(as_built(2, law), 600)
    whole, parts = (calibrate(arm(), given, elastic=laws(law)) for given in (data, in_parts(data, 250, 600)))
    assert moved(whole, parts) < 1e-8
    for name in ("nominal", "calibrated", "cross_validated"):
        for key in ("n", "mean", "max", "rms", "std"):
            one, other = getattr(whole.residuals[name], key), getattr(parts.residuals[name], key)
            assert other == pytest.approx(one, rel=1e-6 if name == "nominal" else 1e-9)
    np.testing.assert_allclose(parts.covariance, whole.covariance, rtol=1e-7, atol=1e-25)


def several_of_all(seed: int = 3) -> tuple[Robot, Measurements]:
    """Positions, poses and distances of several targets from two stations, stated and not, one after the other."""
    nominal = replace(arm(), stations={name: Frame() for name in STATIONS}, targets=POINTS, tool=Frame(known=True))
    known = {name: replace(frame, known=True) for name, frame in STATIONS.items()}
    actual = replace(as_built(seed), stations=known, targets=POINTS, tool=Frame(known=True))
    options = [
        {"station": "north", "target": "a", "noise": 2e-5, "state_sigma": True},
        {"station": "south", "target": "b", "kinds": ("position", "orientation"), "noise_angle": 1e-4, "noise": 1e-4},
        {"station": "north", "target": "c", "kinds": ("distance",), "noise": 5e-5},
        {"station": "south", "target": "c", "noise": 1e-4},
    ]
    return nominal, concatenate([measured(actual, 400, seed + i, **each) for i, each in enumerate(options)])


def test_stations_targets_kinds_and_deviations_may_differ_from_part_to_part():
    nominal, data = several_of_all()
    parts = in_parts(data, 200, 400)
    assert {found.station for found in parts.parts[0].read().combinations} == {"north"}
    whole = calibrate(nominal, data, elastic=laws("linear"))
    assert {"position north", "position south"} <= set(whole.model_sigma)
    assert_alike(whole, calibrate(nominal, parts, elastic=laws("linear")), accuracy=0.02)


def test_what_is_rare_is_in_the_sample():
    nominal, data = several_of_all()
    rare = data.take(np.concatenate([np.arange(400), np.arange(400, 415), np.arange(800, 1200)]))
    few = rare.take(drawn(rare, 0.01, 0))
    counts = {found.target: len(found.rows) for found in few.combinations}
    assert counts == {"a": FEWEST, "b": 15, "c": FEWEST}
    assert len(np.unique(few.q, axis=0)) == len(few)
    assert nominal.targets.keys() == counts.keys()


def test_the_sample_is_drawn_from_all_over_the_part():
    data = measured(arm(), 5000)
    rows = drawn(data, 0.1, 3)
    assert len(rows) == 500
    assert (np.diff(rows) > 0).all()
    assert np.histogram(rows, bins=5, range=(0, 5000))[0].min() > 60
    assert drawn(data, 0.1, 4).tolist() != rows.tolist()


STEPS = {"2.theta": Compliance("step", (7e-6, 4e-6), 300.0), "3.theta": Compliance("step", (1.2e-5, 7e-6), 90.0)}


def stepped(count: int, seed: int = 0) -> Measurements:
    return measured(replace(as_built(seed), elastic=STEPS), count, seed)


def test_given_torques_of_steps_leave_nothing_to_find():
    data = stepped(2500)
    options: dict[str, object] = {"elastic": laws("step"), "transition": [300.0, 90.0]}
    assert_alike(calibrate(arm(), data, **options), calibrate(arm(), in_parts(data, 900, 600), **options))


def test_torques_of_steps_are_found_among_all_rows():
    data = stepped(3000)
    whole, parts = (calibrate(arm(), given, elastic=laws("step")) for given in (data, in_parts(data, 700, 500)))
    sample = calibrate(arm(), in_parts(data, 700, 500).sample, elastic=laws("step"))
    assert parts.residuals["calibrated"].rms <= whole.residuals["calibrated"].rms * (1.0 + 1e-6)
    for element, few in zip(parts.elastic, sample.elastic, strict=True):
        truth, found = STEPS[element.element].transition_torque, element.transition
        assert element.transition_torque == pytest.approx(truth, abs=0.3)
        assert found.gap[1] - found.gap[0] < 0.5 * (few.transition.gap[1] - few.transition.gap[0])
        assert found.gap[0] <= element.transition_torque <= found.gap[1]
        assert found.interval[0] <= found.gap[0] <= found.gap[1] <= found.interval[1]
    given = {"elastic": laws("step"), "transition": [e.transition_torque for e in parts.elastic]}
    assert_alike(calibrate(arm(), data, **given), calibrate(arm(), in_parts(data, 700, 500), **given))


def test_the_best_torque_is_that_of_the_least_sum_of_squares():
    rng = np.random.default_rng(0)
    loads, below, above = rng.uniform(50.0, 60.0, 200), *rng.uniform(0.0, 3.0, (2, 200))
    above[loads < 54.0] += 2.0
    below[loads > 54.0] += 2.0
    parts = [
        Near(np.arange(100), x, b, a) for x, b, a in zip(*(np.split(v, 2) for v in (loads, below, above)), strict=True)
    ]
    found = best_torque(53.0, parts, 2.0)
    tried = {t: np.where(loads < t, below, above).sum() for t in found.torques.tolist()}
    assert tried[found.torque] == pytest.approx(min(tried.values()))
    np.testing.assert_allclose(found.rises, (np.array(list(tried.values())) - min(tried.values())) / 2.0, atol=1e-9)
    assert not ((loads > found.gap[0] + 1e-9) & (loads < found.gap[1] - 1e-9)).any()


def test_the_interval_of_a_step_covers_its_torque():
    rng, covered = np.random.default_rng(1), 0
    for _ in range(400):
        loads = np.sort(rng.uniform(40.0, 60.0, 4000))
        noise = rng.standard_normal(4000)
        jump = np.where(loads < 50.0, 0.0, 0.2)
        near = Near(np.arange(4000), loads, (noise + jump) ** 2, (noise + jump - 0.2) ** 2)
        low, high = best_torque(50.0, [near], 1.0).interval
        covered += low <= 50.0 <= high
    assert 0.92 * 400 <= covered <= 0.98 * 400


def test_outliers_are_those_of_the_whole():
    data, wrong = spoiled(numbered(measured(as_built(4), 1500)), 4, share=0.03)
    whole, parts = (
        calibrate(arm(), given, elastic=laws("linear"), loss="cauchy") for given in (data, in_parts(data, 400, 500))
    )
    assert sorted(o.row for o in whole.outliers) == sorted(o.row for o in parts.outliers) == (wrong + 1).tolist()
    assert_alike(whole, parts)
    assert parts.streamed is not None
    assert parts.streamed.outliers == parts.streamed.rejected == len(wrong)
    scores = {o.row: o.score for o in whole.outliers}
    for outlier in parts.outliers:
        assert outlier.rejected
        assert outlier.score == pytest.approx(scores[outlier.row], rel=0.05)
        assert parts.errors.data.origin(outlier.index) == (outlier.file, outlier.row)
        assert parts.errors.calibrated.norms[outlier.index] == pytest.approx(outlier.residual, rel=1e-9)
    assert f"{len(wrong)} outliers are left out of the fit" in parts.warnings[0]


def test_outliers_that_were_fitted_are_named_with_what_they_fit():
    nominal = replace(arm(), targets=POINTS, tool=Frame(known=True))
    actual = replace(as_built(5), targets=POINTS, tool=Frame(known=True))
    data = numbered(concatenate([measured(actual, 500, i, target=name) for i, name in enumerate(POINTS)]))
    codes = data.target.codes.copy()
    codes[700] = 2
    data = replace(data, target=replace(data.target, codes=codes))
    result = calibrate(nominal, in_parts(data, 600, 300), elastic=laws("linear"))
    (outlier,) = (o for o in result.outliers if o.hint)
    assert (outlier.row, outlier.hint, outlier.rejected) == (701, "target 'b'", False)


def test_only_the_worst_outliers_are_listed(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("elastocal.identification.tally.LISTED", 5)
    data, wrong = spoiled(numbered(measured(as_built(4), 1500)), 4, share=0.03)
    result = calibrate(arm(), in_parts(data, 400, 500), elastic=laws("linear"), loss="cauchy")
    assert len(result.outliers) == 5
    assert result.streamed.rejected == len(wrong)
    assert f"{len(wrong)} outliers are left out of the fit" in result.warnings[0]
    assert f"and {len(wrong) - 10} more;" in result.warnings[0] or f"and {len(wrong) - 5} more;" in result.warnings[0]
    assert f"the 5 worst of {len(wrong)} outliers" in " ".join(result.notes)


@pytest.mark.parametrize("options", [{"transmission": 2}, {"prior": True}], ids=str)
def test_fits_with_priors_are_of_all_rows(options: dict[str, object]):
    data = measured(as_built(6), 1500)
    whole, parts = (
        calibrate(arm(), given, elastic=laws("linear"), **options) for given in (data, in_parts(data, 400, 500))
    )
    assert moved(whole, parts) < 0.02  # the variances of priors come to rest to 1 %
    assert parts.coordinates == whole.coordinates


def test_compliances_are_kept_from_becoming_negative():
    data = measured(replace(as_built(7), elastic={"2.theta": Compliance("linear", (-2e-6,))}), 1500)
    options: dict[str, object] = {"elastic": laws("linear"), "non_negative": True}
    whole, parts = (calibrate(arm(), given, **options) for given in (data, in_parts(data, 400, 500)))
    assert_alike(whole, parts)


def test_rows_held_out_may_be_in_parts_as_well():
    actual = as_built(8)
    data, other = measured(actual, 1500), measured(actual, 1000, 1, kinds=("position",))
    whole = calibrate(arm(), data, held_out=other, elastic=laws("linear"))
    for fitted in (data, in_parts(data, 400, 300)):
        parts = calibrate(arm(), fitted, held_out=in_parts(other, 300, 100), elastic=laws("linear"))
        for name in ("held_out", "held_out_nominal"):
            assert parts.residuals[name].n == 1000
            for key in ("mean", "max", "rms", "std"):
                one, two = getattr(whole.residuals[name], key), getattr(parts.residuals[name], key)
                assert two == pytest.approx(one, rel=1e-4)
        assert 100 <= parts.errors.held_out.sum() < 120
        assert "on 1000 held-out rows" in parts.verdict


def test_where_parts_are_worked_through_changes_no_bit():
    data = stepped(1500)
    parts = in_parts(data, 300, 400)
    here = calibrate(arm(), parts, elastic=laws("step"), loss="huber")
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as executor:
        there = calibrate(arm(), parts, elastic=laws("step"), loss="huber", executor=executor)
    assert there.robot == here.robot
    assert there.covariance.tobytes() == here.covariance.tobytes()
    assert there.residuals == here.residuals
    assert there.outliers == here.outliers


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"holdout": 0.3}, "holdout: 500 rows are not held in memory at once, so that none can be chosen among them: "),
        ({"bootstrap": 200}, "bootstrap: 500 rows are not held in memory at once, and of so many the linear covari"),
    ],
    ids=str,
)
def test_what_takes_all_rows_at_once_is_refused(options: dict[str, object], said: str):
    parts = in_parts(measured(arm(), 500), 200, 100)
    with pytest.raises(InputError) as error:
        calibrate(arm(), parts, **options)
    assert error.value.faults[0].startswith(said)


def test_a_row_that_does_not_settle_is_named():
    soft = replace(arm(), elastic={"2.theta": Compliance("linear", (1e-5,))})
    data = numbered(replace(measured(as_built(1), 400), wrench=np.zeros((400, 6))))
    unseen = int(np.setdiff1d(np.arange(200, 400), in_parts(data, 200, 100).sample.row - 1)[0])
    data.wrench[unseen] = 1e7
    with pytest.raises(
        EquilibriumError, match=f"2.theta does not settle under its load at fit.parquet row {unseen + 1}"
    ):
        calibrate(soft, in_parts(data, 200, 100))


@pytest.mark.parametrize("error", [InputError("one", "two"), EquilibriumError("2.theta", 4, "fit.csv row 5")], ids=repr)
def test_errors_come_back_from_workers_as_they_were(error: Exception):
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error)
    assert str(again) == str(error)
    assert vars(again) == vars(error)


@pytest.mark.parametrize("seed", range(5))
def test_moments_of_parts_are_those_of_the_whole(seed: int):
    rng = np.random.default_rng(seed)
    values = np.abs(rng.normal(1e-4, 1e-7, 5000))
    values[rng.choice(5000, 50)] = np.nan
    total = Moments()
    for part in np.split(values, np.sort(rng.integers(0, 5000, 6))):
        total = total.plus(Moments.of(part))
    found, expected = total.statistics(), statistics_of(values)
    assert found.n == expected.n
    for key in ("mean", "max", "rms"):
        assert getattr(found, key) == pytest.approx(getattr(expected, key), rel=1e-12)
    assert found.std == pytest.approx(expected.std, rel=1e-9)


def test_bits_keep_which_rows():
    rows: NDArray[np.bool_] = np.random.default_rng(0).random(1003) < 0.3
    assert len(packed(rows)) == 126
    np.testing.assert_array_equal(unpacked(packed(rows), 1003), rows)


def test_scores_are_about_one_for_good_rows():
    data = measured(as_built(9), 3000)
    result = calibrate(arm(), in_parts(data, 1000, 600), elastic=laws("linear"))
    rule = Rule({"position": result.model_sigma["position"] ** 2}, 9000.0, 9000.0, 3000, False)
    judged = rule.judge(result.robot, data)
    scores = rule.scores(judged, np.ones(3000, dtype=bool))
    assert np.sqrt((scores**2).mean()) == pytest.approx(1.0, abs=0.02)
    assert not rule.accused(judged, scores).any()
