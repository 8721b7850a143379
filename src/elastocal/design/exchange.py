"""The exchange algorithm: poses of a choice for others, as long as the criterion rises.

Fedorov's exchange (1972) on a shortlist (Mitchell's DETMAX, 1974; Atkinson and Donev's KL exchange, 1989): to first
order all candidates are compared, and of the most promising ones every exchange with every chosen pose is computed.
"""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.linalg import solve_triangular

from elastocal.chain import Array
from elastocal.design.criteria import Criterion
from elastocal.design.rules import Chosen, Rules, random_choice
from elastocal.identification.threads import one_thread
from elastocal.parallel import in_order

ACTIVE, OF_EACH_BIN = 800, 30
"""Candidates looked at between two looks at all of them, and how many of each bin of loads at least."""

ENTERING, ENTERING_OF_EACH_BIN = 60, 3
"""Candidates whose every exchange is computed, of those looked at."""

STEPS = 25
"""Exchanges between two looks at all candidates."""

LEAST_GAIN = 1e-7
"""An exchange that raises the score by less is none."""

GREEDY = 1500
"""Candidates, drawn at random, that a choice is built up from."""

RIDGE = 1e-8
"""Information that is taken for granted, relative to that of one candidate: so that too few poses can be compared."""


@dataclass(frozen=True)
class Pool:
    """Candidates and what an exchange needs to know of them.

    Attributes:
        rows: (channels, p, n) what each tells; (views, channels, p, n) where it is told in several views.
        known: (p, p) normal matrix of what is known before; (views, p, p).
        rules: what a choice must keep to.
    """

    rows: Array
    known: Array
    rules: Rules

    def gram(self, chosen: Chosen) -> Array:
        """Normal matrix (p, p), or (views, p, p), of a choice and of what is known, with a ridge."""
        rows = np.moveaxis(self.rows[..., chosen], -3, -2)
        rows = rows.reshape(*rows.shape[:-2], -1)  # (p, channels x chosen)
        return self.known + rows @ rows.swapaxes(-1, -2) + self.ridge * np.eye(rows.shape[-2])

    @property
    def views(self) -> tuple[Pool, ...]:
        """The pool in each of its views."""
        if self.rows.ndim == 3:
            return (self,)
        return tuple(Pool(rows, known, self.rules) for rows, known in zip(self.rows, self.known, strict=True))

    @property
    def first(self) -> Pool:
        """The pool in its first view."""
        return self.views[0]

    @property
    def ridge(self) -> float:
        """What is added to the diagonal."""
        channels, _, n = self.rows.shape[-3:]
        some = self.rows[..., :: max(1, n // 500)]
        return RIDGE * channels * float((some**2).mean())


def exchange(pool: Pool, criterion: Criterion, start: Chosen, least_gain: float = LEAST_GAIN) -> Chosen:
    """Exchange poses of a choice that keeps to the rules until none is better.

    Args:
        pool: what there is to choose from.
        criterion: whose score rises.
        start: the choice to begin with.
        least_gain: of the score, by one exchange.
    """
    chosen = start.copy()
    while True:
        gram = pool.gram(chosen)
        active = _most_promising(pool, criterion.slope(gram), pool.rules.free, ACTIVE, OF_EACH_BIN)
        for step in range(STEPS):
            found = _best_exchange(pool, criterion, gram, chosen, active)
            if found is None or found[2] < least_gain:
                if step == 0:
                    return chosen
                break
            chosen[found[0]] = found[1]
            gram = pool.gram(chosen)


def _best_exchange(
    pool: Pool, criterion: Criterion, gram: Array, chosen: Chosen, active: Chosen
) -> tuple[int, int, float] | None:
    """Which of the chosen to exchange for which candidate, and what it gains; None if none is allowed."""
    lone = active[~(pool.rules.near(chosen, active).sum(axis=0) > 1)]  # near two of them: no exchange is allowed
    entering = _most_promising(pool, criterion.slope(gram), lone, ENTERING, ENTERING_OF_EACH_BIN)
    if not len(entering):
        return None
    allowed = pool.rules.allowed(chosen, entering)
    gains = criterion.exchanged(gram, pool.rows[..., chosen], pool.rows[..., entering])
    gains = np.where(allowed, gains, -np.inf)
    out, come = np.unravel_index(int(np.argmax(gains)), gains.shape)
    if not np.isfinite(gains[out, come]):
        return None
    return int(out), int(entering[come]), float(gains[out, come])


def _most_promising(pool: Pool, slope: Array, among: Chosen, most: int, of_each_bin: int) -> Chosen:
    """The candidates that raise the score most to first order, and the best in each bin of loads."""
    if len(among) <= most:
        return among
    promise = _promise(pool, slope, among)
    best = [np.argpartition(-promise, most)[:most]]
    for bins, least in zip(pool.rules.bins[:, among], pool.rules.least, strict=True):
        for number in np.flatnonzero(least).tolist():
            mine = np.flatnonzero(bins == number)
            best.append(mine[np.argsort(-promise[mine])[:of_each_bin]])
    return among[np.unique(np.concatenate(best))]


def _promise(pool: Pool, slope: Array, among: Chosen) -> Array:
    """Tr(J slope Jᵀ) of candidates, (among,)."""
    everything = len(among) == pool.rows.shape[-1]
    rows = pool.rows if everything else pool.rows[..., among]
    return np.einsum("...pn,...pn->...n", rows, slope[..., None, :, :] @ rows).reshape(-1, len(among)).sum(axis=0)


def greedy_choice(pool: Pool, count: int, rng: np.random.Generator, start: Chosen | None = None) -> Chosen:
    """A choice built up pose by pose, each the one of a random few that raises the determinant most.

    Raises:
        InputError: no choice that keeps to the rules is found.
    """
    rules = pool.rules
    chosen = np.empty(0, dtype=np.intp) if start is None else start
    among = rng.permutation(rules.free)[:GREEDY]
    while len(chosen) < count:
        among = among[~rules.near(chosen, among).any(axis=0)]
        wanting = rules.wanting(chosen)
        # bins are filled as soon as there are no more poses left than they lack
        lacking = int(np.clip(rules.least - rules.counts(chosen), 0, None).sum(axis=1).max(initial=0))
        left = among[wanting[among]] if lacking >= count - len(chosen) else among
        if not len(left):
            return random_choice(rules, count, rng, chosen) if not wanting.any() else random_choice(rules, count, rng)
        first = pool.first  # of several views one will do to begin with
        root = np.linalg.cholesky(first.gram(chosen))
        c, p, _ = first.rows.shape
        rows = first.rows[:, :, left].transpose(1, 0, 2).reshape(p, -1)
        seen = solve_triangular(root, rows, lower=True).reshape(p, c, -1)
        grown = np.eye(c) + np.einsum("pan,pbn->nab", seen, seen)
        chosen = np.append(chosen, left[np.argmax(np.linalg.det(grown))])
    if rules.wanting(chosen).any():
        return random_choice(rules, count, rng)
    return chosen


def best_choice(
    pool: Pool,
    criterion: Criterion,
    count: int,
    starts: int,
    rng: np.random.Generator,
    executor: Executor | None = None,
) -> Chosen:
    """The best of several exchanges, the first from a greedy start and the others from random ones.

    On an executor the exchanges run side by side; the choice is the same.

    Raises:
        InputError: no choice that keeps to the rules is found.
    """
    begins = [
        random_choice(pool.rules, count, rng) if number else greedy_choice(pool, count, rng) for number in range(starts)
    ]
    found = list(in_order(partial(_exchanged, pool, criterion), begins, executor, chunk=1))
    return max(found, key=lambda chosen: criterion.score(pool.gram(chosen)))


@one_thread
def _exchanged(pool: Pool, criterion: Criterion, begin: Chosen) -> Chosen:
    """An exchange, in a worker."""
    return exchange(pool, criterion, begin)
