"""What a run is to do: a value, its file, and the command that does the same."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from typing import Any

from elastocal.errors import InputError

LAWS = ("rigid", "linear", "step", "hinge", "cubic")

LOSSES = ("linear", "huber", "cauchy")

GROUPS = {"offsets": "Joint offsets", "lengths": "Lengths", "angles": "Axis angles"}
"""Kinds of geometry that are identified or left as they are."""


@dataclass(frozen=True)
class Settings:
    """The options of `elastocal calibrate`, as a form has them; what a field is called there it is called here.

    Attributes:
        name: of the run, for people.
        roles: what a file is for, by its name, where the user says so.
        tip: of a URDF that branches.
        groups: keys of GROUPS that are identified.
        laws: law or "rigid" by joint; None: as suggested.
        holdout: fraction of the rows; None: as suggested.
        transition: "exact", "ga" or "given", then `torques`.
        maps: "none", "auto" or "orders", then `orders`.
    """

    name: str = ""
    roles: Mapping[str, str] = field(default_factory=dict)
    tip: str = ""
    groups: tuple[str, ...] = tuple(GROUPS)
    identify: tuple[str, ...] = ()
    fix: tuple[str, ...] = ()
    laws: Mapping[str, str] | None = None
    transition: str = "exact"
    torques: str = ""
    population: int = 40
    generations: int = 50
    non_negative: bool = False
    holdout: float | None = None
    loss: str = "linear"
    maps: str = "none"
    orders: int = 60
    prior: bool = False
    bootstrap: int = 0
    seed: int = 0

    @property
    def elastic(self) -> dict[str, str]:
        """Laws of the joints that give way."""
        return {joint: law for joint, law in (self.laws or {}).items() if law != "rigid"}


def settings_json(settings: Settings) -> str:
    """Settings as a file."""
    return json.dumps(asdict(settings), indent=1, ensure_ascii=False) + "\n"


def settings_of(values: Mapping[str, Any]) -> Settings:
    """Settings from a file that may be of another version: what is not known there is left out."""
    known = {f.name: values[f.name] for f in fields(Settings) if f.name in values}
    for name in ("groups", "identify", "fix"):
        if name in known:
            known[name] = tuple(known[name])
    return Settings(**known)


def settings_of_form(before: Settings, form: Mapping[str, Sequence[str]]) -> Settings:
    """Settings with what a form says; files and tip are not in it.

    Raises:
        InputError: something in it is not what it should be; says all of it.
    """
    faults: list[str] = []

    def text(name: str) -> str:
        return (form.get(name) or [""])[0].strip()

    def chosen(name: str, choices: Sequence[str]) -> str:
        if text(name) not in choices:
            faults.append(f"{name}: expected {', '.join(choices)}, found {text(name)!r}")
        return text(name)

    def whole(name: str, least: int) -> int:
        if not (text(name).isdecimal() and len(text(name)) < 10 and int(text(name)) >= least):
            faults.append(f"{name}: expected a whole number of at least {least}, found {text(name)!r}")
            return least
        return int(text(name))

    laws = {name.removeprefix("law "): chosen(name, LAWS) for name in form if name.startswith("law ")}
    found = replace(
        before,
        name=text("name")[:80],
        groups=tuple(group for group in GROUPS if group in form.get("groups", ())),
        identify=tuple(text("identify").replace(",", " ").split()),
        fix=tuple(text("fix").replace(",", " ").split()),
        laws=laws if laws else before.laws,
        transition=chosen("transition", ("exact", "ga", "given")),
        torques=text("torques"),
        population=whole("population", 2),
        generations=whole("generations", 1),
        non_negative="non_negative" in form,
        holdout=_fraction(text("holdout"), faults) if "holdout" in form else before.holdout,
        loss=chosen("loss", LOSSES),
        maps=chosen("maps", ("none", "auto", "orders")),
        orders=whole("orders", 1),
        prior="prior" in form,
        bootstrap=whole("bootstrap", 0),
        seed=whole("seed", 0),
    )
    if found.transition == "given" and any(law in ("step", "hinge") for law in laws.values()):
        _check_torques(found.torques, faults)
    if faults:
        raise InputError(*faults)
    return found


def _fraction(text: str, faults: list[str]) -> float:
    """Per cent of the rows, as a fraction."""
    try:
        value = float(text.replace(",", ".") or 0) / 100.0
    except ValueError:
        value = math.nan
    if not 0.0 <= value < 1.0:
        faults.append(f"hold out: expected 0 to 99 % of the rows, found {text!r}")
        return 0.0
    return value


def _check_torques(text: str, faults: list[str]) -> None:
    try:
        sound = all(math.isfinite(float(part)) for part in text.split(","))
    except ValueError:
        sound = False
    if not sound:
        faults.append(f"transition torques: expected numbers in N·m with commas between them, found {text!r}")
