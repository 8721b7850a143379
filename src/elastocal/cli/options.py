"""Options that several commands share."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from cyclopts.validators import Number

from elastocal.errors import InputError

Globs = Annotated[list[str], Parameter(consume_multiple=True, negative=())]
Paths = Annotated[list[Path], Parameter(consume_multiple=True, negative=())]
Output = Annotated[Path | None, Parameter(name=("--output", "-o"))]
Json = Annotated[bool, Parameter(name="--json", negative=())]
Seed = Annotated[int, Parameter(validator=Number(gte=0))]
Tip = Annotated[str | None, Parameter(name="--tip")]


def parse_elastic(text: str | None) -> dict[str, str]:
    """Laws by element from "2:step,3:hinge,5": an element without a law is linear.

    Raises:
        InputError: an element is named twice, or none is.
    """
    laws: dict[str, str] = {}
    for item in (text or "").split(",") if text is not None else ():
        element, _, law = item.strip().partition(":")
        if not element:
            raise InputError(
                f"--elastic {text}: expected elements as in 2,3 or 2:linear,3.alpha:linear, found an empty one"
            )
        if element in laws:
            raise InputError(f"--elastic {text}: element {element!r} is named twice")
        laws[element] = law.strip() or "linear"
    return laws


def require_data(data: Sequence[Path], held_out: Sequence[Path] = ()) -> None:
    """Check that there are measurements, and that those held out are others.

    Raises:
        InputError: there are none, or a file is both fitted and held out.
    """
    if not data:
        raise InputError("expected at least one file of measurements right after the robot, before options; found none")
    fitted = {path.resolve() for path in data}
    both = [path for path in held_out if path.resolve() in fitted]
    if both:
        raise InputError(*(f"{path} is both fitted and held out: choose one" for path in both))
