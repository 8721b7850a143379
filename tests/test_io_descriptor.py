"""An instrument's own file and its descriptor say the same as a tidy table."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import elastocal as ec
from elastocal.robot import Frame, Robot
from support.files import DESCRIPTOR, ROBOT, TRACKER, edited

AXES = [axes for axes in product("XYZ", repeat=3) if axes[0] != axes[1] != axes[2]]
EULER = ["euler-" + "".join(axes) for axes in AXES]
ANGLES = np.array([[10.0, -20.0, 30.0], [-170.0, 80.0, 5.0]])


@pytest.fixture
def robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Robot:
    """A robot; the folder of the test is the current one."""
    monkeypatch.chdir(tmp_path)
    Path("robot.toml").write_text(ROBOT)
    return ec.load_robot("robot.toml")


def about(axis: str, degrees: float) -> NDArray[np.float64]:
    """The rotation about x, y or z."""
    i = "xyz".index(axis)
    j, k = (i + 1) % 3, (i + 2) % 3
    turn = np.eye(3)
    turn[[j, k], [j, k]] = np.cos(np.radians(degrees))
    turn[k, j], turn[j, k] = np.sin(np.radians(degrees)), -np.sin(np.radians(degrees))
    return turn


def described(robot: Robot, descriptor: str, table: str) -> ec.Measurements:
    """The measurements of a described file."""
    Path("tracker.csv").write_text(table)
    Path("tracker.toml").write_text(descriptor)
    return ec.load_measurements("tracker.toml", robot)


def oriented(robot: Robot, convention: str, values: NDArray[np.float64], unit: str = "") -> NDArray[np.float64]:
    """The orientations of a file that has them in some convention."""
    names = [f"o{i}" for i in range(values.shape[1])]
    descriptor = (
        'format = "elastocal-measurements/1"\nfile = "tracker.csv"\n[columns]\nq = { columns = ["a", "b"] }\n'
        f'orientation = {{ columns = {names}, convention = "{convention}"{unit and f", unit = {unit!r}"} }}\n'
    )
    rows = [",".join(map(repr, [0.1 * i, 0.2, *row])) for i, row in enumerate(values.tolist())]
    data = described(robot, descriptor, "\n".join([",".join(["a", "b", *names]), *rows]))
    assert data.orientation is not None
    return data.orientation


@pytest.mark.parametrize("convention", EULER)
def test_capitals_are_intrinsic_small_letters_extrinsic(robot: Robot, convention: str):
    axes = convention.removeprefix("euler-").lower()
    turns = [[about(axis, angle) for axis, angle in zip(axes, row, strict=True)] for row in ANGLES]
    intrinsic = oriented(robot, convention, ANGLES, "deg")
    np.testing.assert_allclose(intrinsic, [one @ two @ three for one, two, three in turns], atol=1e-15)
    extrinsic = oriented(robot, convention.lower(), np.radians(ANGLES))
    np.testing.assert_allclose(extrinsic, [three @ two @ one for one, two, three in turns], atol=1e-15)


def test_quaternions_rotation_vectors_and_matrices_are_read(robot: Robot):
    half = np.radians(15.0)
    about_x = about("x", 30.0)
    for convention, values in (
        ("quaternion-wxyz", [np.cos(half), np.sin(half), 0.0, 0.0]),
        ("quaternion-xyzw", [np.sin(half), 0.0, 0.0, np.cos(half)]),
        ("quaternion-wxyz", [-np.cos(half), -np.sin(half), 0.0, 0.0]),
        ("rotation-vector", [2.0 * half, 0.0, 0.0]),
        ("matrix", about_x.ravel()),
    ):
        np.testing.assert_allclose(oriented(robot, convention, np.array([values])), [about_x], atol=1e-15)
    np.testing.assert_allclose(
        oriented(robot, "rotation-vector", np.array([[30.0, 0, 0]]), "deg"), [about_x], atol=1e-15
    )


def test_a_matrix_of_few_digits_is_made_a_rotation(robot: Robot):
    (found,) = oriented(robot, "matrix", about("z", 30.0).round(3).reshape(1, 9))
    np.testing.assert_allclose(found @ found.T, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(found, about("z", 30.0), atol=1e-3)


TIDY = """\
q1 [deg],q2 [deg],x [mm],y [mm],z [mm],sigma [mm]
10.5,20,100.5,200,300,0.1
11.5,21,101.5,201,301,0.1
"""


@pytest.mark.parametrize("delimiter", [";", "\t", " ", "|", ":"])
@pytest.mark.parametrize("decimal", [",", "."])
def test_other_delimiters_and_decimal_marks_say_the_same_as_the_tidy_table(robot: Robot, delimiter: str, decimal: str):
    Path("tidy.csv").write_text(TIDY)
    orientation = DESCRIPTOR.splitlines()[-1]
    descriptor = edited(
        DESCRIPTOR,
        ('";"', f'"{delimiter}"'.replace("\t", "\\t")),
        ('","', f'"{decimal}"'),
        (orientation, 'sigma = { columns = ["std"], unit = "mm" }'),
    )
    found = described(robot, descriptor, TRACKER.replace(",", decimal).replace(";", delimiter))
    expected = ec.load_measurements("tidy.csv", robot)
    for name in ("q", "position", "sigma"):
        np.testing.assert_array_equal(getattr(found, name), getattr(expected, name))
    assert [found.place(row) for row in (0, 1)] == ["tracker.toml row 1", "tracker.toml row 2"]


def test_lines_above_the_header_are_skipped(robot: Robot):
    descriptor = edited(DESCRIPTOR, ('decimal = ","', 'decimal = ","\nskip = 3'))
    found = described(robot, descriptor, 'Leica "AT960";;\n\n# Monday; 20,5 °C\n' + TRACKER)
    expected = described(robot, DESCRIPTOR, TRACKER)
    np.testing.assert_array_equal(found.position, expected.position)


def test_names_come_from_a_column_or_are_the_same_for_all_rows(robot: Robot):
    robot = replace(robot, targets={"a": Frame(), "b": Frame()})
    names = '\ntarget = { column = "probe" }\nload = { value = "heavy" }\nstation = { value = "north" }\n'
    found = described(robot, DESCRIPTOR + names, edited(TRACKER, ("0,1;a", "0,1; b ")))
    labels = (found.target, found.load, found.station)
    assert [[part.name(code) for code in part.codes] for part in labels] == [["b", "a"], ["heavy"] * 2, ["north"] * 2]


def test_everything_else_that_may_be_measured_is_read(robot: Robot):
    descriptor = edited(
        DESCRIPTOR,
        ("orientation", "# orientation"),
        ("position", "distance = { columns = ['std'], unit = 'cm' }\nforce"),
        ('"mz"], unit = "mm"', '"mz"], unit = "kN"'),
    )
    descriptor += (
        "moment = { columns = ['rx', 'ry', 'rz'], unit = 'Nmm' }\n"
        "sigma = { columns = ['rx', 'ry', 'rz'], unit = 'um' }\n"
        "sigma_angle = { columns = ['rx', 'ry', 'rz'], unit = 'mrad' }\ntemperature = { columns = ['wrist'] }\n"
        "pose = { column = 'probe' }\n"
    )
    found = described(robot, descriptor, TRACKER)
    np.testing.assert_allclose(found.distance, [1e-3, 1e-3])
    np.testing.assert_allclose(found.wrench[0], [100_500.0, 200_000.0, 300_000.0, 0.01, 0.02, 0.03])
    np.testing.assert_allclose(found.sigma[0], [1e-5, 2e-5, 3e-5])
    np.testing.assert_allclose(found.sigma_angle[0], np.sqrt((1.0 + 4.0 + 9.0) / 3.0) * 1e-2)
    assert found.temperature.tolist() == [20.0, 21.0]
    assert found.pose.tolist() == [0, 0]


def test_a_force_alone_has_no_moment(robot: Robot):
    descriptor = DESCRIPTOR + "force = { columns = ['rx', 'ry', 'rz'] }\n"
    np.testing.assert_allclose(described(robot, descriptor, TRACKER).wrench[0], [10.0, 20.0, 30.0, 0.0, 0.0, 0.0])


def test_a_descriptor_may_describe_a_parquet_file(robot: Robot):
    import polars as pl

    pl.read_csv(TRACKER.replace(",", ".").encode(), separator=";").write_parquet("tracker.parquet")
    Path("parquet.toml").write_text(edited(DESCRIPTOR, ("tracker.csv", "tracker.parquet")))
    found, expected = ec.load_measurements("parquet.toml", robot), described(robot, DESCRIPTOR, TRACKER)
    np.testing.assert_array_equal(found.position, expected.position)
    np.testing.assert_array_equal(found.orientation, expected.orientation)


@given(seed=st.integers(0, 2**32 - 1), convention=st.sampled_from([*EULER, *map(str.lower, EULER)]))
@settings(max_examples=40, deadline=None)
def test_whatever_the_convention_the_orientation_read_is_a_rotation(
    seed: int, convention: str, tmp_path_factory: pytest.TempPathFactory
):
    folder = tmp_path_factory.mktemp("described")
    (folder / "robot.toml").write_text(ROBOT)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        values = np.random.default_rng(seed).uniform(-360.0, 360.0, (3, 3))
        found = oriented(ec.load_robot("robot.toml"), convention, values, "deg")
    np.testing.assert_allclose(found @ found.transpose(0, 2, 1), np.tile(np.eye(3), (3, 1, 1)), atol=1e-14)
    np.testing.assert_allclose(np.linalg.det(found), 1.0)
