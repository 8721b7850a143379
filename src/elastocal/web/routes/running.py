"""A run at work: its progress, and its stop."""

from __future__ import annotations

from datetime import datetime
from typing import Any

from fastapi import APIRouter
from starlette.responses import Response

from elastocal.web.pages import card, page
from elastocal.web.routes.common import AtWork, OneRun, see
from elastocal.web.runs import Run
from elastocal.web.worker import Workers

router = APIRouter()

WIDTH, HEIGHT = 600, 80
"""Of the curve of the misfit, in its own units."""


def progress_page(run: Run, workers: Workers) -> Response:
    """The page of a run at work."""
    return page("running.html", **_progress(run, workers))


@router.get("/runs/{run_id}/progress")
def progress(run: OneRun, workers: AtWork) -> Response:
    """How far a run is; once it is at its end, the page is to be loaded anew."""
    if not workers.at_work(run):
        return Response("", headers={"hx-refresh": "true"})
    return page("_progress.html", **_progress(run, workers))


def _progress(run: Run, workers: Workers) -> dict[str, Any]:
    found, record = workers.progress(run), run.record
    began = datetime.fromisoformat(record.started) if record else datetime.now()
    return {
        "card": card(run, workers),
        "progress": found,
        "curve": curve(found.trace),
        "elapsed": int((datetime.now() - began).total_seconds()),
        "command": record.command.replace("-o ../result", "-o result") if record else "",
        "log": run.log,
    }


def curve(values: tuple[float, ...]) -> str:
    """Values as the points of an SVG polyline, the largest on top; "" of fewer than two."""
    if len(values) < 2:
        return ""
    low, high = min(values), max(values)
    reach = (high - low) or 1.0
    return " ".join(
        f"{WIDTH * i / (len(values) - 1):.1f},{4 + (HEIGHT - 8) * (high - value) / reach:.1f}"
        for i, value in enumerate(values)
    )


@router.post("/runs/{run_id}/stop")
def stop(run: OneRun, workers: AtWork) -> Response:
    """End a run."""
    workers.stop(run)
    return see(f"/runs/{run.id}")
