"""Values of tables and files as a user writes them: read one by one, with a fault that names the column."""

from __future__ import annotations

from elastocal.errors import InputError, unknown_name

LOSSES = ("linear", "huber", "cauchy")


def number(option: str, text: str) -> float:
    """A number.

    Raises:
        InputError: it is none.
    """
    try:
        return float(text)
    except ValueError:
        raise InputError(f"{option}: expected a number, found {text!r}") from None


def count(option: str, text: str) -> int:
    """A whole number, 0 or more.

    Raises:
        InputError: it is none.
    """
    if not text.isdecimal():
        raise InputError(f"{option}: expected a whole number, 0 or more, found {text!r}")
    return int(text)


def flag(option: str, text: str) -> bool:
    """True or false.

    Raises:
        InputError: it is neither.
    """
    valid = {"true": True, "yes": True, "1": True, "false": False, "no": False, "0": False}
    if text.lower() not in valid:
        raise InputError(f"{option}: expected true or false, found {text!r}")
    return valid[text.lower()]


def loss(option: str, text: str) -> str:
    """A loss of `calibrate`.

    Raises:
        InputError: there is none of this name.
    """
    if text not in LOSSES:
        raise InputError(f"{option}: {unknown_name('loss', text, LOSSES)}")
    return text


def patterns(option: str, text: str) -> list[str]:
    """Patterns of names, with ; or , between them.

    Raises:
        InputError: one is empty.
    """
    found = [part.strip() for part in text.replace(";", ",").split(",")]
    if not all(found):
        raise InputError(f"{option} {text}: expected patterns as *.theta;2.*, found an empty one")
    return found


def fraction(option: str, text: str) -> float:
    """A number between 0 and 1.

    Raises:
        InputError: it is none.
    """
    value = number(option, text)
    if not 0.0 < value < 1.0:
        raise InputError(f"{option}: expected a fraction between 0 and 1, as 0.3, found {text}")
    return value
