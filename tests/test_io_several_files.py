"""Measurements of several files, one after the other."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
import pytest

import elastocal as ec
from elastocal.io import data_hashes
from elastocal.robot import Robot
from support.files import DESCRIPTOR, ROBOT, TABLE, TRACKER


@pytest.fixture
def robot(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Robot:
    """A robot; the folder of the test is the current one."""
    monkeypatch.chdir(tmp_path)
    Path("robot.toml").write_text(ROBOT)
    return ec.load_robot("robot.toml")


def test_rows_keep_their_order_their_file_and_their_number(robot: Robot):
    Path("one.csv").write_text(TABLE)
    Path("two.csv").write_text("q1,q2,x,y,z\n0.1,0.2,1,2,3\n")
    data = ec.load_measurements(["two.csv", Path("one.csv")], robot)
    assert [data.place(row) for row in range(4)] == ["two.csv row 1", "one.csv row 1", "one.csv row 2", "one.csv row 3"]
    np.testing.assert_allclose(data.position[:, 0], [1.0, 0.1, 0.101, 0.102])


def test_files_of_one_name_are_told_apart_by_their_folders(robot: Robot):
    for day in ("monday", "tuesday"):
        Path(day).mkdir()
        Path(day, "fit.csv").write_text(TABLE)
    Path("other.csv").write_text(TABLE)
    data = ec.load_measurements(["monday/fit.csv", "tuesday/fit.csv", "other.csv"], robot)
    assert data.source.names == (str(Path("monday/fit.csv")), str(Path("tuesday/fit.csv")), "other.csv")


def test_pose_numbers_of_two_files_stay_apart(robot: Robot):
    Path("one.csv").write_text("q1,q2,x,y,z,pose\n0.1,0.2,1,2,3,A\n0.1,0.2,1,2,4,A\n0.5,0.2,1,2,5,B\n")
    Path("two.csv").write_text("q1,q2,x,y,z,pose\n1.1,0.2,1,2,3,A\n1.1,0.2,1,2,4,\n1.5,0.2,1,2,5,B\n")
    Path("none.csv").write_text("q1,q2,x,y,z\n2.1,0.2,1,2,3\n")
    pose = ec.load_measurements(["one.csv", "none.csv", "two.csv"], robot).pose.tolist()
    assert pose[0] == pose[1]
    assert pose[3] == pose[5] == -1
    assert len({pose[0], pose[2], pose[4], pose[6]} - {-1}) == 4


def test_what_a_file_lacks_is_not_a_number_or_no_name(robot: Robot):
    Path("one.csv").write_text("q1,q2,x,y,z,sigma,load\n0.1,0.2,1,2,3,1e-5,heavy\n")
    Path("two.csv").write_text("q1,q2,distance,station,temperature\n0.3,0.4,2,north,20\n")
    data = ec.load_measurements(["one.csv", "two.csv"], robot)
    np.testing.assert_array_equal(data.position, [[1.0, 2.0, 3.0], [np.nan] * 3])
    np.testing.assert_array_equal(data.distance, [np.nan, 2.0])
    np.testing.assert_array_equal(data.sigma, [[1e-5] * 3, [np.nan] * 3])
    np.testing.assert_array_equal(data.temperature, [np.nan, 20.0])
    assert [labels.codes.tolist() for labels in (data.load, data.station)] == [[0, -1], [-1, 0]]
    assert data.target is None


def test_a_file_without_wrenches_has_none_of_its_rows_pressed(robot: Robot):
    Path("one.csv").write_text("q1,q2,x,y,z," + ",".join(f"wrench_{k}" for k in ("fx", "fy", "fz", "mx", "my", "mz")))
    with Path("one.csv").open("a") as file:
        file.write("\n0.1,0.2,1,2,3,1,2,3,4,5,6\n")
    Path("two.csv").write_text("q1,q2,x,y,z\n0.1,0.3,1,2,3\n")
    data = ec.load_measurements(["one.csv", "two.csv"], robot)
    np.testing.assert_array_equal(data.wrench, [[1, 2, 3, 4, 5, 6], [0] * 6])


def test_hashes_are_of_the_rows_so_a_descriptor_may_be_reworded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    Path("one.csv").write_text(TABLE)
    Path("tracker.csv").write_text(TRACKER)
    Path("tracker.toml").write_text(DESCRIPTOR)
    expected = [hashlib.sha256(text.encode()).hexdigest() for text in (TABLE, TRACKER)]
    assert data_hashes(["one.csv", "tracker.toml"]) == expected
    Path("tracker.toml").write_text("# the tracker of hall 3\n" + DESCRIPTOR)
    assert data_hashes(["one.csv", "tracker.toml"]) == expected


def test_faults_of_a_second_file_are_told_with_its_name(robot: Robot):
    Path("one.csv").write_text(TABLE)
    Path("two.csv").write_text(TABLE.replace("101", "n/a"))
    with pytest.raises(ec.InputError, match=r"two.csv: row 2, column 'x \[mm\]': expected a number, found 'n/a'"):
        ec.load_measurements(["one.csv", "two.csv"], robot)
