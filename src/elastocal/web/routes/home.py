"""All runs, and new ones."""

from __future__ import annotations

from fastapi import APIRouter, HTTPException, Request
from starlette.responses import Response

from elastocal.web.pages import card, page
from elastocal.web.routes.common import AllRuns, AtWork, OneRun, see
from elastocal.web.settings import Settings

router = APIRouter()


@router.get("/")
def all_runs(runs: AllRuns, workers: AtWork) -> Response:
    """The list of runs."""
    return page("home.html", cards=[card(run, workers) for run in runs.all()], folder=runs.folder)


@router.post("/runs")
def new_run(request: Request, runs: AllRuns) -> Response:
    """An empty run."""
    address = f"/runs/{runs.create().id}"
    if "text/html" in request.headers.get("accept", ""):
        return see(address)
    return Response(address, 201, {"location": address}, "text/plain")


@router.post("/runs/example")
def example(runs: AllRuns) -> Response:
    """A run of the built-in example, ready to start."""
    from elastocal.examples import ROBOT_FILE, actual_arm, measure
    from elastocal.io import load_robot, measurements_to_csv, write_files

    nominal = load_robot(ROBOT_FILE)
    actual = actual_arm(nominal)
    files = {
        "robot.toml": ROBOT_FILE.read_bytes(),
        "fit.csv": measurements_to_csv(measure(actual, 60, 1), nominal),
        "held_out.csv": measurements_to_csv(measure(actual, 200, 2), nominal),
    }
    run = runs.create(Settings(name="Example arm"))
    write_files(run.inputs, files)
    return see(f"/runs/{run.id}")


@router.post("/runs/{run_id}/copy")
def copy(run: OneRun, runs: AllRuns) -> Response:
    """A new run with the same files and settings."""
    return see(f"/runs/{runs.copy(run).id}")


@router.post("/runs/{run_id}/delete")
def delete(run: OneRun, runs: AllRuns, workers: AtWork) -> Response:
    """Remove a run."""
    if workers.at_work(run):
        raise HTTPException(409, "This run is at work: stop it first.")
    runs.delete(run)
    return see("/")
