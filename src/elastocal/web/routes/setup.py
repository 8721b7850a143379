"""One run: before, while and after it is at work; its settings, and its start."""

from __future__ import annotations

from dataclasses import replace

from fastapi import APIRouter, HTTPException
from starlette.responses import JSONResponse, Response

from elastocal.errors import InputError
from elastocal.web.inputs import ROLE_WORDS, ROLES, Inputs, inspect
from elastocal.web.pages import card, page
from elastocal.web.plan import Plan, plan, resolved
from elastocal.web.preview import preview
from elastocal.web.routes.common import AtWork, EditableRun, Form, OneRun, see
from elastocal.web.routes.results import result_page
from elastocal.web.routes.running import progress_page
from elastocal.web.runs import Run, State
from elastocal.web.settings import GROUPS, LAWS, LOSSES, Settings, settings_of_form
from elastocal.web.worker import Workers

router = APIRouter()


@router.get("/runs/{run_id}")
def one_run(run: OneRun, workers: AtWork) -> Response:
    """The page of a run, after its state."""
    state = run.state(workers.at_work(run))
    if state == State.RUNNING:
        return progress_page(run, workers)
    if state in (State.DONE, State.FAILED) and run.summary:
        return result_page(run, workers)
    return setup_page(run, workers)


def setup_page(run: Run, workers: Workers, faults: tuple[str, ...] = (), status: int = 200) -> Response:
    """Files, preview and settings."""
    inputs = inspect(run, run.settings)
    settings = resolved(run.settings, inputs)
    return page(
        "setup.html",
        status,
        card=card(run, workers),
        inputs=inputs,
        settings=settings,
        planned=_planned(settings, inputs, faults),
        roles=ROLES,
        role_words=ROLE_WORDS,
        groups=GROUPS,
        laws=LAWS,
        losses=LOSSES,
        log=run.log,
    )


def _planned(settings: Settings, inputs: Inputs, faults: tuple[str, ...] = ()) -> Plan | None:
    """What a run would do; None where the files do not allow one."""
    if faults:
        return Plan(faults)
    return plan(settings, inputs) if inputs.sound else None


@router.post("/runs/{run_id}/settings")
def save_settings(run: EditableRun, form: Form) -> Response:
    """Keep what the form says, and answer what a run would do."""
    inputs = inspect(run, run.settings)
    try:
        settings = settings_of_form(run.settings, form)
    except InputError as error:
        return page("_plan.html", run=run, inputs=inputs, planned=Plan(error.faults))
    run.save_settings(settings)
    return page("_plan.html", run=run, inputs=inputs, planned=_planned(resolved(settings, inputs), inputs))


@router.post("/runs/{run_id}/start")
def start(run: EditableRun, form: Form, workers: AtWork) -> Response:
    """Start a run with what the form says; without a form, with what it said before."""
    inputs = inspect(run, run.settings)
    if not inputs.sound:
        raise HTTPException(409, "A run needs a robot file and measurements without faults.")
    try:
        settings = settings_of_form(run.settings, form) if form else run.settings
    except InputError as error:
        return setup_page(run, workers, error.faults, 422)
    settings = resolved(settings, inputs)
    planned = plan(settings, inputs)
    run.save_settings(replace(settings, name=settings.name or (inputs.robot.name if inputs.robot else "")))
    if planned.arguments is None:
        return setup_page(run, workers, planned.faults, 422)
    workers.start(run, planned.arguments)
    return see(f"/runs/{run.id}")


@router.get("/runs/{run_id}/preview.json")
def preview_data(run: OneRun) -> Response:
    """The robot at each measured pose."""
    inputs = inspect(run, run.settings)
    study = inputs.study
    if inputs.robot is None or inputs.fit is None or study is None:
        raise HTTPException(404, "There is nothing to show without a robot and measurements.")
    if study.aligned is None:
        return JSONResponse(preview(inputs.robot, inputs.fit, None) | {"aligned": False})
    return JSONResponse(preview(study.aligned, inputs.fit, study.errors) | {"aligned": True})
