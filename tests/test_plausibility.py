"""Faults of a data set as a whole are named, not fitted; robots that are only far off are left alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from elastocal.errors import InputError
from elastocal.identification import calibrate, plausibility
from elastocal.measurements import Labels, Measurements, concatenate
from elastocal.robot import Frame, Robot
from elastocal.simulation import random_poses, simulate
from support.outliers import NOISE, as_built, spoiled
from support.robots import arm

Spoil = Callable[[Measurements], Measurements]


def moved(**changes: Callable[[np.ndarray], np.ndarray]) -> Spoil:
    """Changes columns by name."""
    return lambda data: replace(data, **{name: change(getattr(data, name)) for name, change in changes.items()})


def flipped(joint: int) -> np.ndarray:
    return np.where(np.arange(6) == joint, -1.0, 1.0)


AXES = {
    "mirrored": moved(position=lambda p: p * [1.0, -1.0, 1.0]),
    "x and y swapped": moved(position=lambda p: p[:, [1, 0, 2]]),
}

ANYWHERE = {
    "positions are 1000 times too large: mm read as m": moved(position=lambda p: 1000.0 * p),
    "positions are 1000 times too small: m read as mm": moved(position=lambda p: p / 1000.0),
    "positions are 25.4 times too large": moved(position=lambda p: p * 25.4),
    "joint angles are 57.3 times too large: deg read as rad": moved(q=np.degrees),
    "joint angles are 57.3 times too small: rad read as deg": moved(q=np.radians),
    "the joint columns are shifted by one": moved(q=lambda q: np.roll(q, 1, axis=1)),
    "give q6, q1, q2, q3, q4, q5 as q1": moved(q=lambda q: np.roll(q, -1, axis=1)),
    "the joints q2 and q3 are swapped": moved(q=lambda q: q[:, [0, 2, 1, 3, 4, 5]]),
    "the joints q4 and q6 are swapped": moved(q=lambda q: q[:, [0, 1, 2, 5, 4, 3]]),
    "the joints are in reverse order": moved(q=lambda q: q[:, ::-1]),
    "q1 is counted the other way": moved(q=lambda q: q * flipped(0)),
    "q5 is counted the other way": moved(q=lambda q: q * flipped(4)),
    "each reading stands one row below its joint positions": moved(q=lambda q: np.roll(q, 1, axis=0)),
}


def measured(actual: Robot, seed: int, count: int = 60, **options: object) -> Measurements:
    options = {"noise": NOISE, "noise_angle": 1e-4, **options}
    return simulate(actual, random_poses(actual, count, seed), seed=seed, **options)


def far_tool(robot: Robot, seed: int) -> Robot:
    """The robot with a tool that reaches up to half a metre along each axis."""
    xyz = tuple(np.random.default_rng(seed).uniform(-0.5, 0.5, 3).tolist())
    return replace(robot, tool=replace(robot.tool, xyz=xyz))


def named(robot: Robot, data: Measurements) -> str:
    """What a calibration says is wrong with the data."""
    with pytest.raises(InputError) as raised:
        calibrate(robot, data)
    return str(raised.value)


@pytest.mark.parametrize("fault", ANYWHERE)
@pytest.mark.parametrize("kinds", [("position",), ("position", "orientation")])
def test_a_fault_is_named_with_unknown_base_and_tool(kinds: tuple[str, ...], fault: str):
    seed = len(fault) + len(kinds)
    told = named(arm(), ANYWHERE[fault](measured(far_tool(as_built(seed), seed), seed, kinds=kinds)))
    assert fault in told
    assert "; or " not in told


@pytest.mark.parametrize("fault", ANYWHERE)
def test_a_fault_is_named_with_a_known_base_and_outliers(fault: str):
    actual = far_tool(as_built(2), 2)
    data, _ = spoiled(measured(actual, 2), 2)
    assert fault in named(replace(arm(), base=actual.base), ANYWHERE[fault](data))


@pytest.mark.parametrize("fault", AXES)
def test_mirrored_points_are_left_handed_whichever_axes_are_meant(fault: str):
    for seed in range(4):
        told = named(arm(), AXES[fault](measured(far_tool(as_built(seed), seed), seed)))
        assert "the points are mirrored (left-handed): two of the axes x, y, z are swapped, or one" in told
        assert "swap two of the columns x, y, z, or change the sign of one" in told


@pytest.mark.parametrize("known", [True, False])
def test_swapped_axes_are_named_where_base_or_orientations_tell_them(known: bool):
    actual = far_tool(as_built(3), 3)
    nominal = replace(arm(), base=actual.base) if known else arm()
    data = measured(actual, 3, kinds=("position",) if known else ("position", "orientation"))
    told = named(nominal, AXES["x and y swapped"](data))
    assert "the axes x and y are swapped (a left-handed, mirrored set of points)" in told
    assert told.endswith("give y, x, z as x, y, z")
    told = named(nominal, AXES["mirrored"](data))
    assert "y is counted the other way (a left-handed, mirrored set of points)" in told
    turned = named(nominal, moved(position=lambda p: p[:, [1, 2, 0]])(data))
    assert "the axes x, y, z are permuted" in turned
    assert turned.endswith("give z, x, y as x, y, z")


def test_axes_that_are_only_turned_are_another_instrument_frame():
    data = moved(position=lambda p: p[:, [1, 2, 0]])(measured(as_built(4, "rigid"), 4))
    assert calibrate(arm(), data).residuals["calibrated"].mean < 2e-4


@pytest.mark.parametrize("known", [True, False])
@pytest.mark.parametrize(
    ("fault", "spoil"),
    {
        "distances are 1000 times too large: mm read as m": moved(distance=lambda d: 1000.0 * d),
        "the joints q2 and q3 are swapped": ANYWHERE["the joints q2 and q3 are swapped"],
        "q5 is counted the other way": ANYWHERE["q5 is counted the other way"],
    }.items(),
)
def test_distances_have_faults_too(fault: str, spoil: Spoil, known: bool):
    actual = as_built(5)
    nominal = replace(arm(), base=actual.base) if known else arm()
    assert fault in named(nominal, spoil(measured(actual, 5, 80, kinds=("distance",))))


@pytest.mark.parametrize("fault", ["the joint columns are shifted by one", "q5 is counted the other way"])
def test_a_robot_that_is_far_off_does_not_hide_a_fault(fault: str):
    actual = as_built(6, length=5e-3, angle=np.radians(0.5))
    assert fault in named(arm(), ANYWHERE[fault](measured(actual, 6)))


def test_one_bad_file_of_several_is_named():
    actual = as_built(7)
    parts = [measured(actual, seed) for seed in (7, 8, 9)]
    parts[1] = ANYWHERE["q1 is counted the other way"](parts[1])
    data = concatenate(parts)
    files = [f"{day}.csv" for day in ("mon", "tue", "wed") for _ in range(60)]
    told = named(arm(), replace(data, source=Labels.of(files), row=np.tile(np.arange(1, 61), 3)))
    assert told.startswith("tue.csv: q1 is counted the other way")


def test_the_files_are_named_where_all_are_bad():
    data = ANYWHERE["q1 is counted the other way"](measured(as_built(7), 7))
    data = replace(data, source=Labels.of(["fit.csv"] * 60), row=np.arange(1, 61))
    assert named(arm(), data).startswith("fit.csv: q1 is counted the other way (once that is put right the nominal")


POINTS = {"nest1": (0.1, 0.0, 0.0), "nest2": (0.0, 0.1, 0.02), "nest3": (-0.08, 0.0, 0.05)}


def with_targets(robot: Robot) -> Robot:
    return replace(robot, targets={name: Frame(xyz, known=True) for name, xyz in POINTS.items()})


def renamed(data: Measurements, names: dict[str, str]) -> Measurements:
    old = data.target
    return replace(data, target=Labels.of([names.get(old.names[c], old.names[c]) for c in old.codes.tolist()]))


@pytest.mark.parametrize("known", [True, False])
def test_wrong_target_names_are_named(known: bool):
    actual = with_targets(as_built(10))
    nominal = with_targets(replace(arm(), tool=replace(actual.tool, known=known)))
    data = concatenate([measured(actual, i, 40, target=name) for i, name in enumerate(POINTS)])
    exchanged = named(nominal, renamed(data, {"nest1": "nest2", "nest2": "nest1"}))
    assert "the names of the targets 'nest1' and 'nest2' are exchanged" in exchanged
    assert exchanged.endswith("correct the column 'target'")
    one = data.take(np.flatnonzero(data.target.codes != 1))
    assert "what bears the name of target 'nest2' is 'nest1'" in named(nominal, renamed(one, {"nest1": "nest2"}))


def test_a_known_base_that_was_moved_is_named():
    actual = as_built(11)
    elsewhere = Frame((actual.base.xyz[0] + 0.5, *actual.base.xyz[1:]), actual.base.rpy, known=True)
    tool = actual.tool
    told = named(replace(arm(), base=elsewhere, tool=tool), measured(actual, 11))
    assert "base is not where the robot file has it" in told
    assert told.endswith("leave out known = true in its table [base]")


@pytest.mark.parametrize("kinds", [("position",), ("position", "orientation"), ("distance",)])
@pytest.mark.parametrize("size", ["5 mm and 0.5 deg", "joint offsets of 5 deg"])
def test_robots_that_are_only_far_off_are_left_alone(size: str, kinds: tuple[str, ...]):
    for seed in range(2):
        actual = as_built(seed, length=5e-3, angle=np.radians(0.5))
        if size.startswith("joint"):
            offsets = np.radians(5.0) * np.random.default_rng(seed).standard_normal(6)
            actual = as_built(seed).displaced({f"{i + 1}.theta": x for i, x in enumerate(offsets.tolist())})
        data = measured(actual, seed, kinds=kinds)
        if "position" in kinds:
            data, _ = spoiled(data, seed)
        calibrate(arm(), data)


def test_good_data_are_not_searched_for_faults(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(plausibility, "faults", None)
    for seed in range(3):
        calibrate(arm(), spoiled(measured(as_built(seed), seed), seed)[0])


def test_what_no_fault_explains_is_fitted_with_a_loud_warning():
    data = measured(as_built(12), 12)
    result = calibrate(arm(), replace(data, q=data.q[np.random.default_rng(0).permutation(60)]))
    assert any(warning.startswith("robot and data do not belong together") for warning in result.warnings)


def test_a_dozen_rows_are_needed_to_say_anything():
    data = ANYWHERE["q1 is counted the other way"](measured(as_built(13), 13, 11))
    assert calibrate(arm(), data).status != ""
