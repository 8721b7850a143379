"""How good a choice of poses is: the observability indices O1 to O5, and the accuracy that it leads to.

All are functions of the normal matrix M = Σ JᵀJ of the chosen poses; its eigenvalues are the squared singular values of
their Jacobian. A score is the logarithm of an index, so that more is better and differences are relative.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.linalg import cholesky, eigvalsh, inv, solve_triangular

from elastocal.chain import Array
from elastocal.errors import InputError, unknown_name

CRITERIA = ("O1", "O2", "O3", "O4", "O5", "accuracy")

SOFT = 4.0
"""Exponent with which small eigenvalues share in the slope of the smallest: a pose that helps the smallest alone helps
only until the next one is smallest."""

TRIED = 100
"""Exchanges whose effect on eigenvalues is computed, of those that promise most to first order."""

LOST = 1e-12
"""A determinant below this is that of a choice that no longer tells every parameter."""


class Criterion(Protocol):
    """What an exchange of poses needs to know of an index."""

    def score(self, gram: Array) -> float:
        """The score of a normal matrix (p, p)."""

    def slope(self, gram: Array) -> Array:
        """(p, p), so that one more pose J raises the score by tr(J slope Jᵀ) to first order."""

    def exchanged(self, gram: Array, leave: Array, enter: Array) -> Array:
        """Scores, less the present one, with one pose of `leave` (channels, p, k) for one of `enter` (…, m), (k, m)."""


def criterion_of(name: str, wanted: Array) -> Criterion:
    """A criterion by name.

    Args:
        name: of CRITERIA.
        wanted: (p, p) mean of JᵀJ over the workspace, J of the target's position.

    Raises:
        InputError: there is no such criterion.
    """
    if name not in CRITERIA:
        raise InputError(unknown_name("criterion", name, CRITERIA))
    if name == "O1":
        return Determinant()
    if name == "accuracy":
        values, vectors = np.linalg.eigh(wanted)
        return Accuracy(vectors * np.sqrt(np.clip(values, 0.0, None)))
    return Spectrum(name)


def _blocks(one: Array, other: Array) -> Array:
    """Oneᵀ other for every pose, (n, channels, channels) of two (p, channels, n)."""
    return np.einsum("pan,pbn->nab", one, other)


class _Swaps:
    """Removing a pose after another was added, by rank-c updates of M⁻¹; c channels, k poses leave, m may enter.

    Attributes:
        grown: (m, c, c) I + D of those that enter, D = J M⁻¹ Jᵀ.
        left: (k, m, c, c) I − D of those that leave, once the other has entered.
        whitened: (p, c, m) of those that enter, so that their D with those that leave is one product, `shared`.
        shared: (k, m, c, c).
    """

    def __init__(self, gram: Array, leave: Array, enter: Array) -> None:
        root: Array = cholesky(gram, lower=True)
        self.root = root
        self.leaving, self.entering = _solved(root, leave), _solved(root, enter)
        unit = np.eye(len(leave))
        self.grown = unit + _blocks(self.entering, self.entering)
        factor = np.linalg.inv(np.linalg.cholesky(self.grown))  # its rows whiten the pose that enters
        self.whitening = factor
        self.whitened = np.einsum("nab,pbn->pan", factor, self.entering)
        p, c, k = self.leaving.shape
        m = self.entering.shape[2]
        product = self.leaving.transpose(2, 1, 0).reshape(k * c, p) @ self.whitened.reshape(p, c * m)
        self.shared = product.reshape(k, c, c, m).transpose(0, 3, 1, 2)
        before = unit - _blocks(self.leaving, self.leaving)
        self.left = before[:, None] + self.shared @ self.shared.swapaxes(2, 3)


def _solved(root: Array, rows: Array) -> Array:
    """Root⁻¹ Jᵀ of rows (c, p, n), as (p, c, n)."""
    c, p, n = rows.shape
    return solve_triangular(root, rows.transpose(1, 0, 2).reshape(p, c * n), lower=True).reshape(p, c, n)


@dataclass(frozen=True)
class Determinant:
    """O1: the mean logarithm of the singular values, up to a constant (D-optimality)."""

    def score(self, gram: Array) -> float:
        """See Criterion."""
        return float(np.linalg.slogdet(gram)[1] / (2.0 * len(gram)))

    def slope(self, gram: Array) -> Array:
        """See Criterion."""
        inverse: Array = inv(gram)
        return inverse / (2.0 * len(gram))

    def exchanged(self, gram: Array, leave: Array, enter: Array) -> Array:
        """See Criterion: det(I + D_in) det(I − D_out + …), a matrix of the channels' size each."""
        swaps = _Swaps(gram, leave, enter)
        ratio = np.linalg.det(swaps.grown) * np.linalg.det(swaps.left)
        return np.log(np.clip(ratio, LOST, None)) / (2.0 * len(gram))


