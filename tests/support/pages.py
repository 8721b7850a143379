"""Pages of the documents: the examples on them, run in order, and their shown output against the real one.

ELASTOCAL_UPDATE_DOCS=1 writes the real numbers into the pages, where nothing else differs; then read the prose about
them.
"""

from __future__ import annotations

import os
import re
import subprocess
from collections.abc import Iterator
from contextlib import chdir, redirect_stdout
from dataclasses import dataclass, field
from io import StringIO
from itertools import pairwise
from pathlib import Path
from typing import Any

from markdown_it import MarkdownIt

from support.files import Desk

ELLIPSIS = "…"
"""A line of shown output that stands for any lines."""

NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")

TITLE = re.compile(r'^(toml|csv) title="([\w./-]+)"$')

NOT_RUN = re.compile(r"python -m pip install |python docs/pictures\.py|mkdocs |elastocal serve|python -m pytest")
"""What a block of the language `sh` may hold: it installs, serves or builds."""


@dataclass(frozen=True)
class Block:
    """A fenced block of a page: its language and title, its text, and the line that it starts at."""

    info: str
    text: str
    line: int


def blocks(page: Path) -> list[Block]:
    """All fenced blocks of a Markdown file."""
    tokens = MarkdownIt().parse(page.read_text(encoding="utf-8"))
    return [
        Block(token.info.strip(), token.content, token.map[0] + 1)
        for token in tokens
        if token.type == "fence" and token.map is not None
    ]


@dataclass
class Reader:
    """Somebody who follows a page in an empty folder, to the letter."""

    folder: Path
    names: dict[str, Any] = field(default_factory=dict)
    printed: str = ""
    status: int = 0
    changes: list[tuple[str, str]] = field(default_factory=list)

    def follow(self, page: Path) -> None:
        """Do what every block says.

        Raises:
            AssertionError: an example does not end well, or does not print what is shown.
        """
        for block in blocks(page):
            try:
                self.do(block)
            except Exception as error:
                raise AssertionError(f"{page.name}, line {block.line}: {error}") from error
        if self.changes:
            text = page.read_text(encoding="utf-8")
            for old, new in self.changes:
                text = text.replace(old, new, 1)
            page.write_text(text, encoding="utf-8")
        assert self.status == 0, f"{page.name}: the last command ended with {self.status}"

    def do(self, block: Block) -> None:
        """Run, write or compare one block."""
        if titled := TITLE.match(block.info):
            path = self.folder / titled[2]
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(block.text, encoding="utf-8")
        elif block.info == "console":
            for command, shown in commands(block.text):
                self.command(command, shown)
        elif block.info == "python":
            self.python(block)
        elif block.info == "text":
            self.compare(self.printed, block.text)
        elif block.info == "sh":
            other = [line for line in block.text.splitlines() if not NOT_RUN.match(line)]
            assert not other, f"would not be run: {other}"
        elif block.info:
            raise ValueError(f"blocks of {block.info!r} are not run: say how, in {__name__}")

    def command(self, command: str, shown: str) -> None:
        """Run a command line and compare what it prints, on standard output and then on standard error."""
        if command == "echo $?":
            assert shown.strip() == str(self.status)
            self.status = 0
            return
        assert self.status == 0, f"ended with {self.status}, and the page does not say so"
        if command.startswith("elastocal "):
            ran = Desk(self.folder).run(command.removeprefix("elastocal "))
            self.status, found = ran.status, ran.out + ran.err
        else:
            done = subprocess.run(["bash", "-c", command], cwd=self.folder, capture_output=True, text=True, check=True)
            found = done.stdout
        self.compare(found, shown)

    def compare(self, found: str, shown: str) -> None:
        """Compare what was printed with what is shown, or note what should be shown."""
        try:
            assert_shown(found, shown)
        except AssertionError:
            if not os.environ.get("ELASTOCAL_UPDATE_DOCS"):
                raise
            self.changes.append((shown.strip("\n"), with_numbers_of(found, shown)))

    def python(self, block: Block) -> None:
        """Run a block in the names that the blocks before it have left."""
        assert self.status == 0
        out = StringIO()
        code = compile("\n" * block.line + block.text, "page", "exec")
        with chdir(self.folder), redirect_stdout(out):
            exec(code, self.names)
        self.printed = out.getvalue()


