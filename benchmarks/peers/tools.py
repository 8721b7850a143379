"""The tools, their settings, and the lines of code that a user writes for each."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
SOURCE = HERE.parents[1]
"""This tree, which elastocal is installed from."""

ENDED = "arm ended: "
"""Begins the line by which a script says that an arm's process has ended."""

BEGIN, END, GLUE = "# user code:", "# end of user code", "from exchange import"


@dataclass(frozen=True)
class Tool:
    """A tool that runs.

    Attributes:
        name: of its package.
        requirement: what pip installs.
        settings: how many seeds of each law run, by the setting's name.
        libraries: whose versions are told.
    """

    name: str
    requirement: str
    settings: dict[str, int]
    libraries: tuple[str, ...]

    @property
    def script(self) -> Path:
        """What runs in the tool's environment."""
        return HERE / f"with_{self.name}.py"


TOOLS = (
    Tool("elastocal", str(SOURCE), {"default": 20, "best": 20}, ("numpy", "scipy")),
    Tool(
        "figaroh",
        "figaroh==1.0.2",
        {"default": 20, "best": 20, "tolerances": 5, "documented elastic": 5},
        ("numpy", "scipy", "pin"),
    ),
    Tool(
        "robotkinecal",
        "robotkinecal==0.1.0",
        {"default": 20, "best": 20},
        ("numpy", "roboticstoolbox-python", "spatialmath-python"),
    ),
    Tool(
        "pybotics",
        "pybotics==3.1.2",
        {"default": 20, "best": 20, "unaligned": 5, "distances": 1},
        ("numpy", "scipy"),
    ),
)


def lines_of_user_code(script: Path, setting: str) -> int:
    """Lines between `# user code: SETTING, …` and `# end of user code`.

    Blank lines, comments and the import of this benchmark's own module are not counted.

    Raises:
        ValueError: a part that is opened in another, or never closed.
    """
    count, counted, inside = 0, False, False
    for line in script.read_text(encoding="utf-8").splitlines():
        text = line.strip()
        if text.startswith(BEGIN):
            if inside:
                raise ValueError(f"{script.name}: {text!r} opens inside another part")
            inside, counted = True, setting in [name.strip() for name in text.removeprefix(BEGIN).split(",")]
        elif text == END:
            inside = counted = False
        elif counted and text and not text.startswith(("#", GLUE)):
            count += 1
    if inside:
        raise ValueError(f"{script.name}: a part of user code is not closed")
    return count