@dataclass(frozen=True)
class Accuracy:
    """The predicted position's root mean square deviation over the workspace (I-optimality); `root` rootᵀ is its L.

    With C the parameters' covariance it is √tr(C L), L the mean of JᵀJ over the workspace.
    """

    root: Array

    def score(self, gram: Array) -> float:
        """See Criterion."""
        return -0.5 * float(np.log(np.trace(self.root.T @ np.linalg.solve(gram, self.root))))

    def slope(self, gram: Array) -> Array:
        """See Criterion."""
        solved = np.linalg.solve(gram, self.root)
        return solved @ solved.T / (2.0 * np.trace(self.root.T @ solved))

    def exchanged(self, gram: Array, leave: Array, enter: Array) -> Array:
        """See Criterion: what one pose takes off the trace, less what the other had taken."""
        swaps = _Swaps(gram, leave, enter)
        seen = np.linalg.solve(swaps.root, self.root).T  # L's root, in the coordinates where M is the identity
        p, c, k = swaps.leaving.shape
        m = swaps.whitened.shape[2]
        leaving = (seen @ swaps.leaving.reshape(p, c * k)).reshape(p, c, k)
        entering = (seen @ swaps.whitened.reshape(p, c * m)).reshape(p, c, m)
        gained = np.einsum("pan,pan->n", entering, entering)
        crossed = (leaving.transpose(2, 1, 0).reshape(k * c, p) @ entering.reshape(p, c * m)).reshape(k, c, c, m)
        crossed = crossed.transpose(0, 3, 1, 2) @ swaps.shared.swapaxes(2, 3)
        both = swaps.shared @ _blocks(entering, entering) @ swaps.shared.swapaxes(2, 3)
        lost = _blocks(leaving, leaving)[:, None] - crossed - crossed.swapaxes(2, 3) + both
        sound = np.linalg.det(swaps.left) > LOST
        inverse = np.linalg.inv(np.where(sound[..., None, None], swaps.left, np.eye(c)))
        before = float((seen**2).sum())
        after = before - gained + np.einsum("kmab,kmba->km", inverse, lost)
        return np.where(sound, -0.5 * np.log(np.clip(after / before, LOST, None)), -np.inf)


@dataclass(frozen=True)
class Averaged:
    """The mean score over several views of the same poses, as with the target at several places.

    Attributes:
        views: the criterion in each; rows and normal matrices have the views as their first axis.
    """

    views: tuple[Criterion, ...]

    def score(self, gram: Array) -> float:
        """See Criterion, of (views, p, p)."""
        return float(np.mean([view.score(each) for view, each in zip(self.views, gram, strict=True)]))

    def slope(self, gram: Array) -> Array:
        """See Criterion, (views, p, p)."""
        return np.stack([view.slope(each) for view, each in zip(self.views, gram, strict=True)]) / len(self.views)

    def exchanged(self, gram: Array, leave: Array, enter: Array) -> Array:
        """See Criterion, of (views, channels, p, k) and (views, channels, p, m)."""
        every = zip(self.views, gram, leave, enter, strict=True)
        return np.mean([view.exchanged(*each) for view, *each in every], axis=0)


@dataclass(frozen=True)
class Spectrum:
    """An index of the eigenvalues alone, ascending, by its name: its logarithm, and the derivatives by them."""

    name: str

    def score(self, gram: Array) -> float:
        """See Criterion."""
        return float(_INDICES[self.name](eigvalsh(gram)))

    def slope(self, gram: Array) -> Array:
        """See Criterion; where several eigenvalues are small, they share in the slope of the smallest."""
        values, vectors = np.linalg.eigh(gram)
        return (vectors * _SLOPES[self.name](values)) @ vectors.T

    def exchanged(self, gram: Array, leave: Array, enter: Array) -> Array:
        """See Criterion: −∞ for all exchanges but those that promise most to first order."""
        slope = self.slope(gram)
        lost, gained = (np.einsum("apn,pq,aqn->n", rows, slope, rows) for rows in (leave, enter))
        promise = gained - lost[:, None]
        best = np.argpartition(-promise.ravel(), min(TRIED, promise.size) - 1)[:TRIED]
        out, come = np.unravel_index(best, promise.shape)
        changed = gram + _grams(enter[:, :, come]) - _grams(leave[:, :, out])
        found = np.full(promise.shape, -np.inf)
        values = np.clip(np.linalg.eigvalsh(changed), LOST * np.trace(gram) / len(gram), None)
        found[out, come] = _INDICES[self.name](values) - self.score(gram)
        return found


def _grams(rows: Array) -> Array:
    """JᵀJ of each pose, (n, p, p)."""
    poses = rows.transpose(2, 1, 0)
    return poses @ poses.swapaxes(1, 2)


def _softly(values: Array) -> Array:
    """Shares of the eigenvalues in the slope of log of the smallest."""
    shares = (values[0] / values) ** SOFT
    return shares / shares.sum() / values


def _largest(values: Array) -> Array:
    return np.where(np.arange(len(values)) == len(values) - 1, 1.0 / values, 0.0)


_INDICES: dict[str, Callable[[Array], Array]] = {
    "O2": lambda v: 0.5 * np.log(v[..., 0] / v[..., -1]),
    "O3": lambda v: 0.5 * np.log(v[..., 0]),
    "O4": lambda v: np.log(v[..., 0]) - 0.5 * np.log(v[..., -1]),
    "O5": lambda v: -np.log((1.0 / np.sqrt(v)).sum(axis=-1)),
}

_SLOPES: dict[str, Callable[[Array], Array]] = {
    "O2": lambda v: 0.5 * (_softly(v) - _largest(v)),
    "O3": lambda v: 0.5 * _softly(v),
    "O4": lambda v: _softly(v) - 0.5 * _largest(v),
    "O5": lambda v: 0.5 * v**-1.5 / (1.0 / np.sqrt(v)).sum(),
}
