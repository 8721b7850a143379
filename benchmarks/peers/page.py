"""docs/benchmarks.md, from the results alone."""

from __future__ import annotations

import math
import statistics
from collections.abc import Iterable, Sequence
from textwrap import fill

from runs import Result
from summary import LAWS, cell, failures, median_seconds, notes, of_setting, worsened
from texts import BELOW, CAPABILITIES, CAVEAT, HOW, INTRODUCTION
from tools import TOOLS, lines_of_user_code

MAIN = ("best", "default")
WIDTH = 112
UNBROKEN = {"break_long_words": False, "break_on_hyphens": False}


def page(results: Sequence[Result], versions: dict) -> str:
    """The page."""
    others = [(tool.name, setting) for tool in TOOLS for setting in tool.settings if setting not in MAIN]
    main = [(tool.name, setting) for setting in MAIN for tool in TOOLS]
    parts = [
        INTRODUCTION.format(date=versions["date"], python=versions["python"], machine=versions["machine"]),
        "## Error at held-out poses\n\n" + _errors(results, [*main, ("nominal", "aligned")]),
        "![Held-out error by arm and tool](images/benchmarks.svg)",
        "## What it says\n\n" + _said(results),
        CAVEAT,
        "## Time and code\n\n" + _effort(results, main),
        "## How each was run\n\n" + HOW,
        "## What failed, and why\n\n" + _failed(results),
        "## Other settings\n\n" + _others(results, others),
        "## What else there is\n\n" + CAPABILITIES,
        "## Versions\n\n" + _versions(versions),
    ]
    return "\n\n".join(part.strip() for part in parts) + "\n"


def _table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _number(value: float) -> str:
    """Two or three digits; metres where millimetres would be many."""
    if not math.isfinite(value):
        return "–"
    if value >= 100.0:
        return f"{value / 1e3:.2g} m"
    return f"{value:.3f}" if value < 1.0 else f"{value:.2f}"


def _errors(results: Sequence[Result], settings: Iterable[tuple[str, str]]) -> str:
    rows = []
    for tool, setting in settings:
        cells = [cell(results, tool, setting, law) for law in LAWS]
        shown = [f"{_number(c.mean)} / {_number(c.worst)}" for c in cells]
        rows.append([f"**{tool}**" if tool == "elastocal" else tool, setting, *shown])
    rows[-1][:2] = ["not calibrated", "aligned"] if rows[-1][0] == "nominal" else rows[-1][:2]
    return f"{_table(['tool', 'setting', *LAWS], rows)}\n\n{BELOW['errors']}"


def _said(results: Sequence[Result]) -> str:
    """The findings, each with its figures."""

    def best(tool: str, law: str) -> float:
        return cell(results, tool, "best", law).mean

    names = [tool.name for tool in TOOLS]
    rigid = sorted(best(name, "rigid") for name in names)
    ends = dict.fromkeys(f"{end:.3f}" for end in (rigid[0], rigid[-1]))
    chosen = of_setting(results, "elastocal", "best")
    right = sum(r.note == f"recommended: {r.law}" for r in chosen)
    step = [r.largest for r in chosen if r.law == "step"]
    rigid_fit = min(best(name, "linear") for name in ("robotkinecal", "pybotics"))
    said = (
        "**Rigid arms need no particular tool.** At their best all four predict to "
        f"{' to '.join(ends)} mm: what is left is the noise. As they come they differ.",
        "**Springs in proportion to the load: FIGAROH is as good as elastocal**, "
        f"{best('figaroh', 'linear'):.3f} mm beside {best('elastocal', 'linear'):.3f} mm, with a work-around that its "
        f"documents do not have. Without a model of compliance {rigid_fit:.2f} mm are left.",
        "**Springs that stiffen are modelled by elastocal alone.** A linear spring, FIGAROH's best, leaves "
        f"{best('figaroh', 'step') / best('elastocal', 'step'):.1f} times the error on arms with a step and "
        f"{best('figaroh', 'hinge') / best('elastocal', 'hinge'):.1f} times on arms with a kink.",
        "elastocal is not told the law: `compare` recommended the right one of five for "
        f"{right} of {len(chosen)} arms. It is told, as FIGAROH is, that joints 2 and 3 may give way.",
        f"A step's largest errors, {statistics.median(step):.2f} mm in the median arm, are those of held-out poses "
        "whose load lies between the two fitted loads around the transition torque: 60 poses do not tell on which "
        "side they are.",
        "elastocal as it comes is rigid: on arms that give way it is no better than the others' rigid fits.",
    )
    return "\n".join(fill(f"- {sentence}", WIDTH, subsequent_indent="  ", **UNBROKEN) for sentence in said)


def _effort(results: Sequence[Result], settings: Iterable[tuple[str, str]]) -> str:
    scripts = {tool.name: tool.script for tool in TOOLS}
    rows = []
    for tool, setting in settings:
        fit, process = median_seconds(of_setting(results, tool, setting))
        rows.append([tool, setting, f"{fit:.2f}", f"{process:.1f}", str(lines_of_user_code(scripts[tool], setting))])
    header = ["tool", "setting", "fit [s]", "process [s]", "lines of user code"]
    return f"{_table(header, rows)}\n\n{BELOW['effort']}"


def _failed(results: Sequence[Result]) -> str:
    rows = []
    for tool in TOOLS:
        for setting in tool.settings:
            found = of_setting(results, tool.name, setting)
            for note, count in sorted(failures(found).items()):
                rows.append([tool.name, setting, f"{count} of {len(found)}", f"no result: {note}"])
            for note, count in sorted(notes(found).items()):
                if not note.startswith("recommended"):
                    rows.append([tool.name, setting, f"{count} of {len(found)}", note])
            if worse := worsened(results, tool.name, setting):
                rows.append([tool.name, setting, f"{worse} of {len(found)}", "worse than not calibrated"])
    table = _table(["tool", "setting", "arms", "what"], rows) if rows else "Nothing failed."
    return f"{table}\n\n{BELOW['failed']}"


def _others(results: Sequence[Result], settings: Sequence[tuple[str, str]]) -> str:
    rows = []
    for tool, setting in settings:
        found = of_setting(results, tool, setting)
        means = [_number(cell(results, tool, setting, law).mean) for law in LAWS]
        seconds = median_seconds(found)[0]
        rows.append([tool, setting, f"{len(found) // len(LAWS)}", *means, f"{seconds:.1f}"])
    header = ["tool", "setting", "arms of each kind", *LAWS, "fit [s]"]
    return f"{_table(header, rows)}\n\n{BELOW['others']}"


def _versions(versions: dict) -> str:
    rows = []
    for name, found in versions["tools"].items():
        own, *libraries = found["versions"].items() or [(name, f"not installed: {found['error']}")]
        rows.append([name, own[1], ", ".join(f"{library} {version}" for library, version in libraries)])
    return _table(["tool", "version", "with"], rows)
