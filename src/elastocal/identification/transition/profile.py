"""The misfit at every combination of transition torques at once, to first order about a fit.

A law with a transition is the linear law and an excess beyond the transition: of a step the whole load, of a hinge
what exceeds the transition torque. So a combination of torques adds one column for each element to the linear laws'
Jacobian. Projected off its columns, each such column meets the residual and the others in sums over the rows above a
torque, which running sums give for all torques at once.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

from elastocal.chain import Array
from elastocal.elasticity import STEP
from elastocal.identification.solver import Normal
from elastocal.identification.sums import Variances, observation_variance, variance_of
from elastocal.identification.transition.grid import Grid
from elastocal.prediction import Model

HIDDEN = 1e-9
"""An excess of which less than this is left once projected, as a square, is no other than what is fitted already."""

USELESS = 1e12
"""What its product with itself is then taken for, so that it gains nothing."""


@dataclass(frozen=True)
class Profile:
    """Projected excess columns of all torques, in products with the residual and with one another.

    Attributes:
        misfit: of the linear laws.
        slopes: for each element (k,) with the residual.
        products: by pair of elements (e <= f): (k_e, k_f); (k_e,) of an element with itself.
    """

    misfit: float
    slopes: tuple[Array, ...]
    products: Mapping[tuple[int, int], Array]

    @property
    def counts(self) -> tuple[int, ...]:
        """How many torques each element has."""
        return tuple(map(len, self.slopes))

    def misfits(self, indices: NDArray[np.intp]) -> Array:
        """The misfit (m,) at combinations (m, elements) of torques, by their numbers in the grids."""
        elements = range(len(self.slopes))
        slope = np.stack([self.slopes[e][indices[:, e]] for e in elements], axis=1)
        matrix = np.empty((len(indices), len(slope[0]), len(slope[0])))
        for e in elements:
            matrix[:, e, e] = self.products[e, e][indices[:, e]]
            for f in range(e + 1, len(self.slopes)):
                matrix[:, e, f] = matrix[:, f, e] = self.products[e, f][indices[:, e], indices[:, f]]
        return self.misfit - _gain(matrix, slope)

    def all_misfits(self) -> Array:
        """The misfit at all combinations of one or two elements' torques, (k,) or (k, k)."""
        if len(self.slopes) == 1:
            return self.misfit - self.slopes[0] ** 2 / self.products[0, 0]
        a, b = self.slopes[0][:, None], self.slopes[1][None]
        aa, bb, ab = self.products[0, 0][:, None], self.products[1, 1][None], self.products[0, 1]
        determinant = aa * bb - ab**2
        apart = determinant > HIDDEN * aa * bb
        both = (a**2 * bb - 2.0 * a * b * ab + b**2 * aa) / np.where(apart, determinant, 1.0)
        return self.misfit - np.where(apart, both, np.maximum(a**2 / aa, b**2 / bb))


def _gain(matrix: Array, slope: Array) -> Array:
    """The gain slope . matrix^-1 slope (m,), a trace of damping where excesses cannot be told apart."""
    damped = matrix + HIDDEN * np.eye(matrix.shape[1]) * matrix
    return np.einsum("me,me->m", slope, np.linalg.solve(damped, slope[:, :, None])[:, :, 0])


@dataclass(frozen=True)
class _Excess:
    """How one element's excess column at a torque follows from its linear column at each load.

    excess = column * sum_j factors[j](torque) * weights[j](load), on the rows above the torque.

    Attributes:
        column: of the element in the linear model.
        weights: (terms, n) and factors (terms, k).
    """

    column: int
    grid: Grid
    weights: Array
    factors: Array

    @classmethod
    def of(cls, law: str, column: int, grid: Grid) -> _Excess:
        """The excess of a law whose linear part is a column of the Jacobian."""
        if law == STEP.name:
            return cls(column, grid, np.ones((1, len(grid.loads))), np.ones((1, len(grid.torques))))
        inverse = 1.0 / np.maximum(grid.loads, grid.torques[0])  # rows below all torques do not count
        weights, factors = (
            np.stack([np.ones_like(inverse), inverse]),
            np.stack([np.ones_like(grid.torques), -grid.torques]),
        )
        return cls(column, grid, weights, factors)