def commands(text: str) -> Iterator[tuple[str, str]]:
    """The command lines of a console block, each with what is shown below it."""
    lines = text.splitlines()
    starts = [i for i, line in enumerate(lines) if line.startswith("$ ")]
    assert starts and starts[0] == 0, "a console block starts with $ and a command"
    for start, end in pairwise([*starts, len(lines)]):
        command, rest = lines[start].removeprefix("$ "), start + 1
        while command.endswith("\\"):
            command, rest = command.removesuffix("\\") + lines[rest].strip(), rest + 1
        yield command, "\n".join(lines[rest:end])


def assert_shown(found: str, shown: str) -> None:
    """That output has the lines shown, in this order; an ellipsis alone on a line stands for any lines.

    Raises:
        AssertionError: with the lines that are missing and all of the output.
    """
    output = found.strip("\n").splitlines()
    parts = _parts(shown)
    if parts == [[]]:
        return
    at = 0
    for number, part in enumerate(parts):
        first, last = number == 0, number == len(parts) - 1
        places = range(at, len(output) - len(part) + 1)
        if first:
            places = places[:1]
        if last and part:
            places = places[-1:]
        hit = next((i for i in places if _same(output[i : i + len(part)], part)), None)
        assert hit is not None, "not printed:\n" + "\n".join(part) + "\n\nbut:\n" + found
        at = hit + len(part)
    assert not parts[-1] or at == len(output), "more is printed:\n" + "\n".join(output[at:])


def with_numbers_of(found: str, shown: str) -> str:
    """Shown lines with the numbers that were found, where words and order are the same.

    Raises:
        AssertionError: more than numbers differs.
    """
    output = [line.rstrip() for line in found.strip("\n").splitlines()]
    words = [_words(line) for line in output]
    at, result = 0, []
    for number, part in enumerate(_parts(shown)):
        wanted = [_words(line) for line in part]
        places = range(at, len(output) - len(part) + 1)
        hit = next((i for i in places if words[i : i + len(part)] == wanted), None)
        assert hit is not None, "not printed, whatever the numbers:\n" + "\n".join(part) + "\n\nbut:\n" + found
        result += ([ELLIPSIS] if number else []) + output[hit : hit + len(part)]
        at = hit + len(part)
    return "\n".join(result)


def _words(line: str) -> list[str]:
    return NUMBER.sub("#", line).replace("─", "").split()


def _parts(shown: str) -> list[list[str]]:
    """Lines between ellipses; empty ones at the ends where it starts or ends with an ellipsis."""
    parts: list[list[str]] = [[]]
    for line in shown.strip("\n").splitlines():
        if line.strip() == ELLIPSIS:
            parts.append([])
        else:
            parts[-1].append(line.rstrip())
    return parts


def _same(found: list[str], shown: list[str]) -> bool:
    return all(same_line(one.rstrip(), other) for one, other in zip(found, shown, strict=True))


def same_line(found: str, shown: str) -> bool:
    """Whether two lines have the same words and layout, and numbers that differ by one unit of the last digit at most.

    Rounding differs from machine to machine in the fifteenth digit, which now and then turns the last one that is
    printed.
    """
    if NUMBER.sub("#", found) != NUMBER.sub("#", shown):
        return False
    return all(_agree(*pair) for pair in zip(NUMBER.findall(found), NUMBER.findall(shown), strict=True))


def _agree(found: str, shown: str) -> bool:
    digits, _, power = shown.partition("e")
    unit = 10.0 ** (int(power or 0) - len(digits.partition(".")[2]))
    return len(found) == len(shown) and abs(float(found) - float(shown)) <= 1.001 * unit
