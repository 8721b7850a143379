"""A robot written and read again is the same robot, to the last digit."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import elastocal as ec
from elastocal.robot import Compliance, Frame, JointMap, Payload, Robot, Row
from support.files import ROBOT, edited
from support.robots import arm, random_dh_robot
from support.urdf import equipped

CONVENTIONS = ("modified-dh", "standard-dh", "urdf")


def random_robot(seed: int, convention: str) -> Robot:
    """A robot that has everything a robot file can say, frames of every degree of knowledge."""
    rng = np.random.default_rng(seed)
    robot = random_dh_robot(rng, "modified-dh" if convention == "urdf" else convention, joints=5, prismatic=0.3)
    if convention == "urdf":
        robot = replace(robot, convention="urdf", rows=tuple(_urdf_row(row, rng) for row in robot.rows))
    limited = [replace(row, limits=tuple(sorted(rng.uniform(-3.0, 3.0, 2)))) for row in robot.rows[:3]]
    fixed = replace(robot.rows[4], joint=None, sign=1, axis=(0.0, 0.0, 1.0), mass=0.0, com=(0.0, 0.0, 0.0))
    robot = equipped(replace(robot, rows=(*limited, robot.rows[3], fixed)), rng)
    other = "2.tx" if convention == "urdf" else "2.alpha"
    driven = [row.joint_element for row in robot.joints]
    return replace(
        robot,
        name='"the" robot\n№ 1',
        base=rng.choice([Frame(), replace(robot.base, known=True), Frame(robot.base.xyz)]),
        targets={"nest 1": Frame(), **robot.targets},
        loads={"a.b": Payload(), **robot.loads},
        elastic={name: Compliance("linear", (rng.uniform(1e-7, 1e-5),)) for name in (*driven[1:], other)},
        transmission={driven[0]: JointMap(tuple(rng.normal(size=3) * 1e-4), tuple(rng.normal(size=3) * 1e-4))},
    )


def _urdf_row(row: Row, rng: np.random.Generator) -> Row:
    axis = rng.normal(size=3)
    origin = Frame(tuple(rng.uniform(-1.0, 1.0, 3)), tuple(rng.uniform(-1.5, 1.5, 3)))
    return replace(row, geometry={}, origin=origin, axis=tuple((axis / np.linalg.norm(axis)).tolist()))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("robots")


@pytest.mark.parametrize("convention", CONVENTIONS)
@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=25, deadline=None)
def test_a_robot_read_again_is_the_same_and_predicts_the_same(convention: str, seed: int, folder: Path):
    robot = random_robot(seed, convention)
    ec.save_robot(robot, folder / "robot.toml")
    again = ec.load_robot(folder / "robot.toml")
    assert again == robot
    q = np.random.default_rng(seed).uniform(-1.0, 1.0, (3, robot.positions))
    for names in ({}, {"station": "north", "target": "far", "load": "heavy"}):
        for found, expected in zip(ec.predict(again, q, **names), ec.predict(robot, q, **names), strict=True):
            np.testing.assert_array_equal(found, expected)


def test_a_robot_written_twice_is_the_same_text(tmp_path: Path):
    ec.save_robot(random_robot(1, "urdf"), tmp_path / "one.toml")
    ec.save_robot(ec.load_robot(tmp_path / "one.toml"), tmp_path / "two.toml")
    assert (tmp_path / "one.toml").read_bytes() == (tmp_path / "two.toml").read_bytes()


def load(folder: Path, text: str) -> Robot:
    """The robot of a text."""
    (folder / "robot.toml").write_text(text)
    return ec.load_robot(folder / "robot.toml")


def test_stiffness_becomes_compliance(tmp_path: Path):
    text = edited(ROBOT, ("d = 0.4", "stiffness = 2.0e5"), ("a = 0.2", "stiffness = 1.0e6"))
    text = edited(text, ('joint = "revolute"\nmass', 'joint = "prismatic"\nmass'))
    robot = load(tmp_path, text)
    assert robot.elastic == {
        "1.theta": Compliance("linear", (5e-6,)),
        "elbow.d": Compliance("linear", (1e-6,)),
    }


def test_an_elastic_table_replaces_the_stiffness_of_its_row(tmp_path: Path):
    text = edited(ROBOT, ("d = 0.4", "stiffness = 2.0e5"))
    robot = load(tmp_path, text + '[elastic."1.theta"]\nlaw = "linear"\ncoefficients = [3e-6]\n')
    assert robot.elastic == {"1.theta": Compliance("linear", (3e-6,))}


def test_a_transmission_error_of_uneven_orders_is_filled_up_with_zeros(tmp_path: Path):
    robot = load(tmp_path, ROBOT + '[transmission."1.theta"]\nsin = [1e-4, 2e-4]\n')
    assert robot.transmission == {"1.theta": JointMap((1e-4, 2e-4), (0.0, 0.0))}


MILLIMETRES = """\
format = "elastocal-robot/1"
convention = "{convention}"
length_unit = "mm"
angle_unit = "deg"
[[row]]
name = "1"
{one}
joint = "revolute"
limits = [-90.0, 180.0]
mass = 3.0
com = [10.0, 20.0, 30.0]
[[row]]
name = "2"
{two}
joint = "prismatic"
limits = [-100.0, 250.0]
stiffness = 1e6
[base]
xyz = [1000.0, 0.0, 500.0]
rpy = [90.0, 45.0, -30.0]
[tool]
xyz = [0.0, 0.0, 120.0]
mass = 1.0
com = [0.0, 0.0, 60.0]
[target.t]
xyz = [1.0, 2.0, 3.0]
[load.l]
mass = 2.0
com = [4.0, 5.0, 6.0]
[station.s]
rpy = [0.0, 0.0, 60.0]
[elastic."1.theta"]
law = "linear"
coefficients = [1e-6]
"""

METRES = (
    ("com = [10.0, 20.0, 30.0]", "com = [0.01, 0.02, 0.03]"),
    ('"mm"', '"m"'),
    ('"deg"', '"rad"'),
    ("[-90.0, 180.0]", f"[{-np.pi / 2}, {np.pi}]"),
    ("[-100.0, 250.0]", "[-0.1, 0.25]"),
    ("[1000.0, 0.0, 500.0]", "[1.0, 0.0, 0.5]"),
    ("[90.0, 45.0, -30.0]", f"[{np.pi / 2}, {np.pi / 4}, {-np.pi / 6}]"),
    ("[0.0, 0.0, 120.0]", "[0.0, 0.0, 0.12]"),
    ("[0.0, 0.0, 60.0]", "[0.0, 0.0, 0.06]"),
    ("[1.0, 2.0, 3.0]", "[1e-3, 2e-3, 3e-3]"),
    ("[4.0, 5.0, 6.0]", "[4e-3, 5e-3, 6e-3]"),
    ("rpy = [0.0, 0.0, 60.0]", f"rpy = [0.0, 0.0, {np.pi / 3}]"),
)

GEOMETRY = {
    "modified-dh": (("a = 200.0\nalpha = 30.0", f"a = 0.2\nalpha = {np.pi / 6}"), ("d = 300.0", "d = 0.3")),
    "standard-dh": (
        ("b = 200.0\nbeta = 30.0", f"b = 0.2\nbeta = {np.pi / 6}"),
        ("theta = 90.0", f"theta = {np.pi / 2}"),
    ),
    "urdf": (
        ("xyz = [0.0, 200.0, 0.0]\naxis = [0.0, 3.0, 4.0]", "xyz = [0.0, 0.2, 0.0]\naxis = [0.0, 0.6, 0.8]"),
        ("rpy = [90.0, 0.0, 0.0]", f"rpy = [{np.pi / 2}, 0.0, 0.0]"),
    ),
}


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_millimetres_and_degrees_make_the_same_robot_as_metres_and_radians(tmp_path: Path, convention: str):
    (one, one_si), (two, two_si) = GEOMETRY[convention]
    given = load(tmp_path, MILLIMETRES.format(convention=convention, one=one, two=two))
    metres = load(tmp_path, edited(MILLIMETRES, *METRES).format(convention=convention, one=one_si, two=two_si))
    assert numbers(given) == pytest.approx(numbers(metres), rel=1e-12, abs=1e-15)
    assert len(numbers(given)) > 40
    assert (
        given.elastic
        == metres.elastic
        == {"1.theta": Compliance("linear", (1e-6,)), "2.d": Compliance("linear", (1e-6,))}
    )


def numbers(value: object) -> list[float]:
    """All numbers of a robot, in order."""
    if isinstance(value, (int, float)):
        return [float(value)]
    if isinstance(value, dict):
        return [number for item in value.values() for number in numbers(item)]
    if isinstance(value, (list, tuple)):
        return [number for item in value for number in numbers(item)]
    named = ("rows", "base", "tool", "tool_load", "targets", "loads", "stations", "elastic")
    named += ("geometry", "origin", "axis", "limits", "mass", "com", "xyz", "rpy", "coefficients")
    return [number for name in named for number in numbers(getattr(value, name, ()) or ())]


def test_what_a_robot_file_leaves_out_is_zero_or_open(tmp_path: Path):
    robot = load(
        tmp_path, 'format = "elastocal-robot/1"\nconvention = "standard-dh"\n[[row]]\nname = 7\njoint = "revolute"'
    )
    (row,) = robot.rows
    assert row == Row("7", "revolute", dict.fromkeys(("alpha", "a", "beta", "b", "theta", "d"), 0.0))
    assert (robot.name, robot.gravity, robot.base, robot.tool) == ("robot", (0.0, 0.0, -9.81), Frame(), Frame())


def test_a_robot_written_by_hand_of_python_has_its_units_in_si(tmp_path: Path):
    ec.save_robot(arm(elastic=True), tmp_path / "arm.toml")
    text = (tmp_path / "arm.toml").read_text()
    assert 'length_unit = "m"\nangle_unit = "rad"\n' in text
    assert ec.load_robot(tmp_path / "arm.toml").elastic == arm(elastic=True).elastic
