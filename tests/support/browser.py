"""A browser for tests: Debian's Chromium, without a network. Where it is missing tests are skipped, but never in CI."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

CHROMIUM = os.environ.get("ELASTOCAL_CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")

OPTIONS = [
    "--no-sandbox",
    "--disable-gpu",
    "--use-angle=swiftshader",  # 3D without a graphics card
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-dev-shm-usage",
]


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Chromium, headless."""
    if CHROMIUM is None:
        if os.environ.get("CI"):
            pytest.fail("there is no Chromium, which CI must have: apt-get install chromium")
        pytest.skip("there is no Chromium: apt-get install chromium, or set ELASTOCAL_CHROMIUM")
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        found = playwright.chromium.launch(executable_path=CHROMIUM, args=OPTIONS)
        yield found
        found.close()


@dataclass(frozen=True)
class Watched:
    """A page, what it asked of a network, and what it complained of."""

    page: Page
    requests: list[str] = field(default_factory=list)
    errors: list[str] = field(default_factory=list)


@contextmanager
def opened(browser: Browser, path: Path, width: int = 1280, theme: str = "light") -> Iterator[Watched]:
    """A file in a page of its own, whose requests other than for the file itself are refused and noted."""
    context = browser.new_context(viewport={"width": width, "height": 900}, color_scheme=theme)
    page = context.new_page()
    page.set_default_timeout(60_000)
    watched, home = Watched(page), path.resolve().as_uri()

    def answer(route):
        if route.request.url.partition("#")[0] == home:
            return route.continue_()
        watched.requests.append(route.request.url)
        return route.abort()

    page.route("**/*", answer)
    page.on("pageerror", lambda error: watched.errors.append(str(error)))
    page.on("console", lambda said: watched.errors.append(said.text) if said.type == "error" else None)
    page.goto(home)
    yield watched
    context.close()


def draw_all(page: Page) -> int:
    """Draw all figures of a report; how many there are."""
    page.evaluate("elastocalReport.drawAll()")
    return page.locator(".figure.js-plotly-plot").count()