def profile_of(
    model: Model, displacements: Array, variances: Variances, laws: Mapping[str, str], grids: Mapping[str, Grid]
) -> Profile:
    """The profile about a fit.

    Args:
        model: with step or hinge laws on the elements.
        displacements: (parameters,) of the fit.
        variances: the model variances.
        laws: step or hinge, by element.
        grids: the allowed transition torques, by element.
    """
    linear = _linear_part(model, displacements, tuple(laws))
    first = len(linear) - 1 - len(laws)
    excesses = [_Excess.of(law, first + i, grids[element]) for i, (element, law) in enumerate(laws.items())]
    pairs = list(combinations_with_replacement(range(len(excesses)), 2))
    gram = np.zeros((len(linear), len(linear)))
    met = [np.zeros((len(x.weights), len(x.grid.torques) + 1, len(linear))) for x in excesses]
    shared = {(e, f): _empty(excesses[e], excesses[f], same=e == f) for e, f in pairs}
    for part in model.parts(displacements):
        variance = observation_variance(model.data, part, variance_of(variances, part))
        weights = np.ones(1) if model.weights is None else model.weights[part.rows]
        jacobian = linear @ (part.jacobian * np.sqrt(weights / variance))
        gram += np.matmul(jacobian, jacobian.swapaxes(1, 2)).sum(axis=0)
        for total, x in zip(met, excesses, strict=True):
            _add_met(total, x, jacobian, part.rows)
        for e, f in pairs:
            _add_shared(shared[e, f], excesses[e], excesses[f], jacobian, part.rows)
    return _projected(gram, excesses, met, shared)


def _linear_part(model: Model, displacements: Array, elements: Sequence[str]) -> Array:
    """What turns the Jacobian's rows into those of linear laws, (others + elements + 1, parameters + 1).

    The two columns of a law add up to the linear one's; the residual of the linear law is larger by its excess.
    """
    springs = model.displaced(displacements).elastic
    own = [name for name in model.names if name.rpartition(".")[0] not in elements]
    matrix = np.zeros((len(own) + len(elements) + 1, len(model.names) + 1))
    for row, name in enumerate(own):
        matrix[row, model.names.index(name)] = 1.0
    for row, element in enumerate(elements, start=len(own)):
        low, high = springs[element].coefficients
        columns = [model.names.index(f"{element}.{key}") for key in ("c_low", "c_high")]
        matrix[row, columns] = 1.0
        matrix[-1, columns[1]] = high - low
    matrix[-1, -1] = 1.0
    return matrix


def _projected(
    gram: Array, excesses: Sequence[_Excess], met: Sequence[Array], shared: Mapping[tuple[int, int], Array]
) -> Profile:
    """Project the excess columns and the residual off the linear laws' columns."""
    covariance = Normal.of_gram(gram).covariance
    above = [np.einsum("wk,wkp->kp", x.factors, _above(total, 1)) for x, total in zip(excesses, met, strict=True)]
    explained = [columns[:, :-1] @ covariance for columns in above]
    slopes = tuple(a[:, -1] - e @ gram[:-1, -1] for a, e in zip(above, explained, strict=True))
    products = {}
    for (e, f), sums in shared.items():
        if e == f:
            whole = np.einsum("wk,vk,wvk->k", excesses[e].factors, excesses[e].factors, _above(sums, 2))
            left = whole - np.einsum("kp,kp->k", explained[e], above[e][:, :-1])
            products[e, e] = np.where(left > HIDDEN * whole, left, USELESS * (1.0 + whole))
        else:
            both = _above(_above(sums, 2), 3)
            whole = np.einsum("wk,vl,wvkl->kl", excesses[e].factors, excesses[f].factors, both)
            products[e, f] = whole - explained[e] @ above[f][:, :-1].T
    misfit = float(gram[-1, -1] - gram[:-1, -1] @ covariance @ gram[:-1, -1])
    return Profile(misfit, slopes, products)


def _empty(e: _Excess, f: _Excess, same: bool) -> Array:
    counts = (len(e.grid.torques) + 1,) if same else (len(e.grid.torques) + 1, len(f.grid.torques) + 1)
    return np.zeros((len(e.weights), len(f.weights), *counts))


def _add_met(total: Array, x: _Excess, jacobian: Array, rows: NDArray[np.intp]) -> None:
    """Products of an element's column with the whole Jacobian and the residual, by bin of the load."""
    met = np.einsum("cn,cpn->np", jacobian[:, x.column], jacobian)
    for target, weight in zip(total, x.weights, strict=True):
        np.add.at(target, x.grid.bins[rows], met * weight[rows, None])


def _add_shared(total: Array, e: _Excess, f: _Excess, jacobian: Array, rows: NDArray[np.intp]) -> None:
    """Products of two elements' columns by bins of both loads."""
    met = np.einsum("cn,cn->n", jacobian[:, e.column], jacobian[:, f.column])
    bins = (e.grid.bins[rows],) if total.ndim == 3 else (e.grid.bins[rows], f.grid.bins[rows])
    for line, first in zip(total, e.weights, strict=True):
        for target, second in zip(line, f.weights, strict=True):
            np.add.at(target, bins, met * first[rows] * second[rows])


def _above(binned: Array, axis: int) -> Array:
    """Sums over the bins above each torque."""
    sums = np.flip(np.cumsum(np.flip(binned, axis), axis), axis)
    return np.delete(sums, 0, axis)
