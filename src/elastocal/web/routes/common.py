"""What all routes need: the run of an address, the form of a request."""

from __future__ import annotations

from typing import Annotated
from urllib.parse import parse_qs

from fastapi import Depends, HTTPException, Request
from starlette.responses import RedirectResponse

from elastocal.web.runs import Run, Runs, State
from elastocal.web.worker import Workers

EDITABLE = (State.DRAFT, State.REFUSED, State.STOPPED, State.INTERRUPTED, State.CRASHED)
"""States without a result: files and settings may be changed."""


def runs_of(request: Request) -> Runs:
    """All runs."""
    found: Runs = request.app.state.runs
    return found


def workers_of(request: Request) -> Workers:
    """The runs at work."""
    found: Workers = request.app.state.workers
    return found


def run_of(run_id: str, request: Request) -> Run:
    """The run of an address."""
    found = runs_of(request).get(run_id)
    if found is None:
        raise HTTPException(404, "There is no such run: it may have been deleted.")
    return found


def editable_run(run_id: str, request: Request) -> Run:
    """The run of an address, if its files and settings may be changed."""
    run = run_of(run_id, request)
    if run.state(workers_of(request).at_work(run)) not in EDITABLE:
        raise HTTPException(409, "This run is at work or has a result: copy it to change something.")
    return run


async def form_of(request: Request) -> dict[str, list[str]]:
    """A form's fields, each with its values."""
    return parse_qs((await request.body()).decode(errors="replace"), keep_blank_values=True, max_num_fields=2000)


def see(address: str) -> RedirectResponse:
    """To another page, after something was done."""
    return RedirectResponse(address, 303)


AllRuns = Annotated[Runs, Depends(runs_of)]
AtWork = Annotated[Workers, Depends(workers_of)]
OneRun = Annotated[Run, Depends(run_of)]
EditableRun = Annotated[Run, Depends(editable_run)]
Form = Annotated[dict[str, list[str]], Depends(form_of)]
