"""A run's result: its page, its report, its files."""

from __future__ import annotations

import zipfile
from io import BytesIO

from fastapi import APIRouter, HTTPException
from starlette.responses import FileResponse, Response

from elastocal.report.html import figure_settings
from elastocal.web.pages import card, page
from elastocal.web.result_sections import report_of
from elastocal.web.routes.common import OneRun
from elastocal.web.runs import DOWNLOADS, Run
from elastocal.web.security import REPORT_POLICY
from elastocal.web.worker import Workers

router = APIRouter()


def result_page(run: Run, workers: Workers) -> Response:
    """The page of a run that has a result."""
    return page(
        "result.html",
        card=card(run, workers),
        report=report_of(run),
        figures=figure_settings(),
        downloads=run.downloads(),
        log=run.log,
    )


@router.get("/runs/{run_id}/report")
def report(run: OneRun) -> Response:
    """The report, by itself."""
    path = run.result / "report.html"
    if not path.is_file():
        raise HTTPException(404, "This run has no report.")
    return FileResponse(path, media_type="text/html", headers={"content-security-policy": REPORT_POLICY})


@router.get("/runs/{run_id}/download/{name}")
def download(run: OneRun, name: str) -> Response:
    """One file of the result, or all of them as a ZIP archive."""
    if name == "result.zip":
        return _all_files(run)
    if name not in DOWNLOADS or not (run.result / name).is_file():
        raise HTTPException(404, f"This run has no {name}." if name in DOWNLOADS else "There is no such file.")
    return FileResponse(run.result / name, media_type="application/octet-stream", filename=name)


def _all_files(run: Run) -> Response:
    content = BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in run.downloads():
            archive.write(run.result / name, name)
    headers = {"content-disposition": 'attachment; filename="result.zip"'}
    return Response(content.getvalue(), media_type="application/zip", headers=headers)
