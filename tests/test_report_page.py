"""The report in a browser: it draws all figures, asks nothing of a network, and keeps hostile names as names."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from elastocal.figures.panel import Panel, points
from elastocal.report.html import page_html
from elastocal.report.section import Section, Verdict
from support.browser import Watched, draw_all, opened
from support.files import Desk, save_simulated

HOSTILE = "<script>window.harmed=1</script><img src=x onerror='window.harmed=1'>&\"'"


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The report on an arm whose name is hostile, with a step and joint maps."""
    desk = Desk(tmp_path_factory.mktemp("report"))
    save_simulated(desk.folder, fit=70)
    robot = desk.folder / "robot.toml"
    escaped = HOSTILE.replace("\\", "\\\\").replace('"', '\\"')
    robot.write_text(robot.read_text().replace('name = "arm"', f'name = "{escaped}"'))
    desk.done("calibrate robot.toml fit.csv --held-out held_out.csv --elastic 2:step,3 --transmission 2 -o result")
    return desk.folder / "result" / "report.html"


@pytest.fixture(scope="module", params=[("light", 1280), ("dark", 400)], ids=["light", "dark and narrow"])
def watched(browser, report: Path, request: pytest.FixtureRequest) -> Iterator[Watched]:
    """The report with all its figures drawn."""
    theme, width = request.param
    with opened(browser, report, width, theme) as found:
        draw_all(found.page)
        yield found


def test_it_draws_all_figures_without_errors_or_requests(watched: Watched):
    page = watched.page
    figures = page.locator(".figure").count()
    assert figures > 20
    assert draw_all(page) == figures
    theme = page.evaluate("document.documentElement.dataset.theme")
    assert theme == ("dark" if page.evaluate("matchMedia('(prefers-color-scheme: dark)').matches") else "light")
    is_dark = page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(20, 24, 29)"
    assert is_dark == (theme == "dark")
    assert page.locator(".gl-container canvas").count() > 0
    assert watched.requests == []
    assert watched.errors == []


def test_a_hostile_name_is_a_name(watched: Watched):
    assert watched.page.evaluate("window.harmed") is None
    assert HOSTILE in watched.page.inner_text("h1")


def test_the_page_is_not_wider_than_its_window(watched: Watched):
    page = watched.page
    assert page.evaluate("document.documentElement.scrollWidth") <= page.viewport_size["width"]


def test_tables_are_sorted_by_number_and_by_word(watched: Watched):
    table = watched.page.locator("#identified-parameters table")
    heads = [head.rstrip("↕↑↓") for head in table.locator("thead th").all_inner_texts()]

    def column(name: str) -> list[str]:
        return table.locator(f"tbody tr > :nth-child({heads.index(name) + 1})").all_inner_texts()

    before = column("identified")
    table.locator("thead button", has_text="identified").first.click()
    rising = [float(text) for text in column("identified")]
    assert rising == sorted(map(float, before))
    table.locator("thead button", has_text="identified").first.click()
    assert [float(text) for text in column("identified")] == rising[::-1]
    assert table.locator("th[aria-sort=descending]").count() == 1
    table.locator("thead button", has_text="parameter").click()
    assert column("parameter")[0].startswith("2.")


def test_the_switch_changes_page_and_figures_and_keeps_what_is_shown(watched: Watched):
    page = watched.page
    scene = page.locator("#error-vectors .figure")
    scene.scroll_into_view_if_needed()
    at = f"document.getElementById('{scene.get_attribute('id')}')"
    page.evaluate(f"Plotly.restyle({at}, {{visible: false}}, [0])")
    ink = f"{at}.layout.template.layout.font.color"
    before, theme = page.evaluate(ink), page.evaluate("document.documentElement.dataset.theme")
    page.evaluate("document.getElementById('theme').click()")  # a click of the mouse would scroll to it
    assert page.evaluate("document.documentElement.dataset.theme") != theme
    page.wait_for_function(f"{ink} !== '{before}'")
    assert page.evaluate(f"{at}.data[0].visible") is False
    page.evaluate("document.getElementById('theme').click()")
    page.wait_for_function(f"{ink} === '{before}'")
    assert watched.errors == []


def test_any_sections_make_a_page_and_all_text_is_text(browser, tmp_path: Path):
    panel = Panel(HOSTILE, [points([1.0, 2.0], [3.0, 4.0], HOSTILE, "#0072b2")], {"xaxis": {"title": {"text": "x"}}})
    section = Section(
        HOSTILE,
        (HOSTILE, "verdict"),
        ((HOSTILE, "identified"),),
        (HOSTILE,),
        prose=HOSTILE,
        verdict=Verdict("problem", HOSTILE),
        facts=((HOSTILE, HOSTILE),),
        panels=(panel,),
        code=HOSTILE,
        sortable=True,
    )
    path = tmp_path / "page.html"
    path.write_text(page_html(HOSTILE, [section, section], HOSTILE), encoding="utf-8")
    with opened(browser, path) as watched:
        draw_all(watched.page)
        assert watched.page.evaluate("window.harmed") is None
        assert watched.page.inner_text("h2") == HOSTILE
        assert watched.page.locator("main section").count() == 2
        assert watched.page.locator("script").count() == 5  # plotly, settings, two panels, the page's own
    assert watched.requests == []


def test_without_figures_there_is_no_plotly():
    page = page_html("few words", [Section("Words", sentences=("One.",))])
    assert len(page) < 40_000
    assert "<p>One.</p>" in page


def test_the_page_says_what_every_part_is(report: Path):
    page = report.read_text(encoding="utf-8")
    head = page[: page.index("<script>")]
    ids = re.findall(r'<section id="([^"]+)"', head)
    assert len(ids) == len(set(ids)) > 12
    assert re.findall(r'<li><a href="#([^"]+)">', head) == ids
    assert head.count("<figure") == head.count("<figcaption") == head.count('role="img"')
    assert "default-src 'none'" in head
    assert "<th>" not in head  # every one has a scope
