"""A cluster of one scheduler and two workers, started as docs/cluster.md says: the same results, whatever is killed."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import polars as pl
import pytest

from elastocal.errors import WorkerLostError
from elastocal.parallel import Cluster, completed, in_order
from support.clusters import RunningCluster, cluster
from support.files import Desk
from support.fleets import save_fleet
from support.work import Marking, fail, square

STUDY = """\
format = "elastocal-study/1"
repeats = 15
measures = ["coverage"]
[actual]
geometry_error = "0.5mm,0.5mrad"
[actual.elastic.2]
compliance = [1e-6, 3e-6]
[setting]
noise = "0.03mm"
[grid]
poses = [20, 45]
law = ["rigid", "linear"]
"""

PATIENCE = 300.0
"""Seconds in which a command must have got somewhere, on a machine with much else to do."""

TIMES = {"seconds"}
"""Columns that are not the same twice."""


@pytest.fixture(scope="module")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningCluster]:
    """Two workers."""
    with cluster(2, tmp_path_factory.mktemp("cluster")) as found:
        yield found


def study_table(folder: Path) -> pl.DataFrame:
    table = pl.scan_parquet(folder / "parts" / "*.parquet").sort("cell", "repeat").collect()
    return table.drop(*TIMES)


def fleet_parameters(folder: Path) -> dict[str, object]:
    found = {}
    for path in sorted(folder.rglob("result.json")):
        values = json.loads(path.read_text())
        found[str(path.relative_to(folder))] = (values["parameters"], values["covariance"], values["residuals"])
    return found


def test_a_fleet_on_the_cluster_is_the_local_one_bit_for_bit(running: RunningCluster, tmp_path: Path):
    save_fleet(tmp_path, 20)
    desk = Desk(tmp_path)
    desk.done("fleet fleet.csv -o here --jobs 1")
    desk.done(f"fleet fleet.csv -o there --scheduler {running.address}")
    here, there = (fleet_parameters(tmp_path / name) for name in ("here", "there"))
    assert len(here) == 20
    assert here == there


def test_a_study_on_the_cluster_is_the_local_one_bit_for_bit(
    running: RunningCluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    desk = Desk(tmp_path)
    desk.write(study_toml=STUDY)
    desk.done("study study.toml -o here --jobs 2")
    monkeypatch.setenv("ELASTOCAL_SCHEDULER", running.address)
    desk.done("study study.toml -o there")
    here, there = (study_table(tmp_path / name) for name in ("here", "there"))
    assert len(here) == 60
    assert here.equals(there)


def test_maps_and_errors_on_the_cluster(running: RunningCluster):
    with Cluster(running.address) as found:
        assert found.workers == 2
        assert list(in_order(square, range(20), found)) == [x * x for x in range(20)]
        with pytest.raises(ValueError, match="three"):
            list(in_order(fail, range(6), found))


def test_a_killed_worker_loses_nothing_and_an_item_that_kills_them_is_named(tmp_path: Path):
    with cluster(6, tmp_path) as running, Cluster(running.address) as found:
        (tmp_path / "once").mkdir()
        marked = Marking(tmp_path / "once", once=(3,))
        assert sorted(completed(marked, range(12), found)) == [(x, x * x) for x in range(12)]
        assert (tmp_path / "once" / "3-1").exists()
        (tmp_path / "always").mkdir()
        with pytest.raises(WorkerLostError, match="cost several workers their lives"):
            list(completed(Marking(tmp_path / "always", always=(1,)), [1], found))


def started(desk: Desk, command: str) -> subprocess.Popen[bytes]:
    """The command in a process of its own."""
    line = [sys.executable, "-m", "elastocal", *command.split()]
    return subprocess.Popen(line, cwd=desk.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def wait_for(folder: Path, pattern: str, count: int) -> None:
    end = time.monotonic() + PATIENCE
    while len(list(folder.glob(pattern))) < count:
        assert time.monotonic() < end, f"fewer than {count} {pattern} after {PATIENCE:g} s"
        time.sleep(0.01)


@pytest.mark.parametrize("where", ["--jobs 2", "--jobs 1", "cluster"])
def test_a_killed_command_goes_on_and_repeats_nothing(running: RunningCluster, tmp_path: Path, where: str):
    desk = Desk(tmp_path)
    save_fleet(tmp_path, 12)
    place = f"--scheduler {running.address}" if where == "cluster" else where
    process = started(desk, f"fleet fleet.csv -o out {place}")
    wait_for(tmp_path / "out", "*/*/fleet.json", 3)
    process.send_signal(signal.SIGKILL)
    process.wait()
    there = {path: path.stat().st_mtime_ns for path in (tmp_path / "out").glob("*/*/result.json")}
    desk.done(f"fleet fleet.csv -o out {place}")
    assert {path: path.stat().st_mtime_ns for path in there} == there
    desk.done("fleet fleet.csv -o whole --jobs 1")
    assert fleet_parameters(tmp_path / "out") == fleet_parameters(tmp_path / "whole")
    assert list((tmp_path / "out").rglob(".*")) == []


def test_a_killed_study_goes_on_and_repeats_nothing(tmp_path: Path):
    desk = Desk(tmp_path)
    desk.write(study_toml=STUDY)
    process = started(desk, "study study.toml -o out --jobs 2")
    wait_for(tmp_path / "out", "parts/*.parquet", 2)
    process.send_signal(signal.SIGKILL)
    process.wait()
    there = {path: path.stat().st_mtime_ns for path in (tmp_path / "out" / "parts").glob("*.parquet")}
    desk.done("study study.toml -o out --jobs 2")
    assert {path: path.stat().st_mtime_ns for path in there} == there
    desk.done("study study.toml -o whole --jobs 1")
    found = study_table(tmp_path / "out")
    assert set(Counter(zip(found["cell"], found["repeat"], strict=True)).values()) == {1}
    assert found.equals(study_table(tmp_path / "whole"))


def children(pid: int) -> list[int]:
    """Processes whose parent is one, and theirs."""
    own = [
        int(path.parent.name)
        for path in Path("/proc").glob("[0-9]*/stat")
        if f") S {pid} " in (text := path.read_text()) or f") R {pid} " in text
    ]
    return own + [grandchild for child in own for grandchild in children(child)]


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="asks /proc for the processes")
def test_processes_end_with_a_killed_command_and_ctrl_c_is_said(tmp_path: Path):
    desk = Desk(tmp_path)
    desk.write(study_toml=STUDY.replace("repeats = 15", "repeats = 400"))
    process = started(desk, "study study.toml -o out --jobs 2")
    wait_for(tmp_path / "out", "parts/*.parquet", 1)
    ours = children(process.pid)
    assert len(ours) >= 2
    process.send_signal(signal.SIGKILL)
    process.wait()
    end = time.monotonic() + 30.0
    while any(Path(f"/proc/{pid}").exists() for pid in ours):
        assert time.monotonic() < end, "a worker outlives its command"
        time.sleep(0.05)


@pytest.mark.parametrize("jobs", [1, 2])
def test_ctrl_c_ends_cleanly_and_keeps_what_is_done(tmp_path: Path, jobs: int):
    desk = Desk(tmp_path)
    desk.write(study_toml=STUDY.replace("repeats = 15", "repeats = 400"))
    line = [sys.executable, "-m", "elastocal", "study", "study.toml", "-o", "out", "--jobs", str(jobs)]
    process = subprocess.Popen(
        line, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True
    )
    wait_for(tmp_path / "out", "parts/*.parquet", 2)
    os.killpg(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=PATIENCE)
    assert process.returncode == 130
    assert out == b""
    told = err.decode()
    assert "Traceback" not in told
    assert "of 1600 calibrations are done; the same command goes on from there (out)" in told
    assert len(study_table(tmp_path / "out")) % 10 == 0
