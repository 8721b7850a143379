"""Files in, their roles, files out."""

from __future__ import annotations

from dataclasses import replace

from fastapi import APIRouter, HTTPException, Request
from starlette.responses import Response

from elastocal.errors import InputError
from elastocal.web.inputs import ROLE_WORDS
from elastocal.web.routes.common import EditableRun, Form, see
from elastocal.web.uploads import safe_name, save_upload

router = APIRouter()


@router.put("/runs/{run_id}/files/{name}")
async def upload(run: EditableRun, name: str, request: Request) -> Response:
    """Take one file, as the request's body."""
    saved = await save_upload(run.inputs, name, request.stream())
    return Response(saved, 201, media_type="text/plain; charset=utf-8")


@router.post("/runs/{run_id}/remove")
def remove(run: EditableRun, form: Form) -> Response:
    """Remove one file."""
    try:
        name = safe_name((form.get("file") or [""])[0])
    except InputError as error:
        raise HTTPException(404, str(error)) from None
    if name not in [path.name for path in run.files()]:
        raise HTTPException(404, f"There is no file {name} in this run.")
    (run.inputs / name).unlink()
    return see(f"/runs/{run.id}")


@router.post("/runs/{run_id}/roles")
def roles(run: EditableRun, form: Form) -> Response:
    """What files are for, and where the chain of a URDF ends."""
    settings, there = run.settings, [path.name for path in run.files()]
    chosen = {
        name.removeprefix("role "): values[0]
        for name, values in form.items()
        if name.startswith("role ") and values[0] in ROLE_WORDS and name.removeprefix("role ") in there
    }
    tip = (form.get("tip") or [settings.tip])[0].strip()
    changed = {name: role for name, role in {**settings.roles, **chosen}.items() if name in there}
    run.save_settings(replace(settings, roles=changed, tip=tip))
    return see(f"/runs/{run.id}")
