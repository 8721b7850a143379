"""Study files: TOML in."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import field
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field
from pydantic.dataclasses import dataclass

from elastocal.comparison import MODELS
from elastocal.errors import InputError, unknown_name
from elastocal.examples import ROBOT_FILE
from elastocal.identification.request import with_laws
from elastocal.identification.words import orders_of
from elastocal.io.cells import count, flag, loss, number, patterns
from elastocal.io.checking import STRICT, Count, Number, Pair, Positive, Texts, check
from elastocal.io.files import read_toml
from elastocal.io.robot_files import load_robot
from elastocal.io.study_values import MEASURES, Actual, Setting, Spring, Study
from elastocal.io.units import parse_quantity
from elastocal.measurements import KINDS
from elastocal.robot import Robot

FORMAT = "elastocal-study/1"

EXAMPLE = "example"
"""Instead of a robot file: the built-in arm."""

Span = Annotated[Pair | Number, "a number, or the least and the greatest in brackets"]


@dataclass(config=STRICT)
class SpringEntry:
    """[actual.elastic.*], SI."""

    compliance: Span
    stiffening: Positive = 1.0
    transition_torque: Span | None = None
    largest_load: Positive | None = None


@dataclass(config=STRICT)
class ActualEntry:
    """[actual]."""

    geometry_error: str = "0,0"
    elastic: dict[str, SpringEntry] = field(default_factory=dict)


@dataclass(config=STRICT)
class StudyEntry:
    """The whole file."""

    format: Literal["elastocal-study/1"]
    repeats: Annotated[int, Field(strict=True, ge=1), "a whole number, 1 or more"]
    grid: Annotated[dict[str, Any], Field(min_length=1), "what is varied, as poses = [20, 40, 60]"]
    name: str = ""
    robot: str = EXAMPLE
    seed: Count = 0
    held_out: Annotated[int, Field(strict=True, ge=1), "a whole number, 1 or more"] = 200
    measures: Texts = field(default_factory=list)
    actual: ActualEntry = field(default_factory=ActualEntry)
    setting: dict[str, Any] = field(default_factory=dict)


def _one_of(*valid: str) -> Callable[[str, str], str]:
    def read(option: str, text: str) -> str:
        if text not in valid:
            raise InputError(f"{option}: {unknown_name('choice', text, valid)}")
        return text

    return read


def _positive_count(option: str, text: str) -> int:
    if not count(option, text):
        raise InputError(f"{option}: expected a whole number, 1 or more, found {text}")
    return int(text)


def _quantity(kind: str) -> Callable[[str, str], float]:
    def read(option: str, text: str) -> float:
        try:
            value = parse_quantity(text, kind)
        except InputError as error:
            raise InputError(*(f"{option}: {fault}" for fault in error.faults)) from None
        if value < 0.0:
            raise InputError(f"{option}: expected 0 or a positive {kind}, found {text}")
        return value

    return read


def _share(option: str, text: str) -> float:
    value = number(option, text)
    if not 0.0 <= value < 1.0:
        raise InputError(f"{option}: expected a fraction of the rows, as 0.1, found {text}")
    return value


def _kinds(option: str, text: str) -> str:
    found = list(dict.fromkeys(part.strip() for part in text.split(",")))
    wrong = [kind for kind in found if kind not in KINDS]
    if wrong:
        raise InputError(*(f"{option}: {unknown_name('kind', kind, KINDS)}" for kind in wrong))
    return ",".join(found)


READERS: dict[str, Callable[[str, str], Any]] = {
    "poses": _positive_count,
    "selection": _one_of("random", "planned"),
    "kinds": _kinds,
    "noise": _quantity("length"),
    "noise_angle": _quantity("angle"),
    "outliers": _share,
    "outlier_size": _quantity("length"),
    "payload": lambda _, text: ",".join(part.strip() for part in text.split(",")),
    "law": _one_of(*MODELS),
    "model": _one_of("actual", *MODELS),
    "transition": _one_of("exact", "ga", "true"),
    "identify": lambda option, text: ";".join(patterns(option, text)) if text else "",
    "fix": lambda option, text: ";".join(patterns(option, text)) if text else "",
    "loss": loss,
    "transmission": lambda option, text: str(orders_of(option, text)),
    "prior": flag,
    "non_negative": flag,
    "bootstrap": count,
}
"""How each part of a setting is read."""


def read_study(path: str | Path) -> Study:
    """A study file; the robot's file is relative to it.

    Raises:
        InputError: with every fault of the file.
    """
    path = Path(path)
    entry = check(StudyEntry, read_toml(path), path)
    faults: list[str] = []
    robot = None
    try:
        robot = load_robot(ROBOT_FILE if entry.robot == EXAMPLE else path.parent / entry.robot)
    except InputError as error:
        faults += [f"robot: {fault}" for fault in error.faults]
    for measure in entry.measures:
        if measure not in MEASURES:
            faults.append(f"measures: {unknown_name('measure', measure, MEASURES)}")
    actual = _actual(entry.actual, faults)
    usual: dict[str, Any] = {"law": "linear" if entry.actual.elastic else "rigid"}
    fixed = usual | {key: _read(f"setting.{key}", key, value, faults) for key, value in entry.setting.items()}
    for key, values in entry.grid.items():
        if not _listed(values):
            faults.append(f"grid.{key}: expected one value or more in brackets, found {values!r}")
    listed = {key: values for key, values in entry.grid.items() if _listed(values)}
    grid = {key: [_read(f"grid.{key}", key, value, faults) for value in values] for key, values in listed.items()}
    faults += [f"{key} is both in [setting] and in [grid]: choose one" for key in entry.grid if key in entry.setting]
    faults += [f"grid.{key}: a value is there twice" for key, values in grid.items() if len(set(values)) < len(values)]
    settings: tuple[Setting, ...] = ()
    if not faults:
        settings = tuple(
            Setting(**(fixed | dict(zip(grid, values, strict=True)))) for values in product(*grid.values())
        )
        faults += dict.fromkeys(
            fault for setting in settings for fault in _setting_faults(setting, actual, entry.measures)
        )
    if robot is not None:
        faults += _robot_faults(robot, settings, actual)
    if faults or robot is None:
        raise InputError(*(f"{path}: {fault}" for fault in faults))
    return Study(
        name=entry.name or path.stem,
        robot=robot,
        actual=actual,
        settings=settings,
        varied=tuple(key for key, values in grid.items() if len(values) > 1) or tuple(grid),
        repeats=entry.repeats,
        seed=entry.seed,
        held_out=entry.held_out,
        measures=tuple(dict.fromkeys(entry.measures)),
    )


def _listed(values: object) -> bool:
    return isinstance(values, list) and bool(values)


def _read(place: str, key: str, value: object, faults: list[str]) -> Any:
    """A value of a setting; what is wrong with it is added to the faults."""
    if key not in READERS:
        text = f"{place.rpartition('.')[0]}: {unknown_name('key', key, READERS)}"
        faults += [] if text in faults else [text]
        return None
    if isinstance(value, list) and all(isinstance(item, str) for item in value):
        value = ";".join(value) if key in ("identify", "fix") else ",".join(value)
    if not isinstance(value, (str, int, float)):
        faults.append(f"{place}: expected text, a number, or true or false, found {value!r}")
        return None
    try:
        return READERS[key](place, str(value).lower() if isinstance(value, bool) else str(value))
    except InputError as error:
        faults += error.faults
        return None


def _span(value: tuple[float, float] | float) -> tuple[float, float]:
    return value if isinstance(value, tuple) else (value, value)


def _actual(entry: ActualEntry, faults: list[str]) -> Actual:
    parts = entry.geometry_error.split(",")
    errors = [0.0, 0.0]
    if len(parts) != len(errors):
        faults.append(
            f"actual.geometry_error: expected a length and an angle, as 0.5mm,0.5mrad, found {len(parts)} parts"
        )
    else:
        for i, (part, kind) in enumerate(zip(parts, ("length", "angle"), strict=True)):
            try:
                errors[i] = _quantity(kind)("actual.geometry_error", part)
            except InputError as error:
                faults += error.faults
    springs = {}
    for element, given in entry.elastic.items():
        torque = None if given.transition_torque is None else _span(given.transition_torque)
        springs[element] = Spring(_span(given.compliance), given.stiffening, torque, given.largest_load)
        for key, span in (("compliance", springs[element].compliance), ("transition_torque", torque)):
            if span is not None and not 0.0 < span[0] <= span[1]:
                faults.append(
                    f"actual.elastic.{element}.{key}: expected positive numbers, the least first, found {span}"
                )
    return Actual((errors[0], errors[1]), springs)


def _setting_faults(setting: Setting, actual: Actual, measures: list[str]) -> Iterator[str]:
    """What of a setting has no sense."""
    if not actual.springs and setting.law != "rigid":
        yield f"law {setting.law}: expected elements that give way, as [actual.elastic.2], found none"
    if not actual.springs and (setting.model not in ("actual", "rigid") or "recommendation" in measures):
        yield "what is fitted needs elements that give way, as [actual.elastic.2]; found none"
    needed = {"step": "transition_torque", "hinge": "transition_torque", "cubic": "largest_load"}.get(setting.law)
    for element, spring in actual.springs.items():
        if needed and getattr(spring, needed) is None:
            yield f"actual.elastic.{element}: {needed!r} is missing: the law {setting.law} needs it"
    if setting.transition == "true" and (setting.law != setting.fitted or setting.law not in ("step", "hinge")):
        yield f"transition true: only where law and model are step or hinge, found {setting.law} and {setting.fitted}"
    if "transition" in measures and setting.fitted not in ("step", "hinge"):
        yield f"measures transition: the model {setting.fitted} has no transition torque"


def _robot_faults(robot: Robot, settings: tuple[Setting, ...], actual: Actual) -> Iterator[str]:
    for name in dict.fromkeys(name for setting in settings for name in setting.payload.split(",")):
        if name != "none" and name not in robot.loads:
            yield f"payload: {robot.name} has {unknown_name('load', name, ['none', *robot.loads])}"
    try:
        with_laws(robot, dict.fromkeys(actual.springs, "linear"))
    except InputError as error:
        yield from (f"actual.elastic: {fault}" for fault in error.faults)


def words(setting: Setting, names: Mapping[str, Any] | tuple[str, ...]) -> tuple[str, ...]:
    """Some parts of a setting as they are shown."""
    shown = []
    for name in names:
        value = getattr(setting, name)
        if name in ("noise", "outlier_size"):
            shown.append(f"{1e3 * value:g} mm")
        elif name == "noise_angle":
            shown.append(f"{1e3 * value:g} mrad")
        elif isinstance(value, bool):
            shown.append("yes" if value else "no")
        else:
            shown.append(str(value) or "all")
    return tuple(shown)
