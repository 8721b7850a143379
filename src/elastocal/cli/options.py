"""Options that several commands share."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from elastocal.errors import InputError

Globs = Annotated[list[str], Parameter(consume_multiple=True, negative=())]
Paths = Annotated[list[Path], Parameter(consume_multiple=True, negative=())]
Output = Annotated[Path | None, Parameter(name=("--output", "-o"))]
Json = Annotated[bool, Parameter(name="--json", negative=())]
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


def require_data(data: Sequence[Path]) -> None:
    """Raise InputError without any measurement file."""
    if not data:
        raise InputError("expected at least one file of measurements after the robot, found none")
