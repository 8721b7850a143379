"""The page's application, put together."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

from fastapi import FastAPI
from fastapi.staticfiles import StaticFiles
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import Response

from elastocal.errors import ElastocalError
from elastocal.report.html import asset, plotly_script
from elastocal.web.pages import error_page
from elastocal.web.routes import comparing, files, home, results, running, setup
from elastocal.web.runs import Runs
from elastocal.web.security import Guard
from elastocal.web.worker import Workers

STATIC = Path(__file__).with_name("static")


def create_app(folder: str | Path) -> FastAPI:
    """The page on a folder of runs, which is made if it is not there.

    Raises:
        OSError: the folder cannot be made.
    """
    folder = Path(folder).resolve()
    folder.mkdir(parents=True, exist_ok=True)

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        yield
        app.state.workers.close()

    # the documentation pages of FastAPI would load scripts from elsewhere
    app = FastAPI(title="elastocal", docs_url=None, redoc_url=None, openapi_url=None, lifespan=lifespan)
    app.state.runs, app.state.workers = Runs(folder), Workers()
    app.add_middleware(Guard)
    for part in (home, setup, files, running, results, comparing):
        app.include_router(part.router)
    app.add_api_route("/plotly.min.js", _plotly, methods=["GET"])
    app.add_api_route("/report.js", _report_script, methods=["GET"])
    app.mount("/static", StaticFiles(directory=STATIC), name="static")
    app.add_exception_handler(HTTPException, _told)
    app.add_exception_handler(ElastocalError, _told)
    return app


def _plotly() -> Response:
    """The script that draws, as the report has it."""
    return _script(plotly_script())


def _report_script() -> Response:
    """The script of the report's figures and tables."""
    return _script(asset("report.js"))


def _script(text: str) -> Response:
    return Response(text, media_type="text/javascript", headers={"cache-control": "private, max-age=3600"})


def _told(request: Request, error: Exception) -> Response:
    """An error as a page, or as a line for a script."""
    status = error.status_code if isinstance(error, HTTPException) else 422
    message = str(error.detail) if isinstance(error, HTTPException) else str(error)
    if "text/html" in request.headers.get("accept", ""):
        return error_page(status, message)
    return Response(message, status, media_type="text/plain; charset=utf-8")
