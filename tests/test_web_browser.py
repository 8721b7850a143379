"""The page in a browser, from upload to downloaded robot."""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

import elastocal as ec
from support.browser import Watched
from support.data import UR10, needs_ur10
from support.files import ROBOT, TABLE, edited
from support.web import Served, alive, simulated_files, wait_for

if TYPE_CHECKING:
    from playwright.sync_api import Browser


@pytest.fixture
def watched(browser: Browser) -> Iterator[Watched]:
    """A new browser window; what it complains of, and what it asks of others than this computer."""
    context = browser.new_context(viewport={"width": 1280, "height": 900})
    context.set_default_timeout(60_000)
    found = Watched(context.new_page())
    context.on("weberror", lambda error: found.errors.append(str(error.error)))
    context.on("console", lambda said: found.errors.append(said.text) if said.type == "error" else None)
    context.on("request", lambda request: found.requests.append(request.url))
    yield found
    context.close()


def assert_clean(watched: Watched, served: Served) -> None:
    """No complaint, and nothing asked of anybody else."""
    assert watched.errors == []
    assert [url for url in watched.requests if not url.startswith((f"{served.origin}/", "data:", "blob:"))] == []


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    found = Served.start(tmp_path_factory.mktemp("runs"))
    yield found
    found.stop()


def given(watched: Watched, files: dict[str, bytes | str]) -> None:
    """Choose files, as a drop does, and wait until the page has them."""
    payload = [
        {"name": name, "mimeType": "text/plain", "buffer": content if isinstance(content, bytes) else content.encode()}
        for name, content in files.items()
    ]
    with watched.page.expect_navigation(url="**/runs/*"):
        watched.page.set_input_files("[data-files]", payload)


def drawn(watched: Watched) -> None:
    """Wait for the robot in 3D."""
    watched.page.wait_for_selector("#preview.drawn canvas", timeout=60_000)


def calibrated(watched: Watched) -> None:
    """Press the button and wait for the result."""
    watched.page.click("text=Calibrate >> visible=true")
    watched.page.wait_for_selector(".outcome .headline", timeout=60_000)


def fits(watched: Watched, width: int) -> None:
    """Nothing is wider than the window."""
    watched.page.set_viewport_size({"width": width, "height": 900})
    watched.page.wait_for_function("width => document.documentElement.scrollWidth <= width", arg=width, timeout=20_000)


def downloaded(watched: Watched, name: str, folder: Path) -> Path:
    """A file of the result, as the browser saves it."""
    with watched.page.expect_download() as found:
        watched.page.click(f"a[download]:has-text('{name}')")
    found.value.save_as(folder / name)
    return folder / name


def test_the_example_goes_from_a_click_to_a_robot(served: Served, watched: Watched, tmp_path: Path):
    page = watched.page
    page.goto(served.origin)
    fits(watched, 400)
    fits(watched, 1280)
    page.click("text=Try the example")
    drawn(watched)
    assert page.input_value("select[name='law 2']") == "linear"
    assert page.input_value("select[name='law 1']") == "rigid"
    before = page.text_content("#preview .caption")
    page.focus("#preview input[type=range]")
    page.keyboard.press("End")
    page.wait_for_function("text => document.querySelector('#preview .caption').textContent !== text", arg=before)
    assert "fit.csv row 60" in page.text_content("#preview .caption")
    fits(watched, 400)
    fits(watched, 1280)
    calibrated(watched)
    fits(watched, 400)
    fits(watched, 1280)
    page.wait_for_selector(".report .figure .main-svg")
    robot = ec.load_robot(downloaded(watched, "robot.toml", tmp_path))
    assert robot.elastic["2.theta"].coefficients[0] == pytest.approx(2e-6, rel=0.1)
    assert json.loads(downloaded(watched, "result.json", tmp_path).read_text(encoding="utf-8"))["status"] == "converged"
    with page.context.expect_page() as opened:
        page.click("text=Report to print or send")
    opened.value.wait_for_selector("h1")
    assert "calibration report" in opened.value.title()
    assert_clean(watched, served)


