"""CPU seconds (one thread) and efficiency of choosing poses: `python benchmarks/plan.py`.

45 of 10,000 random poses of the built-in example arm, whose joints 2 to 5 give way: 31 parameters; where the target
sits on the tool is known to some 5 mm, or not at all. The efficiency is that of plans, at the place where it really
sits, against the best of 20 exchanges from random starts until none gains 1e-9, the best of which goes on to the end of
Fedorov's exchange: until of all exchanges of any chosen pose for any candidate none gains 1e-9. O1: of the determinant,
to the power 1/31; accuracy: of the expected standard deviation over the workspace. The last result is in plan.txt.
"""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
from rich.console import Console
from rich.table import Table

from elastocal.design import Reading, Request, Surroundings, choose, draw_candidates
from elastocal.design.criteria import Criterion, criterion_of
from elastocal.design.exchange import Pool, exchange
from elastocal.design.rules import random_choice, rules_of
from elastocal.design.task import task_of
from elastocal.examples import ROBOT_FILE, TARGET
from elastocal.identification.threads import one_thread
from elastocal.io import load_robot
from elastocal.robot import Frame

COUNT, CANDIDATES, LONG_RUNS = 45, 10_000, 20
ELASTIC = dict.fromkeys(("2", "3", "4", "5"), "linear")
BLOCK = 1000


@one_thread
def long_runs(pool: Pool, criterion: Criterion) -> tuple[float, float]:
    """The best score of many exchanges, carried on to the end, and the worst of them."""
    starts = [random_choice(pool.rules, COUNT, np.random.default_rng(seed)) for seed in range(LONG_RUNS)]
    runs = [exchange(pool, criterion, start, 1e-9) for start in starts]
    scores = [criterion.score(pool.gram(run)) for run in runs]
    return to_the_end(pool, criterion, runs[int(np.argmax(scores))]), min(scores)


def to_the_end(pool: Pool, criterion: Criterion, chosen: np.ndarray) -> float:
    """The score that Fedorov's exchange ends at, with every candidate for every chosen pose."""
    everything = np.arange(pool.rows.shape[2])
    while True:
        gram, best = pool.gram(chosen), (1e-9, -1, -1)
        for start in range(0, len(everything), BLOCK):
            entering = everything[start : start + BLOCK]
            gains = criterion.exchanged(gram, pool.rows[:, :, chosen], pool.rows[:, :, entering])
            gains = np.where(pool.rules.allowed(chosen, entering), gains, -np.inf)
            out, come = np.unravel_index(int(np.argmax(gains)), gains.shape)
            best = max(best, (float(gains[out, come]), int(out), int(entering[come])))
        if best[1] < 0:
            return criterion.score(gram)
        chosen[best[1]] = best[2]


def main() -> None:
    """Print seconds and efficiencies."""
    unknown, reading = load_robot(ROBOT_FILE), Reading()
    guessed = replace(unknown, tool=Frame((0.075, -0.045, 0.165)))
    actual = replace(unknown, tool=replace(TARGET, known=False))
    offered = draw_candidates(unknown, CANDIDATES, COUNT, Surroundings()).poses
    task = task_of(actual, reading.of(offered), None, ELASTIC, "exact", None, ())
    rules = rules_of(offered.q, np.full(6, 1e-3), np.empty((0, 6)), {}, {}, COUNT)
    pool = Pool(task.informed(offered, reading), np.zeros((len(task.names),) * 2), rules)
    columns = task.predicted(offered)
    wanted = np.einsum("cpn,cqn->pq", columns, columns, optimize=True) / len(offered)
    table = Table(
        "criterion", "target's place", "whole plan, CPU [s]", "efficiency", "least of 10 seeds", "worst long run"
    )
    for name in ("O1", "accuracy"):
        criterion = criterion_of(name, wanted)
        power = 2.0 if name == "O1" else 1.0
        best, worst = long_runs(pool, criterion)
        for told, robot in (("to 5 mm", guessed), ("unknown", unknown)):
            began = time.process_time()
            plans = [
                choose(robot, offered, Request(COUNT, name, elastic=ELASTIC, seed=s), None, offered) for s in range(10)
            ]
            seconds = (time.process_time() - began) / len(plans)
            scores = [criterion.score(pool.gram(plan.rows)) for plan in plans]
            efficiency = [f"{np.exp(power * (score - best)):.4f}" for score in (scores[0], min(scores), worst)]
            table.add_row(name, told, f"{seconds:.2f}", *efficiency)
    Console(width=100).print(f"{len(task.names)} parameters, {COUNT} of {CANDIDATES} candidates", table)


if __name__ == "__main__":
    main()
