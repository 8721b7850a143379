"""Names of what can be reproduced, and its reproduction."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from elastocal.errors import InputError, unknown_name
from elastocal.identification import GeneticSearch
from elastocal.reproduction.ha006 import SEED, experiment
from elastocal.reproduction.nonlinear_stiffness import GENETIC, RUNGS, Ladder, Rung, run_ladder
from elastocal.reproduction.stiffness_analysis import CASES, Case, CaseRun, run_case

GROUPS = {
    "stiffness": "joint-stiffness-analysis",
    "joint-stiffness-analysis": "joint-stiffness-analysis",
    "nonlinear": "nonlinear-joint-stiffness",
    "nonlinear-joint-stiffness": "nonlinear-joint-stiffness",
}
"""Names of whole papers."""


@dataclass(frozen=True)
class Selection:
    """What is to be reproduced: cases of one paper, rungs of the other."""

    cases: tuple[Case, ...] = CASES
    rungs: tuple[Rung, ...] = RUNGS


@dataclass(frozen=True)
class Reproduction:
    """What was reproduced, with which seed; `ladder` is None where nothing of its paper was asked for."""

    cases: tuple[CaseRun, ...]
    ladder: Ladder | None
    seed: int

    @property
    def converged(self) -> bool:
        """Whether every fit came to rest on parameters that the data tell."""
        results = [run.result for run in self.cases] + [run.result for run in (self.ladder.runs if self.ladder else ())]
        return all(result.status == "converged" for result in results)


def select(names: Sequence[str]) -> Selection:
    """What the names mean; all without any. A-1 and a-1 are two cases, and their dash may be left out.

    Raises:
        InputError: names that mean nothing.
    """
    if not names:
        return Selection()
    faults = [unknown_name("case", name, _valid()) for name in names if not list(_meant(name))]
    if faults:
        raise InputError(*faults)
    meant = [found for name in names for found in _meant(name)]
    return Selection(tuple(c for c in CASES if c in meant), tuple(r for r in RUNGS if r in meant))


def _valid() -> tuple[str, ...]:
    return (*(case.name for case in CASES), "stiffness", *(rung.name for rung in RUNGS), "nonlinear")


def _meant(name: str) -> Iterator[Case | Rung]:
    """The cases or rungs of a name, none if it means nothing."""
    group = GROUPS.get(name)
    for case in CASES:
        if name in (case.name, case.name.replace("-", "")) or group == "joint-stiffness-analysis":
            yield case
    for rung in RUNGS:
        if name == rung.name or group == "nonlinear-joint-stiffness":
            yield rung


def reproduce(
    selection: Selection | None = None,
    *,
    non_negative: bool = False,
    genetic: GeneticSearch = GENETIC,
    seed: int = SEED,
) -> Reproduction:
    """Simulate and calibrate what is selected; nothing is stored but the inputs.

    Args:
        selection: of cases; None: all.
        non_negative: keep compliances from going below zero.
        genetic: settings of the genetic algorithm.
        seed: of the simulated HA006, its poses and noise, and of the genetic algorithm.
    """
    selection = selection or Selection()
    cases = tuple(run_case(case, non_negative) for case in selection.cases)
    if not selection.rungs:
        return Reproduction(cases, None, seed)
    ladder = run_ladder(experiment(seed), selection.rungs, non_negative=non_negative, genetic=genetic, seed=seed)
    return Reproduction(cases, ladder, seed)
