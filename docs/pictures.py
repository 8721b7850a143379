"""Make the pictures of the documents anew, from the reports that their examples write: `python docs/pictures.py`.

It follows the pages as a reader would, in a temporary folder, and takes pictures of sections of report.html with
Chromium. Those of the UR10 need its data (tests/support/data.py says where) and are left alone without.
"""

from __future__ import annotations

import base64
import shutil
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

DOCS = Path(__file__).parent
sys.path.insert(0, str(DOCS.parent / "tests"))

WIDTH, SCALE, QUALITY = 1180, 1.5, 80
"""Of the window [px]; picture elements per pixel; of WebP, of 100."""

MARGIN = 14


@dataclass(frozen=True)
class Picture:
    """What is shown of a report: a section from its title to the end, or some of its figures.

    Attributes:
        name: of the file, without the theme.
        report: in the folder of the page.
        section: its anchor.
        figures: first and last, from 0; None: all of the section.
    """

    name: str
    report: str
    section: str
    figures: tuple[int, int] | None = None


PICTURES = {
    "tour.md": (
        Picture("tour-left", "linear", "what-is-not-yet-modelled"),
        Picture("report-vectors", "hinge", "error-vectors"),
        Picture("report-verdict", "hinge", "verdict"),
        Picture("report-errors", "hinge", "errors-before-and-after"),
        Picture("report-torque", "linear", "residual-against-joint-torque", (0, 1)),
        Picture("report-law", "hinge", "torque-and-deflection", (0, 1)),
        Picture("report-search", "hinge", "search-for-transition-torques"),
        Picture("report-accuracy", "hinge", "accuracy-over-the-workspace"),
    ),
    "ur10.md": (
        Picture("ur10-waves", "elastic", "residual-against-joint-position", (0, 1)),
        Picture("ur10-maps", "maps", "joint-maps", (0, 1)),
    ),
}

PLACE = """([section, first, last]) => {
    const found = document.getElementById(section);
    const parts = first < 0 ? [found] : [...found.querySelectorAll("figure")].slice(first, last + 1);
    const boxes = parts.map(part => part.getBoundingClientRect());
    const [left, top] = ["left", "top"].map(side => Math.min(...boxes.map(box => box[side])));
    const [right, bottom] = ["right", "bottom"].map(side => Math.max(...boxes.map(box => box[side])));
    return {x: left + scrollX, y: top + scrollY, width: right - left, height: bottom - top};
}"""


def take(page: Page, picture: Picture, path: Path) -> None:
    """Write one picture of a report that is open."""
    first, last = picture.figures or (-1, -1)
    box = page.evaluate(PLACE, [picture.section, first, last])
    for down in range(0, int(box["height"]) + 400, 400):  # figures are drawn when they come into view
        page.evaluate("y => scrollTo(0, y)", box["y"] + down - 300)
        page.wait_for_timeout(500)
    box = page.evaluate(PLACE, [picture.section, first, last])
    clip = {"x": box["x"] - MARGIN, "y": box["y"] - MARGIN, "scale": 1}
    clip |= {"width": box["width"] + 2 * MARGIN, "height": box["height"] + 2 * MARGIN}
    asked = {"format": "webp", "quality": QUALITY, "captureBeyondViewport": True, "clip": clip}
    shot = page.context.new_cdp_session(page).send("Page.captureScreenshot", asked)
    path.write_bytes(base64.b64decode(shot["data"]))
    print(f"{path.name}: {path.stat().st_size / 1e3:.0f} kB")


def main() -> None:
    """Follow the pages and take all pictures, light and dark."""
    from support.data import UR10
    from support.pages import Reader

    images = DOCS / "images"
    images.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as name, sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox", "--enable-unsafe-swiftshader"]
        )
        for guide, pictures in PICTURES.items():
            folder = Path(name) / guide
            folder.mkdir()
            if guide == "ur10.md":
                if not UR10.is_dir():
                    print("without the UR10 data its pictures stay as they are")
                    continue
                for series in UR10.glob("series_?.csv"):
                    shutil.copy(series, folder)
            Reader(folder).follow(DOCS / guide)
            for theme in ("light", "dark"):
                size = {"width": WIDTH, "height": 900}
                page = browser.new_page(viewport=size, device_scale_factor=SCALE, color_scheme=theme)
                for picture in pictures:
                    page.goto((folder / picture.report / "report.html").as_uri())
                    take(page, picture, images / f"{picture.name}-{theme}.webp")
                page.close()
        browser.close()


if __name__ == "__main__":
    main()
