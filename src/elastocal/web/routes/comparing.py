"""Several runs side by side."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Query
from starlette.responses import Response

from elastocal.report.html import figure_settings, sections_html
from elastocal.web.pages import card, page
from elastocal.web.result_sections import compared
from elastocal.web.routes.common import AllRuns, AtWork

router = APIRouter()

MOST = 12
"""Runs side by side, at most."""


@router.get("/compare")
def compare(runs: AllRuns, workers: AtWork, run: Annotated[list[str] | None, Query()] = None) -> Response:
    """The runs named in the address side by side."""
    found = [one for one in map(runs.get, (run or [])[:MOST]) if one and one.summary]
    cards = [card(one, workers) for one in found]
    sections = compared(found, [f"{i} {one.title}" for i, one in enumerate(cards, start=1)])
    return page("compare.html", cards=cards, report=sections_html(sections), figures=figure_settings())
