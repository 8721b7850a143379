"""The search by genetic algorithm, as the nonlinear joint stiffness paper does it."""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from elastocal.errors import EquilibriumError
from elastocal.identification.threads import one_thread
from elastocal.identification.transition.search import Search
from elastocal.identification.transition.trial import Problem, Trial, fit_at, polished
from elastocal.parallel import in_order

OnGeneration = Callable[[int, int], None]


@dataclass(frozen=True)
class GeneticSearch:
    """How a genetic algorithm searches: how many combinations a generation has, and how many generations there are."""

    population: int = 40
    generations: int = 50


def search_genetically(
    problem: Problem,
    settings: GeneticSearch,
    seed: int = 0,
    on_generation: OnGeneration | None = None,
    executor: Executor | None = None,
) -> tuple[Trial, Search]:
    """Breed combinations of transition torques; the fitness is the residual of the full iteration.

    The allowed torques and the rule for the sides are those of the exact search. The torques of hinges are then moved
    to where they fit best nearby.

    Args:
        problem: at the fit with linear laws.
        settings: size of the search.
        seed: of all chance.
        on_generation: called with the number of generations done and of all.
        executor: where the fits of a generation run; None: here.

    Raises:
        EquilibriumError: the robot settles with none of the combinations.
    """
    # imported late: it takes longer than the exact search
    from pymoo.algorithms.soo.nonconvex.ga import GA
    from pymoo.core.problem import Problem as Searched
    from pymoo.operators.crossover.sbx import SBX
    from pymoo.operators.mutation.pm import PM
    from pymoo.operators.repair.rounding import RoundingRepair
    from pymoo.operators.sampling.rnd import IntegerRandomSampling
    from pymoo.optimize import minimize

    began = time.perf_counter()
    counts = np.array([len(grid.torques) for grid in problem.grids.values()])
    history: list[float] = []
    fits = 0

    misfit = partial(_misfit, problem)

    class Fitness(Searched):  # type: ignore[misc]
        def _evaluate(self, combinations: Any, out: dict[str, Any], *_: Any, **__: Any) -> None:
            nonlocal fits
            fits += len(combinations)
            out["F"] = np.array(list(in_order(misfit, list(combinations), executor)))

    def record(algorithm: Any) -> None:
        history.append(float(algorithm.pop.get("F").min()))
        if on_generation is not None:
            on_generation(len(history), settings.generations)

    result = minimize(
        Fitness(n_var=len(counts), n_obj=1, xl=0, xu=counts - 1, vtype=int),
        GA(
            pop_size=settings.population,
            sampling=IntegerRandomSampling(),
            crossover=SBX(prob=0.9, eta=3.0, vtype=float, repair=RoundingRepair()),
            mutation=PM(prob=0.9, eta=3.0, vtype=float, repair=RoundingRepair()),
            eliminate_duplicates=True,
        ),
        ("n_gen", settings.generations),
        seed=seed,
        callback=record,
    )
    best = polished(problem, fit_at(problem, problem.torques_of(result.X)))
    history = [float(np.sqrt(misfit / problem.misfit)) for misfit in history]
    return best, Search("ga", False, fits, tuple(history), time.perf_counter() - began)


@one_thread
def _misfit(problem: Problem, combination: Any) -> float:
    try:
        return fit_at(problem, problem.torques_of(combination)).misfit
    except EquilibriumError:
        return float("inf")
