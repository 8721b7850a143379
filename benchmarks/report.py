"""Size of the report on the UR10's 4,268 poses, and its seconds: `python benchmarks/report.py`, on an idle machine.

Bars: 8 MB, 3 s. Where the data are not there, as many poses of the built-in arm are simulated. With Chromium, how long
frames take in a window of 1280 x 900, all figures drawn, while the page is scrolled and the 3D figure turned: here the
processor draws its 3D, which a graphics card does many times faster. The last result is in report.txt.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from elastocal.examples import ROBOT_FILE, actual_arm, measure
from elastocal.identification import CalibrationResult, calibrate
from elastocal.io import as_saved, load_measurements, load_robot
from elastocal.report.documents import calibration_report
from support.browser import CHROMIUM, OPTIONS, draw_all

UR10 = Path(os.environ.get("ELASTOCAL_UR10", Path(__file__).parents[2] / "shared" / "data" / "ur10"))

MOST_MEGABYTES, MOST_SECONDS = 8.0, 3.0

RUNS = 3


def results() -> dict[str, CalibrationResult]:
    """Calibrations of few and of many poses, without and with joint maps."""
    arm = load_robot(ROBOT_FILE)
    actual = actual_arm(arm)
    found = {"arm, 60 poses": calibrate(arm, measure(actual, 60), elastic={"2": "step", "3": "linear"})}
    robot, data = arm, None
    if (UR10 / "robot.toml").is_file():
        robot = load_robot(UR10 / "robot.toml")
        data = load_measurements([UR10 / "series_b.toml", UR10 / "series_c.toml"], robot)
    name, data = ("UR10" if data is not None else "arm"), data if data is not None else measure(actual, 4268)
    elastic = dict.fromkeys("23", "linear")
    found[f"{name}, {len(data)} poses"] = calibrate(robot, data, elastic=elastic, holdout=0.7)
    found[f"{name}, {len(data)} poses, maps of 60 orders"] = calibrate(
        robot, data, elastic=elastic, holdout=0.3, transmission=60
    )
    return found


RECORD = """() => { window.frames_ = []; let last = performance.now(); window.on_ = true;
  const next = now => { frames_.push(now - last); last = now; if (on_) requestAnimationFrame(next) };
  requestAnimationFrame(next) }"""
"""Notes the milliseconds between frames."""


def frames(page: str) -> dict[str, tuple[float, float]]:
    """Median and 95 % quantile of milliseconds between frames, while a page is scrolled and its 3D figure turned."""
    from playwright.sync_api import sync_playwright

    found = {}
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        path = Path(folder) / "report.html"
        path.write_text(page)
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=OPTIONS)
        window = browser.new_page(viewport={"width": 1280, "height": 900})
        window.goto(path.as_uri())
        draw_all(window)
        window.wait_for_timeout(5000)
        scene = window.locator(".figure.js-plotly-plot:has(.gl-container canvas)").first
        box = scene.bounding_box() or {"x": 0.0, "y": 0.0, "width": 1280.0, "height": 900.0}
        x, y = box["x"] + box["width"] / 2.0, 450.0

        def scroll() -> None:
            window.mouse.move(640.0, 450.0)
            for _ in range(100):
                window.mouse.wheel(0.0, 150.0)
                window.wait_for_timeout(16)

        def turn() -> None:
            scene.scroll_into_view_if_needed()
            window.mouse.move(x, y)
            window.mouse.down()
            for step in range(60):
                window.mouse.move(x + 4.0 * step, y + step)
                window.wait_for_timeout(16)
            window.mouse.up()

        for name, act in (("scrolled", scroll), ("turned", turn)):
            window.evaluate(RECORD)
            act()
            times = np.array(window.evaluate("() => { window.on_ = false; return frames_ }"))
            found[name] = float(np.median(times)), float(np.quantile(times, 0.95))
        browser.close()
    return found


def main() -> int:
    """Print the fastest of several runs; exit status 1 if a bar is missed."""
    table = Table("report", "saved and read, s", "written, s", "size, MB", "scrolled, ms", "turned, ms")
    missed = False
    for name, result in results().items():
        saving, writing, size = [], [], 0.0
        for _ in range(RUNS):
            began = time.perf_counter()
            saved = as_saved(result)
            saving.append(time.perf_counter() - began)
            began = time.perf_counter()
            page = calibration_report(saved)
            writing.append(time.perf_counter() - began)
            size = len(page.encode()) / 1e6
        moved = [f"{median:.0f}, {most:.0f}" for median, most in frames(page).values()] if CHROMIUM else ["", ""]
        table.add_row(name, f"{min(saving):.2f}", f"{min(writing):.2f}", f"{size:.2f}", *moved)
        missed = missed or size > MOST_MEGABYTES or min(saving) + min(writing) > MOST_SECONDS
    Console(width=110).print(table, "Frames: median and 95 % quantile of the milliseconds between them.")
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