@needs_ur10
def test_the_ur10_goes_from_upload_to_a_robot(served: Served, watched: Watched, tmp_path: Path):
    page = watched.page
    page.goto(served.origin)
    names = ("robot.toml", "series_b.toml", "series_b.csv", "series_c.toml", "series_c.csv")
    given(watched, {name: (UR10 / name).read_bytes() for name in names})
    drawn(watched)
    assert "of 4268" in page.text_content("#preview output")
    page.fill("input[name=holdout]", "70")
    page.press("input[name=holdout]", "Tab")
    page.wait_for_selector(".command:has-text('--holdout 0.7 --elastic 2,3,4,5')")
    calibrated(watched)
    result = json.loads(downloaded(watched, "result.json", tmp_path).read_text(encoding="utf-8"))
    assert 1e3 * result["residuals"]["held_out"]["mean"] == pytest.approx(0.4207, abs=1e-3)
    assert ec.load_robot(downloaded(watched, "robot.toml", tmp_path)).name == "UR10"
    assert_clean(watched, served)


def test_faults_are_shown_and_go_away_with_the_corrected_file(served: Served, watched: Watched):
    page = watched.page
    page.goto(served.origin)
    given(watched, {"robot.toml": ROBOT, "fit.csv": edited(TABLE, ("100,200,300", "abc,200,300"))})
    assert "row 1, column 'x [mm]'" in page.text_content(".faults")
    assert page.query_selector("text=Calibrate >> visible=true") is None
    fits(watched, 400)
    given(watched, {"fit.csv": TABLE})
    page.wait_for_selector(".files .told:has-text('3 rows of position')")
    assert page.query_selector(".files .faults") is None
    assert_clean(watched, served)


def test_a_file_over_the_limit_is_refused_before_it_is_sent(served: Served, watched: Watched):
    page = watched.page
    page.goto(served.origin)
    page.evaluate(
        """() => {
          const big = new File([""], "big.csv");
          Object.defineProperty(big, "size", { value: 2 ** 30 });
          take(document.querySelector("[data-drop]"), [big]);
        }"""
    )
    page.wait_for_selector(".failed:has-text('big.csv: 1024 MB; a file may have 200 MB at most')")
    assert_clean(watched, served)


def test_a_run_is_stopped_half_way_and_another_survives_a_power_cut(watched: Watched, tmp_path: Path):
    files = simulated_files(tmp_path / "files")
    served = Served.start(tmp_path / "runs")
    page = watched.page
    try:
        page.goto(served.origin)
        given(watched, files)
        page.select_option("select[name='law 2']", "step")
        page.select_option("select[name=transition]", "ga")
        page.fill("input[name=population]", "4")
        page.fill("input[name=generations]", "100000")
        page.click("text=Calibrate >> visible=true")
        page.wait_for_selector("#progress b:has-text('of 100000')", timeout=60_000)
        seen = page.text_content("#progress b")
        page.wait_for_function("text => document.querySelector('#progress b').textContent !== text", arg=seen)
        page.click("text=Stop")
        page.wait_for_selector(".panel.stopped")
        page.click("text=Calibrate >> visible=true")
        page.wait_for_selector("#progress b:has-text('of 100000')", timeout=60_000)
        workers = _children(served.process.pid)
        served.kill()
        wait_for(lambda: not any(map(alive, workers)))
        served = Served.start(tmp_path / "runs")
        page.goto(served.origin)
        assert "Interrupted" in page.text_content(".card")
        page.click(".card a")
        page.select_option("select[name='law 2']", "linear")
        calibrated(watched)
    finally:
        served.stop()


def _children(pid: int) -> list[int]:
    """The processes that a process has started."""
    found = Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="ascii").split()
    tasks = [path.read_text(encoding="ascii").split() for path in Path(f"/proc/{pid}/task").glob("*/children")]
    return sorted({int(child) for child in (*found, *(c for task in tasks for c in task))})


def test_ctrl_c_ends_the_page_and_its_runs(tmp_path: Path):
    served = Served.start(tmp_path / "runs")
    os.kill(served.process.pid, signal.SIGINT)
    assert served.process.wait(60) == 0
