"""Transition torques found as asked for: searched exactly, by genetic algorithm, or given."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import Executor

from elastocal.identification.transition.genetic import GeneticSearch, search_genetically
from elastocal.identification.transition.request import Transition
from elastocal.identification.transition.search import Search, search_exactly
from elastocal.identification.transition.trial import Problem, fit_at


def find_torques(
    problem: Problem,
    transition: Transition,
    given: Mapping[str, float],
    seed: int = 0,
    on_generation: Callable[[int, int], None] | None = None,
    executor: Executor | None = None,
) -> tuple[Problem, Search | None]:
    """The problem at the fit with the transition torques found, and how they were; None where there are none to find.

    Args:
        problem: at the fit with linear laws.
        transition: how to find them.
        given: instead, the torques by element.
        seed: of all chance.
        on_generation: called with the number of generations done and of all.
        executor: where the fits of a generation run; None: here.

    Raises:
        EquilibriumError: the robot does not settle.
    """
    if not problem.laws:
        return problem, None
    if given:
        trial, search = fit_at(problem, given, given=True), Search("given", proven=False, fits=1)
    elif transition == "exact":
        trial, search = search_exactly(problem, seed)
    else:
        settings = transition if isinstance(transition, GeneticSearch) else GeneticSearch()
        trial, search = search_genetically(problem, settings, seed, on_generation, executor)
    return problem.after(trial), search
