"""Templates, and what they are given."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from starlette.responses import HTMLResponse

from elastocal.web.runs import WORDS, Run, State
from elastocal.web.security import MOST_UPLOAD
from elastocal.web.worker import Workers

_WRONG = {400: "This request is not understood.", 404: "There is nothing here.", 413: "Too large."}


@dataclass(frozen=True)
class Card:
    """A run as lists show it.

    Attributes:
        word, sentence: of its state.
        before, after: mean errors of the nominal and of the calibrated robot [mm]; None without a result.
        kind: of these errors: "held-out", "expected" or "fitted".
    """

    run: Run
    title: str
    state: State
    word: str
    sentence: str
    before: float | None = None
    after: float | None = None
    kind: str = ""


@lru_cache(maxsize=1)
def _environment() -> Environment:
    found = Environment(
        loader=FileSystemLoader(Path(__file__).with_name("templates")),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=StrictUndefined,
    )
    found.filters["size"] = _size
    found.globals |= {"version": version("elastocal"), "limit": MOST_UPLOAD}
    return found


def page(template: str, status: int = 200, headers: Mapping[str, str] | None = None, **values: Any) -> HTMLResponse:
    """A template with its values."""
    return HTMLResponse(_environment().get_template(template).render(**values), status, headers)


def error_page(status: int, message: str) -> HTMLResponse:
    """What went wrong, as a page."""
    return page("error.html", status, title=_WRONG.get(status, "This did not work."), message=message)


def card(run: Run, workers: Workers) -> Card:
    """A run as lists show it."""
    state = run.state(workers.at_work(run))
    word, sentence = WORDS[state]
    result = run.result / "result.json"
    headline = _headline(result, result.stat().st_mtime_ns) if result.is_file() and state != State.RUNNING else {}
    stems = sorted((file.stem for file in run.files()), key=lambda stem: "robot" not in stem.lower())
    title = run.settings.name or headline.get("robot") or next(iter(stems), "Empty")
    errors = (headline.get("before"), headline.get("after"), headline.get("kind", ""))
    return Card(run, title, state, word, sentence, *errors)


@lru_cache(maxsize=1000)
def _headline(path: Path, _written: int) -> dict[str, Any]:
    """The robot's name and the errors that count most, of a result that may be large."""
    summary = Run(path.parents[1]).summary or {}
    residuals = summary.get("residuals", {})
    found: dict[str, Any] = {"robot": summary.get("robot")}
    for after, before, kind in (
        ("held_out", "held_out_nominal", "held-out"),
        ("cross_validated", "nominal", "expected"),
        ("calibrated", "nominal", "fitted"),
    ):
        if "mean" in residuals.get(after, {}):
            means = (1e3 * residuals[name]["mean"] for name in (before, after))
            return found | dict(zip(("before", "after"), means, strict=True)) | {"kind": kind}
    return found


def _size(count: int) -> str:
    """A number of bytes for people."""
    return f"{count} B" if count < 1000 else f"{count / 1e3:.0f} kB" if count < 1e6 else f"{count / 1e6:.1f} MB"
