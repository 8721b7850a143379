"""Checking TOML tables against a schema, with faults that name place, what was expected and what was found."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any, TypeVar, get_args, get_type_hints

from pydantic import TypeAdapter, ValidationError
from pydantic_core import ErrorDetails

from elastocal.errors import InputError, unknown_name

T = TypeVar("T")


def check(schema: type[T], values: dict[str, Any], path: Path) -> T:
    """The values as the schema's dataclass.

    Raises:
        InputError: with every fault of the file.
    """
    try:
        return TypeAdapter(schema).validate_python(values)
    except ValidationError as error:
        faults = [f"{path}: {_sentence(schema, values, fault)}" for fault in error.errors()]
        raise InputError(*dict.fromkeys(faults)) from None


def _sentence(schema: type, values: dict[str, Any], fault: ErrorDetails) -> str:
    place, kind, context = fault["loc"], fault["type"], fault.get("ctx", {})
    where = _place(values, place)
    if kind == "unexpected_keyword_argument":
        return f"{_place(values, place[:-1])}{unknown_name('key', str(place[-1]), _keys(schema, place[:-1]))}"
    if kind in ("missing", "missing_argument"):
        return f"{_place(values, place[:-1])}{place[-1]!r} is missing"
    found = repr(fault["input"])
    found = found if len(found) < 60 else found[:57] + "..."
    if kind == "literal_error":
        return f"{where}expected {context['expected']}, found {found}"
    message = fault["msg"].removeprefix("Input should be ").removeprefix("a valid ")
    return f"{where}expected {message}, found {found}"


def _place(values: Any, place: tuple[str | int, ...]) -> str:
    """Where in the file: "row 2 ('3'), limits: "."""
    words: list[str] = []
    for key in place:
        if isinstance(key, int):
            values = values[key] if isinstance(values, list) and key < len(values) else None
            name = values.get("name") if isinstance(values, dict) else None
            words.append(f"{words.pop()} {key + 1}" + (f" ({name!r})" if name else "") if words else str(key + 1))
        else:
            values = values.get(key) if isinstance(values, dict) else None
            words.append(key)
    return f"{', '.join(words)}: " if words else ""


def _keys(schema: Any, place: tuple[str | int, ...]) -> list[str]:
    """The keys that a table at some place may have."""
    for key in place:
        inner = get_args(schema)
        schema = inner[-1] if inner else get_type_hints(schema)[str(key)]
        schema = next((option for option in get_args(schema) if hasattr(option, "__dataclass_fields__")), schema)
    return [f.name for f in fields(schema)]
