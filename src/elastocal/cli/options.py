"""Options that several commands share."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter
from cyclopts.validators import Number

from elastocal.errors import InputError

if TYPE_CHECKING:
    from elastocal.identification.transition import Transition

Globs = Annotated[list[str], Parameter(consume_multiple=True, negative=())]
Paths = Annotated[list[Path], Parameter(consume_multiple=True, negative=())]
Output = Annotated[Path | None, Parameter(name=("--output", "-o"))]
Json = Annotated[bool, Parameter(name="--json", negative=())]
Seed = Annotated[int, Parameter(validator=Number(gte=0))]
Jobs = Annotated[int | None, Parameter(validator=Number(gte=1))]
Tip = Annotated[str | None, Parameter(name="--tip")]
Page = Annotated[Path | None, Parameter(name="--html")]


def parse_elastic(text: str | None) -> dict[str, str]:
    """Laws by element from "2:step,3:hinge,5": an element without a law is linear.

    Raises:
        InputError: an element is named twice, or none is.
    """
    from elastocal.identification.words import laws_of

    return laws_of("--elastic", text)


def parse_transition(text: str, population: int | None = None, generations: int | None = None) -> Transition:
    """How transition torques are found, from "exact", "ga" or "222,80".

    Raises:
        InputError: it is none of these, or the size of a genetic search is given without one.
    """
    from elastocal.identification.words import transition_of

    return transition_of("--transition", text, population, generations, "--population and --generations")


def parse_orders(text: str) -> int | str:
    """Orders of joint maps, from a number or "auto".

    Raises:
        InputError: it is neither.
    """
    from elastocal.identification.words import orders_of

    return orders_of("--transmission", text)


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


def parse_names(given: Sequence[str] | None) -> list[str]:
    """Names given one by one, or with commas between them."""
    return [name.strip() for text in given or () for name in text.split(",") if name.strip()]


def parse_quantities(option: str, text: str, quantities: Sequence[str], signed: bool = False) -> tuple[float, ...]:
    """Numbers with units, as "0.5mm,0.5mrad", in SI.

    Args:
        option: that they were given to, "--noise".
        text: numbers with commas between them.
        quantities: what each is, "length" or "angle".
        signed: whether they may be negative.

    Raises:
        InputError: there are more or fewer, or one is no such number.
    """
    from elastocal.io.units import parse_quantity

    parts = text.split(",")
    if len(parts) != len(quantities):
        expected = f"{len(quantities)} numbers with commas between them" if len(quantities) > 1 else "one number"
        raise InputError(f"{option} {text}: expected {expected} ({', '.join(quantities)}), found {len(parts)}")
    found = []
    for part, quantity in zip(parts, quantities, strict=True):
        try:
            found.append(parse_quantity(part, quantity))
        except InputError as error:
            raise InputError(*(f"{option} {text}: {fault}" for fault in error.faults)) from None
        if found[-1] < 0.0 and not signed:
            raise InputError(f"{option} {text}: expected 0 or a positive {quantity}, found {part.strip()}")
    return tuple(found)


def command_line(command: str, files: Sequence[Path], **options: object) -> str:
    """The command that says the same: options by their names, those that are None, False or empty left out."""
    words = ["elastocal", command, *map(str, files)]
    for name, value in options.items():
        if value is None or value is False or value == []:
            continue
        words.append("-o" if name == "output" else f"--{name.replace('_', '-')}")
        if value is not True:
            words += [str(item) for item in value] if isinstance(value, (list, tuple)) else [str(value)]
    return shlex.join(words)
