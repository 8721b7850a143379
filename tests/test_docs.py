"""Every example of the documents, run page by page as a reader would; and what the pages show and list."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

import elastocal as ec
from support.data import UR10, needs_ur10
from support.pages import Reader, assert_shown, blocks

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
IMAGES = DOCS / "images"
PAGES = sorted(DOCS.glob("*.md"))

REFERENCE = ("architecture", "benchmarks", "cluster", "controllers", "conventions", "studies")
"""Pages of formulas and formats; what stands on them is a pattern, not an example."""

GUIDES = [page for page in PAGES if page.stem not in REFERENCE]

LARGEST_IMAGE = 150_000


def prepared(page: Path, folder: Path) -> None:
    """What a reader of the page is said to have already."""
    if page.name == "ur10.md":
        for name in ("series_b.csv", "series_c.csv"):
            shutil.copy(UR10 / name, folder)
    if page.name == "README.md":
        Reader(folder).command("elastocal demo -o demo", "…")
        shutil.copy(folder / "demo" / "robot.toml", folder)
        shutil.copy(folder / "demo" / "fit.csv", folder / "measurements.csv")


@pytest.mark.parametrize(
    "page",
    [pytest.param(p, id=p.stem, marks=needs_ur10 if p.stem == "ur10" else ()) for p in (*GUIDES, ROOT / "README.md")],
)
def test_the_examples_do_what_the_page_shows(page: Path, tmp_path: Path):
    prepared(page, tmp_path)
    Reader(tmp_path).follow(page)


@pytest.mark.parametrize("page", GUIDES, ids=lambda page: page.stem)
def test_every_block_says_its_language(page: Path):
    assert [block.line for block in blocks(page) if not block.info] == []


@pytest.mark.parametrize(
    ("found", "shown"),
    [
        ("a\nb\n", "a\nb"),
        ("a\n1.234 mm\nc\n", "…\n1.235 mm\n…"),
        ("a\nb\nc\nd\n", "a\n…\nd"),
        ("a\nb\n", "…"),
        ("anything\n", ""),
    ],
)
def test_output_that_agrees_is_accepted(found: str, shown: str):
    assert_shown(found, shown)


@pytest.mark.parametrize(
    ("found", "shown"),
    [
        ("a\nb\n", "a"),
        ("a\nb\n", "b"),
        ("1.234 mm\n", "1.236 mm"),
        ("1.234 mm\n", "1.2 mm"),
        ("b\na\n", "…\na\n…\nb\n…"),
        ("a\nb\n", "a\n…\na"),
        ("", "a"),
    ],
)
def test_output_that_differs_is_refused(found: str, shown: str):
    with pytest.raises(AssertionError):
        assert_shown(found, shown)


def test_a_command_that_fails_must_be_said_to_fail(tmp_path: Path):
    page = tmp_path / "page.md"
    page.write_text("```console\n$ elastocal validate robot.toml\n```\n")
    with pytest.raises(AssertionError, match="ended with 2"):
        Reader(tmp_path).follow(page)
    page.write_text("```console\n$ elastocal validate robot.toml\n$ echo $?\n2\n```\n")
    Reader(tmp_path).follow(page)


def test_the_reference_lists_the_public_names():
    listed = re.findall(r"^::: elastocal\.(\w+)$", (DOCS / "api.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert sorted(listed) == sorted([*ec.__all__, "figures"])


def test_pictures_are_small_and_all_are_shown():
    shown = {name for page in PAGES for name in re.findall(r"images/([\w.-]+)", page.read_text(encoding="utf-8"))}
    there = {path.name for path in IMAGES.iterdir()}
    assert shown == there
    assert [path.name for path in IMAGES.iterdir() if path.stat().st_size >= LARGEST_IMAGE] == []
