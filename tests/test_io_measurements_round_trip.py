"""Measurements written and read again are the same, as CSV and as Parquet."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import elastocal as ec
from elastocal.measurements import Labels, Measurements
from elastocal.robot import Frame, Payload, Robot
from support.robots import random_dh_robot

OPTIONAL = (
    "position",
    "orientation",
    "distance",
    "sigma",
    "sigma_angle",
    "load",
    "station",
    "wrench",
    "pose",
    "temperature",
)


def robot_of(seed: int) -> Robot:
    """A random robot with turning and sliding joints, two targets, a payload and a station."""
    robot = random_dh_robot(np.random.default_rng(seed), "modified-dh", joints=4, prismatic=0.4)
    return replace(
        robot,
        targets={"near": Frame(), "far": Frame((0.1, 0.0, 0.0))},
        loads={"heavy": Payload(20.0)},
        stations={"north": Frame()},
    )


def random_measurements(seed: int, parts: set[str], n: int = 7) -> Measurements:
    """Measurements of which some parts are there."""
    rng = np.random.default_rng(seed)
    whole = Measurements(
        q=rng.uniform(-3.0, 3.0, (n, 4)),
        position=rng.uniform(-2.0, 2.0, (n, 3)),
        orientation=Rotation.random(n, rng=rng).as_matrix(),
        distance=rng.uniform(1.0, 5.0, n),
        sigma=np.repeat(rng.uniform(1e-5, 1e-4, (n, 1)), 3, axis=1),
        sigma_angle=rng.uniform(1e-5, 1e-4, n),
        target=Labels.of(rng.choice(["near", "far"], n).tolist()),
        load=Labels.of([None, *rng.choice(["heavy", ""], n - 1).tolist()]),
        station=Labels.of(["north"] * n),
        wrench=rng.normal(size=(n, 6)) * 50.0,
        pose=np.array([0, 0, 1, -1, 2, 1, -1]),
        temperature=rng.uniform(15.0, 30.0, n),
    )
    whole = replace(whole, load=Labels.of([name or None for name in map(whole.load.name, whole.load.codes.tolist())]))
    return replace(whole, **{name: None for name in OPTIONAL if name not in parts})


def assert_same(found: Measurements, expected: Measurements, tolerance: float = 1e-12) -> None:
    """The same to a tolerance, names and pose numbers up to their codes."""
    for field in fields(Measurements):
        one, other = getattr(found, field.name), getattr(expected, field.name)
        if field.name in ("source", "row"):
            continue
        assert (one is None) == (other is None), field.name
        if isinstance(one, Labels):
            assert [one.name(code) for code in one.codes] == [other.name(code) for code in other.codes]
        elif field.name == "pose" and one is not None:
            np.testing.assert_array_equal(one < 0, other < 0)
            np.testing.assert_array_equal(one[:, None] == one, other[:, None] == other)
        elif one is not None:
            np.testing.assert_allclose(one, other, rtol=tolerance, atol=tolerance, err_msg=field.name)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("measurements")


@given(
    seed=st.integers(0, 2**32 - 1),
    kinds=st.sets(st.sampled_from(OPTIONAL[:3]), min_size=1),
    others=st.sets(st.sampled_from(OPTIONAL[3:])),
)
@settings(max_examples=50, deadline=None)
def test_measurements_read_again_are_the_same(seed: int, kinds: set[str], others: set[str], folder: Path):
    robot, data = robot_of(seed), random_measurements(seed, kinds | others)
    ec.save_measurements(data, robot, folder / "data.csv")
    again = ec.load_measurements(folder / "data.csv", robot)
    assert_same(again, data)
    assert [again.place(row) for row in (0, 6)] == ["data.csv row 1", "data.csv row 7"]


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=10, deadline=None)
def test_parquet_equals_csv(seed: int, folder: Path):
    robot = robot_of(seed)
    ec.save_measurements(random_measurements(seed, set(OPTIONAL)), robot, folder / "data.csv")
    pl.read_csv(folder / "data.csv").write_parquet(folder / "data.parquet")
    found, expected = (ec.load_measurements(folder / f"data.{kind}", robot) for kind in ("parquet", "csv"))
    assert_same(found, expected, tolerance=0.0)


def three_turn_one_slides() -> Robot:
    """A robot whose last joint slides."""
    robot = robot_of(1)
    rows = [replace(row, joint="revolute") for row in robot.rows[:3]] + [replace(robot.rows[3], joint="prismatic")]
    return replace(robot, rows=tuple(rows))


def test_numbers_of_a_parquet_file_may_be_of_any_type(tmp_path: Path):
    columns = {f"q{i}": pl.Series([1, 2], dtype=pl.Int8) for i in range(1, 5)}
    columns |= {name: pl.Series([0.5, 0.25], dtype=pl.Float32) for name in "xyz"} | {"target": ["near", "far"]}
    pl.DataFrame(columns | {"pose": [7, None]}).write_parquet(tmp_path / "data.parquet")
    found = ec.load_measurements(tmp_path / "data.parquet", three_turn_one_slides())
    np.testing.assert_array_equal(found.position, [[0.5] * 3, [0.25] * 3])
    assert found.pose.tolist() == [0, -1]


def test_standard_deviations_that_differ_by_axis_are_written_as_their_root_mean_square(tmp_path: Path):
    robot, data = robot_of(1), random_measurements(1, {"position"})
    data = replace(data, sigma=np.tile([1e-5, 2e-5, 2e-5], (7, 1)))
    ec.save_measurements(data, robot, tmp_path / "data.csv")
    found = ec.load_measurements(tmp_path / "data.csv", robot)
    np.testing.assert_allclose(found.sigma, np.sqrt(3e-10))


def test_rows_that_lack_what_others_have_are_not_written(tmp_path: Path):
    robot, data = robot_of(1), random_measurements(1, {"position", "temperature"})
    data.position[2] = np.nan
    data.temperature[5] = np.nan
    with pytest.raises(ec.InputError) as refused:
        ec.save_measurements(data, robot, tmp_path / "data.csv")
    assert refused.value.faults == (
        "row 3 has no position, which others have: write them to separate files",
        "row 6 has no temperature, which others have: write them to separate files",
    )
    assert not (tmp_path / "data.csv").exists()


UNITS = """\
q1 [rad],q2[mrad], q3 [°] ,q4 [cm],x [m],y [mm],z [in],sigma [µm],sigma_angle [deg],\
wrench_fx [kN],wrench_fy [N],wrench_fz,wrench_mx [N·m],wrench_my [Nmm],wrench_mz [N m],temperature [°C],target
0.1,200,30,40,1,2000,100,50,1,1,2,3,4,5000,6,21.5,near
"""


def test_every_unit_is_turned_into_si(tmp_path: Path):
    (tmp_path / "data.csv").write_text(UNITS)
    found = ec.load_measurements(tmp_path / "data.csv", three_turn_one_slides())
    np.testing.assert_allclose(found.q, [[0.1, 0.2, np.pi / 6, 0.4]])
    np.testing.assert_allclose(found.position, [[1.0, 2.0, 2.54]])
    np.testing.assert_allclose(found.sigma, [[5e-5] * 3])
    np.testing.assert_allclose(found.sigma_angle, [np.pi / 180.0])
    np.testing.assert_allclose(found.wrench, [[1000.0, 2.0, 3.0, 4.0, 5.0, 6.0]])
    assert found.temperature.tolist() == [21.5]


@pytest.mark.parametrize("ending", ["\n", "\r\n"])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
@pytest.mark.parametrize("tail", ["", "\n", "\n,,,,,,,\n\n"])
def test_line_endings_byte_order_marks_and_empty_lines_at_the_end_do_no_harm(
    tmp_path: Path, ending: str, mark: str, tail: str
):
    header = " q1 , q2,q3,q4 [mm],x,y,z,target"
    text = f'{mark}{header}\n0.1,0.2, 0.3 ,0.4,"1",2,3, near \n0.2,1e-1,+.3,0.4,1,2,3,far{tail}'
    (tmp_path / "data.csv").write_bytes(text.replace("\n", ending).encode())
    found = ec.load_measurements(tmp_path / "data.csv", three_turn_one_slides())
    np.testing.assert_allclose(found.q, [[0.1, 0.2, 0.3, 4e-4], [0.2, 0.1, 0.3, 4e-4]])
    assert found.target.names == ("near", "far")
