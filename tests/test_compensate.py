"""Compensation: the loaded robot on its targets, and what is said where it cannot be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.compensation import Job, compensated
from elastocal.compensation import run as running
from elastocal.compensation.machine import joint_limits
from elastocal.measurements import Labels
from elastocal.prediction.driving import Driver
from elastocal.robot import Compliance, Frame, JointMap, Payload, Robot
from support.files import flawed
from support.robots import arm, random_dh_robot

MIDDLE = (0.2, -0.7, 1.0, 0.4, 0.8, 0.3)


def nominal_arm() -> Robot:
    return replace(arm(), tool=Frame((0.05, 0.0, 0.2), (0.0, 0.5, 0.0), known=True), loads={"heavy": Payload(20.0)})


def actual_arm(law: str = "hinge") -> Robot:
    """The arm as built: flawed, compliant, uneven."""
    laws = {
        "hinge": {"2.theta": Compliance("hinge", (5e-6, 3e-6), 150.0), "3.theta": Compliance("linear", (6e-6,))},
        "step": {"2.theta": Compliance("step", (5e-6, 3e-6), 150.0), "3.theta": Compliance("step", (6e-6, 4e-6), 40.0)},
    }
    built = flawed(nominal_arm(), np.random.default_rng(0), 5e-4)
    return replace(built, elastic=laws[law], transmission={"1.theta": JointMap((1e-4, 5e-5), (0.0, 2e-5))})


def easy_poses(count: int, seed: int = 0) -> np.ndarray:
    """Joint positions far from limits and singularities."""
    return np.array(MIDDLE) + np.random.default_rng(seed).uniform(-0.3, 0.3, (count, 6))


def at_base(robot: Robot) -> Robot:
    return replace(robot, base=Frame())


def errors(robot: Robot, q: np.ndarray, targets: tuple[np.ndarray, np.ndarray], **names: object) -> np.ndarray:
    """How far a loaded robot is from targets, (n,)."""
    return np.linalg.norm(ec.predict(at_base(robot), q, **names)[0] - targets[0], axis=1)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("convention", ["modified-dh", "standard-dh"])
def test_compensation_of_a_perfect_robot_is_the_identity(seed: int, convention: str):
    robot = random_dh_robot(np.random.default_rng(seed), convention, prismatic=0.2)
    q = ec.random_poses(robot, 50, seed)
    result = ec.compensate(robot, ec.Targets(q=q), nominal=robot)
    assert result.reached.all()
    np.testing.assert_allclose(result.q, q, atol=1e-11)
    np.testing.assert_allclose(result.correction, 0.0, atol=1e-11)


@pytest.mark.parametrize("law", ["hinge", "step"])
def test_the_true_parameters_put_the_robot_on_its_targets(law: str):
    nominal, actual = nominal_arm(), actual_arm(law)
    q = easy_poses(300)
    targets = ec.predict(nominal, q)
    result = ec.compensate(actual, targets, nominal=nominal, start=MIDDLE)
    np.testing.assert_allclose(result.nominal_q, q, atol=1e-8)
    missed = [note for note, reached in zip(result.notes, result.reached, strict=True) if not reached]
    assert all("load passes the transition torque" in note for note in missed)
    assert len(missed) <= 3
    assert errors(actual, result.q, targets)[result.reached].max() < 1e-9
    assert errors(actual, q, targets).mean() > 1e-3
    np.testing.assert_allclose(result.error_before, errors(actual, q, targets), atol=1e-9)
    np.testing.assert_allclose(result.error_after, errors(actual, result.q, targets), atol=1e-12)
    turned = ec.predict(at_base(actual), result.q)[1]
    np.testing.assert_allclose(turned[result.reached], targets[1][result.reached], atol=1e-8)


def test_corrections_are_small_steps_in_the_same_configuration():
    nominal, actual = nominal_arm(), actual_arm()
    q = easy_poses(200)
    result = ec.compensate(actual, ec.Targets(q=q), nominal=nominal)
    assert np.abs(result.q - q).max() < 0.02


def test_a_calibration_brings_millimetres_to_hundredths():
    nominal = replace(nominal_arm(), base=Frame((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), known=True))
    actual = replace(actual_arm(), transmission={}, base=nominal.base)
    data = ec.simulate(
        actual, ec.random_poses(nominal, 45, 1), kinds=("position", "orientation"), noise=3e-5, noise_angle=1e-4, seed=1
    )
    found = ec.calibrate(nominal, data, elastic={"2": "hinge", "3": "linear"}).robot
    q = easy_poses(300)
    targets = ec.predict(nominal, q)
    result = ec.compensate(found, targets, nominal=nominal, start=MIDDLE)
    assert errors(actual, result.nominal_q, targets).mean() > 1e-3
    assert errors(actual, result.q, targets).mean() < 1e-4


def test_positions_alone_leave_the_orientation_free():
    nominal, actual = nominal_arm(), actual_arm()
    positions, _ = ec.predict(nominal, easy_poses(50))
    result = ec.compensate(actual, positions, nominal=nominal)
    assert result.reached.all()
    assert errors(actual, result.q, (positions, positions)).max() < 1e-9
    assert np.isnan(result.angle_after).all()


def test_fake_targets_lead_the_nominal_controller_to_the_corrected_joints():
    nominal, actual = nominal_arm(), actual_arm()
    result = ec.compensate(actual, ec.Targets(q=easy_poses(100)), nominal=nominal)
    fake = (result.fake_position, result.fake_rotation)
    again = ec.compensate(nominal, ec.Targets(*fake, q=result.nominal_q), nominal=nominal)
    np.testing.assert_allclose(again.q, result.q, atol=1e-9)
    shift = np.linalg.norm(result.fake_position - ec.predict(nominal, result.nominal_q)[0], axis=1)
    np.testing.assert_allclose(result.correction, shift, atol=1e-12)


def test_each_row_has_its_payload_its_wrench_and_its_tcp():
    nominal = replace(nominal_arm(), targets={"nest": Frame((0.1, 0.0, 0.0), (0.0, 0.0, 0.3), known=True)})
    actual = replace(actual_arm(), targets=nominal.targets)
    q = easy_poses(60)
    rng = np.random.default_rng(2)
    loads = Labels(("heavy",), rng.integers(-1, 1, 60).astype(np.int32))
    tcps = Labels(("nest",), rng.integers(-1, 1, 60).astype(np.int32))
    wrench = rng.normal(size=(60, 6)) * 30.0
    result = ec.compensate(actual, ec.Targets(q=q, load=loads, target=tcps, wrench=wrench), nominal=nominal)
    for row in range(60):
        load, tcp = loads.name(int(loads.codes[row])), tcps.name(int(tcps.codes[row]))
        goal = ec.predict(nominal, q[row], target=tcp)[0]
        there = ec.predict(actual, result.q[row], target=tcp, load=load, wrench=wrench[row : row + 1])[0]
        np.testing.assert_allclose(there, goal, atol=1e-9)


def test_targets_in_the_instruments_frame_are_the_same_targets():
    seat = Frame((1.0, -2.0, 0.3), (0.1, 0.2, 2.0), known=True)
    nominal = nominal_arm()
    actual = replace(actual_arm(), base=seat, stations={"north": replace(seat, xyz=(0.0, 0.0, 1.0))})
    positions, rotations = ec.predict(nominal, easy_poses(40))
    here = ec.compensate(actual, (positions, rotations), nominal=nominal, start=MIDDLE)
    for station in (None, "north"):
        stands = seat if station is None else actual.stations[station]
        moved = (positions @ stands.rotation.T + stands.translation, stands.rotation @ rotations)
        single = actual if station else replace(actual, stations={})
        there = ec.compensate(single, moved, nominal=nominal, start=MIDDLE, frame="instrument", station=station)
        np.testing.assert_allclose(there.q, here.q, atol=1e-9)
        np.testing.assert_allclose(there.fake_position, here.fake_position, atol=1e-9)


@pytest.mark.parametrize("path", [False, True])
def test_blocks_make_no_difference(monkeypatch: pytest.MonkeyPatch, path: bool):
    nominal, actual = nominal_arm(), actual_arm()
    q = np.linspace(MIDDLE, np.array(MIDDLE) + 0.6, 120) if path else easy_poses(120)
    targets = ec.predict(nominal, q)
    whole = ec.compensate(actual, targets, nominal=nominal, start=MIDDLE)
    monkeypatch.setattr(running, "BLOCK", 17)
    parts = ec.compensate(actual, targets, nominal=nominal, start=MIDDLE)
    np.testing.assert_allclose(parts.q, whole.q, atol=1e-8)
    assert parts.summary.reached == whole.summary.reached == 120
    assert parts.summary.figures["error_before"].mean == pytest.approx(whole.summary.figures["error_before"].mean)


def test_a_stream_is_compensated_as_a_whole_is():
    nominal, actual = nominal_arm(), actual_arm()
    targets = ec.Targets(*ec.predict(nominal, easy_poses(50)))
    whole = ec.compensate(actual, targets, nominal=nominal)
    streamed = list(compensated(Job.of(actual, nominal), (targets.take(slice(i, i + 25)) for i in (0, 25))))
    np.testing.assert_allclose(np.concatenate([rows.q for rows in streamed]), whole.q, atol=1e-9)


def test_limits_are_never_exceeded():
    nominal, actual = nominal_arm(), actual_arm()
    low, high = joint_limits(nominal)
    q = ec.random_poses(nominal, 300, 5)
    q[:100] = np.where(np.random.default_rng(0).random((100, 6)) < 0.3, high, q[:100])
    result = ec.compensate(actual, ec.Targets(q=q), nominal=nominal)
    assert (result.q >= low).all()
    assert (result.q <= high).all()
    notes = [note for note in result.notes if "limit" in note]
    assert notes
    assert all("left" in note for note in notes)


def test_where_a_configuration_ends_the_row_says_so():
    """A path on which joint 6 turns on beyond its limit."""
    nominal = nominal_arm()
    way = np.tile(MIDDLE, (60, 1))
    way[:, 5] = np.linspace(2.9, 3.4, 60)
    result = ec.compensate(actual_arm(), ec.predict(nominal, way), nominal=nominal, start=way[0])
    jumps = [row for row, note in enumerate(result.notes) if note.startswith("joints jump from the row before")]
    assert len(jumps) == 1
    assert way[jumps[0], 5] > np.pi - 0.01
    steps = np.abs(np.diff(result.q, axis=0)).max(axis=1)
    assert np.flatnonzero(steps > 0.35).tolist() == [jumps[0] - 1]


def test_out_of_reach_is_a_row_that_says_how_far():
    result = ec.compensate(actual_arm(), np.array([[3.0, 0.0, 0.5], [0.8, 0.1, 0.6]]))
    assert result.reached.tolist() == [False, True]
    assert result.notes[0].endswith("mm left")
    assert result.notes[1] == ""
    assert f"{1e3 * result.error_after[0]:.2f} mm" in result.notes[0]
    assert result.summary.missed == ((1, result.notes[0]),)


def test_at_the_wrist_singularity_the_position_comes_first():
    nominal, actual = nominal_arm(), actual_arm()
    q = easy_poses(20)
    q[:, 4] = 0.0
    result = ec.compensate(actual, ec.Targets(q=q), nominal=nominal)
    assert result.error_after.max() < 1e-9
    left = result.angle_after > 1e-9
    assert left.any()
    assert np.array_equal(~left, result.reached)
    assert result.angle_after.max() < 1e-2
    for row in np.flatnonzero(left):
        assert "singular" in result.notes[row]
        assert "mrad of the orientation left" in result.notes[row]
    assert np.abs(result.q - q).max() <= 0.3 + 1e-9


def test_five_joints_put_the_position_right_and_say_what_is_left():
    rows = arm().rows[:5]
    nominal = replace(arm(), rows=rows, tool=Frame((0.0, 0.1, 0.2), (0.0, 0.0, 0.0), known=True))
    actual = replace(
        flawed(nominal, np.random.default_rng(1), 5e-4), elastic={"2.theta": Compliance("linear", (4e-6,))}
    )
    q = easy_poses(30)[:, :5]
    result = ec.compensate(actual, ec.Targets(q=q), nominal=nominal)
    assert result.reached.all()
    assert result.error_after.max() < 1e-9
    assert all("only 5 joints" in note for note in result.notes)


def test_a_load_at_a_transition_torque_is_named():
    """A step so large that some loads lie on neither side of it."""
    nominal = nominal_arm()
    q = easy_poses(2000)
    actual = replace(actual_arm(), elastic={"2.theta": Compliance("linear", (1e-6,))})
    torque = float(np.median(np.abs(Driver.of(actual).undeflected_loads(q.T))))
    actual = replace(actual, elastic={"2.theta": Compliance("step", (1e-6, 1e-4), torque)})
    result = ec.compensate(actual, ec.Targets(q=q), nominal=nominal)
    notes = [note for note in result.notes if note]
    assert notes
    assert all(note.startswith("load passes the transition torque of 2.theta: ") for note in notes)
    assert errors(actual, result.q, ec.predict(nominal, q))[result.reached].max() < 1e-9
    away = ~result.reached
    assert result.error_after[away].max() < (1e-4 - 1e-6) * torque * 1.8  # what the step moves, at full reach


def test_a_robot_too_soft_names_the_target():
    soft = replace(nominal_arm(), elastic={"2.theta": Compliance("linear", (1.0,))})
    with pytest.raises(ec.EquilibriumError, match=r"2\.theta does not settle under its load at target 1"):
        ec.compensate(soft, ec.Targets(q=easy_poses(3)), nominal=nominal_arm())


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"targets": ec.Targets(q=np.zeros((1, 6)))}, "are where the nominal robot would be, which is not known"),
        ({"targets": ec.Targets()}, "expected targets with positions, or joint positions of the nominal robot"),
        ({"targets": ec.Targets(np.zeros((1, 3)), load=Labels.same("light", 1))}, "arm has no load 'light'"),
        ({"targets": ec.Targets(np.zeros((1, 3)), target=Labels.same("nest", 1))}, "arm has no target 'nest'"),
        ({"nominal": replace(arm(), rows=arm().rows[:4])}, "expected a nominal robot with 6 joints as arm, found 4"),
        ({"frame": "world"}, "no frame 'world'"),
        ({"frame": "instrument"}, "where arm stands to it is not known"),
        ({"frame": "instrument", "station": "south"}, "arm has no station 'south'"),
        ({"station": "south"}, "a station is of the instrument's frame"),
        ({"start": (0.0, 1.0)}, "start: expected 6 joint positions, found 2"),
    ],
)
def test_what_cannot_be_done_is_refused(change: dict[str, object], message: str):
    request = {"targets": np.array([[0.8, 0.1, 0.6]])} | change
    with pytest.raises(ec.InputError) as caught:
        ec.compensate(arm(), **request)
    assert message in str(caught.value)


def test_the_result_prints_its_figures():
    text = str(ec.compensate(actual_arm(), ec.Targets(q=easy_poses(5)), nominal=nominal_arm()))
    assert "5 of 5 targets reached" in text
    assert "error before [mm]" in text


def test_no_targets_are_no_rows():
    result = ec.compensate(arm(), np.empty((0, 3)))
    assert len(result) == 0
    assert result.summary.targets == 0
