"""The files of a run: what each is for, and all that is wrong with them."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path, PurePosixPath, PureWindowsPath
from typing import Any, TypeVar

from elastocal.errors import ElastocalError, InputError
from elastocal.io import load_measurements, load_robot
from elastocal.io.urdf import tips_of
from elastocal.measurements import Measurements, concatenate
from elastocal.robot import Robot
from elastocal.web.faults import Fault, fault_of
from elastocal.web.runs import Run
from elastocal.web.settings import Settings
from elastocal.web.study import Study, study

ROLES = {
    "robot": ("robot", "unused"),
    "measurements": ("fit", "held_out", "unused"),
    "table": ("described",),
    "other": ("unused",),
}
"""What a file of each kind may be for."""

ROLE_WORDS = {
    "robot": "Robot",
    "fit": "Fit",
    "held_out": "Hold out",
    "described": "Read by its descriptor",
    "unused": "Not used",
}

MOST_TEXT = 8 * 1024 * 1024
"""Bytes of a robot file or a descriptor, at most."""


T = TypeVar("T")


@dataclass(frozen=True)
class InputFile:
    """A file that the user gave.

    Attributes:
        kind: a key of ROLES.
        role: what it is for, one of ROLES[kind].
        told: a few words on what is in it.
        faults: what is wrong with it.
    """

    name: str
    size: int
    kind: str
    role: str
    told: str = ""
    faults: tuple[Fault, ...] = ()


@dataclass(frozen=True)
class Inputs:
    """The files of a run, read.

    Attributes:
        robot: None where there is none that can be read; the same of `fit` and `held_out`.
        tips: links where the chain of a URDF may end, where there are several.
    """

    files: tuple[InputFile, ...]
    robot: Robot | None = None
    fit: Measurements | None = None
    held_out: Measurements | None = None
    tips: tuple[str, ...] = ()

    @cached_property
    def study(self) -> Study | None:
        """What can be said before any calibration; None without robot and measurements."""
        return study(self.robot, self.fit) if self.robot and self.fit else None

    def named(self, role: str) -> list[str]:
        """Names of the files with a role."""
        return [file.name for file in self.files if file.role == role]

    @property
    def sound(self) -> bool:
        """Whether nothing stands in the way of a calibration."""
        faulty = any(file.faults for file in self.files if file.role != "unused")
        return bool(not faulty and self.study and not self.study.faults)


def inspect(run: Run, settings: Settings) -> Inputs:
    """Read the files of a run; a file that has not changed is not read again."""
    stated = tuple((path.name, path.stat().st_size, path.stat().st_mtime_ns) for path in run.files())
    return _inspect(run.inputs, stated, tuple(sorted(settings.roles.items())), settings.tip)


@lru_cache(maxsize=6)
def _inspect(
    folder: Path, stated: tuple[tuple[str, int, int], ...], roles: tuple[tuple[str, str], ...], tip: str
) -> Inputs:
    given = {name: moment for name, _, moment in stated}
    files = _with_roles(folder, [_classified(folder / name, size) for name, size, _ in stated], dict(roles), given)
    robots = [file for file in files if file.role == "robot"]
    found = Inputs(tuple(files))
    if not robots:
        return found
    path = folder / robots[0].name
    robot, faults = _tried(folder, lambda: load_robot(path, tip or None))
    tips = _tips(path)
    found = replace(found, robot=robot, tips=tips if len(tips) > 1 else ())
    told = "" if robot is None else _robot_told(robot)
    found = _changed(found, robots[0].name, told=told, faults=faults)
    return found if robot is None else _with_measurements(found, folder, robot)


def _tips(path: Path) -> tuple[str, ...]:
    found, _ = _tried(path.parent, lambda: tips_of(path)) if path.suffix.lower() != ".toml" else (None, ())
    return found or ()


def _classified(path: Path, size: int) -> InputFile:
    """A file with its kind, by suffix and, of TOML, by its format."""
    file, suffix = InputFile(path.name, size, "other", "unused"), path.suffix.lower()
    if suffix in (".toml", ".urdf", ".xml", ".xacro") and size > MOST_TEXT:
        return replace(file, faults=(Fault("", f"expected at most {MOST_TEXT >> 20} MB, found {size >> 20} MB"),))
    if suffix in (".urdf", ".xml", ".xacro"):
        return replace(file, kind="robot", role="robot")
    if suffix != ".toml":
        return replace(file, kind="measurements", role="fit")
    if not is_descriptor(path):
        return replace(file, kind="robot", role="robot")
    faults = descriptor_faults(path)
    return replace(file, kind="measurements", role="fit", faults=faults)


def is_descriptor(path: Path) -> bool:
    """Whether a TOML file describes an instrument's file, by its format or by what is in it."""
    values = _toml(path)
    stated = str(values.get("format", ""))
    return stated.startswith("elastocal-measurements") or (not stated and "columns" in values)


