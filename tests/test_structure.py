"""The shape of the code: small files, functions that fit a screen, layers that the folder listing shows."""

from __future__ import annotations

import ast
import statistics
from pathlib import Path

SOURCE = Path(__file__).parents[1] / "src" / "elastocal"
FILES = sorted(SOURCE.rglob("*.py"))


def bodies(path: Path) -> dict[str, int]:
    """Lines of each function's body, without its docstring."""
    found = {}
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef):
            body = node.body[1:] if ast.get_docstring(node) is not None else node.body
            found[f"{path.relative_to(SOURCE)}:{node.name}"] = body[-1].end_lineno - body[0].lineno + 1 if body else 0
    return found


def test_no_file_is_over_400_lines():
    assert [str(path) for path in FILES if len(path.read_text(encoding="utf-8").splitlines()) > 400] == []


def test_no_function_is_over_60_lines_and_half_are_under_10():
    sizes = {name: size for path in FILES for name, size in bodies(path).items()}
    assert {name: size for name, size in sizes.items() if size > 60} == {}
    assert statistics.median(sizes.values()) < 10


def test_every_public_name_is_there():
    import elastocal

    assert [name for name in elastocal.__all__ if not callable(getattr(elastocal, name))] == []
