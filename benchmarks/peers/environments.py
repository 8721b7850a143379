"""A virtual environment for each tool."""

from __future__ import annotations

import hashlib
import json
import subprocess
import sys
import venv
from dataclasses import dataclass
from pathlib import Path

from tools import SOURCE, Tool

ASK = "import sys, importlib.metadata as m; print(*map(m.version, sys.argv[1:]))"
"""Python that prints the versions of the packages it is given."""


@dataclass(frozen=True)
class Environment:
    """Where a tool is installed.

    Attributes:
        python: its interpreter.
        mark: of what is installed; results of another mark are not used again.
        versions: by package.
        error: why there is none; empty if there is.
    """

    python: Path
    mark: str
    versions: dict[str, str]
    error: str = ""


def environment(tool: Tool, folder: Path) -> Environment:
    """Install the tool unless it is there; a failure is a value."""
    python = folder / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
    mark = f"{tool.requirement}, Python {sys.version.split()[0]}"
    if tool.requirement == str(SOURCE):
        mark = f"{mark}, source {_hash_of_source()}"
    stored = folder / "installed.json"
    if stored.exists() and json.loads(stored.read_text(encoding="utf-8"))["mark"] == mark:
        return Environment(python, mark, json.loads(stored.read_text(encoding="utf-8"))["versions"])
    print(f"installing {tool.name} …", flush=True)
    venv.create(folder, with_pip=True, clear=True)
    command = [str(python), "-m", "pip", "--disable-pip-version-check", "--quiet", "install", tool.requirement]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        return Environment(python, mark, {}, "\n".join(done.stderr.strip().splitlines()[-5:]))
    names = (tool.name, *tool.libraries)
    asked = subprocess.run([str(python), "-c", ASK, *names], capture_output=True, text=True, check=True)
    versions = dict(zip(names, asked.stdout.split(), strict=True))
    stored.write_text(json.dumps({"mark": mark, "versions": versions}), encoding="utf-8")
    return Environment(python, mark, versions)


def _hash_of_source() -> str:
    """Of the package's files, in this tree."""
    digest = hashlib.sha256()
    for path in sorted((SOURCE / "src").rglob("*")):
        if path.suffix in (".py", ".toml"):
            digest.update(path.read_bytes())
    return digest.hexdigest()[:12]
