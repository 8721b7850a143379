"""Robot files of either kind."""

from __future__ import annotations

from pathlib import Path

from elastocal.errors import InputError
from elastocal.io.files import require_file, write_files
from elastocal.io.robot_toml import read_robot_toml, robot_to_toml
from elastocal.io.urdf import read_urdf
from elastocal.robot import Robot


def load_robot(path: str | Path, tip: str | None = None) -> Robot:
    """Read a robot from a robot file (TOML) or a URDF.

    Args:
        path: of the file.
        tip: the link where the chain of a URDF ends, where it branches.

    Raises:
        InputError: with every fault of the file.
    """
    path = require_file(Path(path))
    if path.suffix.lower() in (".urdf", ".xml", ".xacro"):
        return read_urdf(path, tip)
    if tip is not None:
        raise InputError(f"{path}: --tip is for a URDF; a robot file has one chain")
    if path.suffix.lower() != ".toml":
        found = path.suffix or "no suffix"
        raise InputError(f"{path}: expected a robot file (.toml) or a URDF (.urdf), found {found}")
    return read_robot_toml(path)


def save_robot(robot: Robot, path: str | Path) -> None:
    """Write a robot file, SI units.

    Raises:
        InputError: the file cannot be written.
    """
    path = Path(path)
    write_files(path.parent, {path.name: robot_to_toml(robot)})