def descriptor_faults(path: Path) -> tuple[Fault, ...]:
    """Why the file that a descriptor describes is not read: only one that lies beside it is."""
    name = _toml(path).get("file")
    if not isinstance(name, str):
        return ()  # which reading it will tell
    plain = name == PurePosixPath(name).name == PureWindowsPath(name).name and name not in ("", ".", "..")
    if not plain or (path.parent / name).is_symlink():
        what = f"expected the name of a file given with it, as tracker.csv, found {name!r}: no other file is read"
        return (Fault("file", what),)
    return ()


def _toml(path: Path) -> Mapping[str, Any]:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except (ValueError, OSError, RecursionError):
        return {}


def _with_roles(
    folder: Path, files: list[InputFile], roles: Mapping[str, str], given: Mapping[str, int]
) -> list[InputFile]:
    """What each file is for: as the user says, else as suits: the latest robot, and what is called held-out apart."""
    descriptors = [file.name for file in files if file.kind == "measurements" and file.name.lower().endswith(".toml")]
    described = {_toml(folder / name).get("file") for name in descriptors}
    sorted_out = [replace(f, kind="table", role="described") if f.name in described else f for f in files]
    return [_with_role(file, sorted_out, roles, given) for file in sorted_out]


def _with_role(
    file: InputFile, files: Sequence[InputFile], roles: Mapping[str, str], given: Mapping[str, int]
) -> InputFile:
    if roles.get(file.name) in ROLES[file.kind]:
        return replace(file, role=roles[file.name])
    if file.kind == "robot":
        others = [f.name for f in files if f.kind == "robot" and roles.get(f.name) != "unused"]
        latest = max(others, key=lambda name: (roles.get(name) == "robot", given[name]))
        return replace(file, role="robot" if file.name == latest else "unused")
    words = file.name.lower().replace("-", "").replace("_", "").replace(" ", "")
    if file.kind == "measurements" and words.startswith(("heldout", "holdout", "validat")):
        return replace(file, role="held_out")
    return file


def _with_measurements(found: Inputs, folder: Path, robot: Robot) -> Inputs:
    """The measurements read, each file by itself, then together."""
    parts: dict[str, list[Measurements]] = {"fit": [], "held_out": []}
    for file in found.files:
        if file.role in parts and not file.faults:
            data, faults = _tried(folder, _reader(folder / file.name, robot))
            told = "" if data is None else _data_told(data)
            found = _changed(found, file.name, told=told, faults=faults)
            parts[file.role] += [data] if data is not None else []
    fit, held_out = (concatenate(data) if data else None for data in parts.values())
    return replace(found, fit=fit, held_out=held_out)


def _reader(path: Path, robot: Robot) -> Callable[[], Measurements]:
    return lambda: load_measurements(path, robot)


def _changed(found: Inputs, name: str, **changes: Any) -> Inputs:
    """With something else in one file."""
    return replace(found, files=tuple(replace(f, **changes) if f.name == name else f for f in found.files))


def _tried(folder: Path, read: Callable[[], T]) -> tuple[T | None, tuple[Fault, ...]]:
    """What reading gives, or what is wrong."""
    try:
        return read(), ()
    except InputError as error:
        return None, tuple(fault_of(fault, folder) for fault in error.faults)
    except ElastocalError as error:
        return None, (Fault("", str(error)),)
    except RecursionError:
        return None, (Fault("", "expected a file that a person could have written, found one nested too deeply"),)


def _robot_told(robot: Robot) -> str:
    masses = sum(1 for row in robot.rows if row.mass)
    weighed = f"{masses} link masses" if masses else "no link masses"
    return f"{robot.name}: {len(robot.joints)} joints, {weighed}"


def _data_told(data: Measurements) -> str:
    kinds = [kind for kind in ("position", "orientation", "distance") if getattr(data, kind) is not None]
    return f"{len(data)} rows of {' and '.join(kinds)}"
