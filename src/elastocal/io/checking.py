"""Checking TOML tables against a schema, with faults that name place, what was expected and what was found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

from pydantic import ConfigDict, Field, TypeAdapter, ValidationError
from pydantic_core import ErrorDetails

from elastocal.errors import InputError, unknown_name

T = TypeVar("T")

Place = tuple[str | int, ...]
"""Keys and indices that lead to an entry of a file."""

STRICT = ConfigDict(extra="forbid")

# The text beside a type is how a fault says what was expected.
Number = Annotated[float, Field(strict=True, allow_inf_nan=False), "a number"]
Positive = Annotated[float, Field(strict=True, gt=0.0, allow_inf_nan=False), "a positive number"]
NotNegative = Annotated[float, Field(strict=True, ge=0.0, allow_inf_nan=False), "0 or a positive number"]
Count = Annotated[int, Field(strict=True, ge=0), "a whole number, 0 or more"]
Flag = Annotated[bool, Field(strict=True), "true or false"]
Character = Annotated[str, Field(min_length=1, max_length=1), "one character in quotes"]
Pair = Annotated[tuple[Number, Number], "2 numbers in brackets"]
Triple = Annotated[tuple[Number, Number, Number], "3 numbers in brackets"]
Numbers = Annotated[list[Number], "numbers in brackets"]
Matrix = Annotated[list[list[Number]], "lines of numbers, as [[1, 0], [0, 1]]"]
Texts = Annotated[list[str], "names in quotes, in brackets"]

FORMATS = {
    "elastocal-robot/1": "a robot file",
    "elastocal-measurements/1": "a description of measurements",
    "elastocal-fleet/1": "a manifest of a fleet",
    "elastocal-study/1": "a study",
}


@dataclass(frozen=True)
class Fault:
    """One fault of a file: where it is, and a sentence."""

    place: Place
    text: str


def check(schema: type[T], values: dict[str, Any], path: Path) -> T:
    """The values as the schema's dataclass.

    Raises:
        InputError: with every fault of the file.
    """
    try:
        return TypeAdapter(schema).validate_python(values)
    except ValidationError as error:
        raise InputError(*(f"{path}: {fault.text}" for fault in faults_of(schema, values, error))) from None


def faults_of(schema: Any, values: dict[str, Any], error: ValidationError) -> list[Fault]:
    """All faults, each told once; of a file of another format only that."""
    found = [_fault(schema, values, details) for details in error.errors()]
    given = values.get("format")
    if isinstance(given, str) and given in FORMATS:
        other = [Fault(f.place, f"{f.text}: {FORMATS[given]}") for f in found if f.place == ("format",)]
        found = other or found
    return list({fault.text: fault for fault in found}.values())


def _fault(schema: Any, values: dict[str, Any], details: ErrorDetails) -> Fault:
    place, kind = details["loc"], details["type"]
    table, key = place[:-1], str(place[-1])
    if kind == "unexpected_keyword_argument":
        return Fault(place, f"{_before(table, values)}{unknown_name('key', key, _keys(schema, values, table))}")
    if kind in ("missing", "missing_argument") and isinstance(place[-1], str):
        expected = _expected(_entry(schema, values, place)[1], key)
        return Fault(place, f"{_before(table, values)}{key!r} is missing: expected {expected}")
    entry, hint, found = _entry(schema, values, place)
    return Fault(entry, f"{_before(entry, values)}expected {_expected(hint, entry[-1])}, found {_found(found)}")


def _entry(schema: Any, values: Any, place: Place) -> tuple[Place, Any, Any]:
    """The innermost entry on the way to a place that the user wrote as one: its place, type and value."""
    hint, walked = _plain(schema), 0
    for key in place:
        if is_dataclass(hint):
            hint = get_type_hints(hint, include_extras=True)[str(key)]
        elif get_origin(hint) is dict or (get_origin(hint) is list and is_dataclass(get_args(hint)[0])):
            hint = get_args(hint)[-1]
        else:
            break
        hint, walked = _plain(hint), walked + 1
        values = _item(values, key)
    return place[:walked], hint, values


def _plain(hint: Any) -> Any:
    """A type without `| None`, and without annotations that are not words."""
    if get_origin(hint) in (Union, UnionType):
        hint = next(option for option in get_args(hint) if option is not type(None))
    if get_origin(hint) is Annotated and not _words(hint):
        hint = get_args(hint)[0]
    return hint


def _words(hint: Any) -> str:
    return next((word for word in get_args(hint) if isinstance(word, str)), "")


def _item(values: Any, key: str | int) -> Any:
    if isinstance(values, Mapping):
        return values.get(key)
    return values[key] if isinstance(values, list) and isinstance(key, int) and key < len(values) else None


def _expected(hint: Any, key: str | int) -> str:
    if get_origin(hint) is Literal:
        *others, last = (_found(choice) for choice in get_args(hint))
        return f"{', '.join(others)} or {last}" if others else last
    if get_origin(hint) is Annotated:
        return _words(hint)
    if get_origin(hint) is list:
        return f"one or more tables [[{key}]]"
    return "text in quotes" if hint is str else "a table"


def _found(value: Any) -> str:
    """A value as it stands in the file."""
    if isinstance(value, Mapping):
        return "a table"
    if isinstance(value, bool):
        return "true" if value else "false"
    text = f'"{value}"' if isinstance(value, str) else repr(value)
    return text if len(text) < 60 else text[:57] + "..."


def _before(place: Place, values: Any) -> str:
    """Where in the file, to go before a fault: 'row 2 ("elbow"), limits: '."""
    if len(place) > 1 and place[0] == "row" and isinstance(place[1], int):
        name = _item(_item(_item(values, "row"), place[1]), "name")
        return f"{', '.join([row_place(place[1], name), *map(str, place[2:])])}: "
    return f"{dotted(place)}: " if place else ""


def row_place(index: int, name: object) -> str:
    """A row of the robot file, by its number and, where that says more, its name."""
    return f"row {index + 1}" + (f' ("{name}")' if isinstance(name, str) and name not in ("", str(index + 1)) else "")


def dotted(place: Sequence[str | int]) -> str:
    """A place as TOML writes it: elastic."2.theta".law."""
    return ".".join(f'"{key}"' if "." in str(key) else str(key) for key in place)


def _keys(schema: Any, values: Any, place: Place) -> list[str]:
    """The keys that a table at some place may have."""
    return [f.name for f in fields(_entry(schema, values, place)[1])]
