"""Fits with priors: joint maps, one variance for each band of orders, and geometry, one for each kind of parameter."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from elastocal.errors import InputError
from elastocal.identification.evidence import NOTHING, Prior, fit_by_evidence, most_likely
from elastocal.identification.gauge import Gauge
from elastocal.identification.partitioned import Partitioned
from elastocal.identification.solver import Normal, Solution
from elastocal.identification.sums import Sums, normal_sums
from elastocal.parameters import Group, Parameter, parameters_of
from elastocal.prediction import Model
from elastocal.robot import JointMap, Robot

ENDS = (0, 1, 2, 4, 8, 14, 22, 34, 60)
"""Orders at which bands end; where none is asked for, maps up to each of them are compared."""

MOST_ORDERS = 360
"""More than one wave for each degree is no transmission error."""

WIDER = 1.65
"""How much further each band beyond these reaches than the one before."""

NO_MORE = 1.0
"""Orders whose log evidence is higher by less than this are not worth having."""

FIRST_TOLERANCE = {"length": 1e-3, "angle": 1e-3, "offset": 1e-3, "compliance": 1e-5, "linear compliance": 1e-7}
"""Kinds of parameters that share a prior, and the standard deviations to start from where the robot states none:
lengths [m], angles and joint offsets [rad], compliances of turning [rad/(N m)] and of sliding elements [m/N]."""

LEAST_TOLERANCE = {kind: spread / 50.0 for kind, spread in FIRST_TOLERANCE.items()}
"""Standard deviations that are not estimated to be less: nothing is built exactly."""

FIRST_GUESS = 3e-5
"""Standard deviation [rad or m] of a map's coefficients to start from."""


@dataclass(frozen=True)
class Band:
    """Orders from `first` to `last` of all joint maps, with the standard deviation of their coefficients [rad or m]."""

    first: int
    last: int
    std: float = FIRST_GUESS


@dataclass(frozen=True)
class MapFit:
    """How joint maps were found.

    Attributes:
        orders: how many the maps have.
        bands: with their standard deviations.
        log_evidence: of maps of other numbers of orders, beside none at all; empty where the number was asked for.
    """

    orders: int
    bands: tuple[Band, ...]
    log_evidence: Mapping[int, float]


@dataclass(frozen=True)
class PriorFit:
    """A fit with priors.

    Attributes:
        robot: where all displacements are zero, with maps.
        names: the parameters, maps and all geometry with a prior among them.
        solution: where the fit ended, the prior among its sums.
        prior: with its variances; None where the evidence favours no maps and there is no other prior.
        orders: how many orders the maps have.
        bands: with their standard deviations.
        log_evidence: of maps of other numbers of orders, beside none at all; empty where the number was asked for.
    """

    robot: Robot
    names: tuple[str, ...]
    solution: Solution
    prior: Prior | None
    orders: int
    bands: tuple[Band, ...]
    log_evidence: Mapping[int, float]

    @property
    def tolerances(self) -> dict[str, float]:
        """Standard deviations of the kinds of geometry, given or estimated [m or rad]."""
        if self.prior is None:
            return {}
        spread = dict(zip(self.prior.groups, np.sqrt(self.prior.variances).tolist(), strict=True))
        return {kind: spread[kind] for kind in FIRST_TOLERANCE if kind in spread}

    @property
    def shares(self) -> dict[str, float]:
        """How much of each parameter with a prior the data tell, from 0 to 1: what is left the prior carries."""
        if self.prior is None:
            return {}
        precision, spread = self.prior.precision, Normal.of(self.solution.sums).covariance.diagonal()
        told = np.clip(1.0 - spread * precision, 0.0, 1.0)
        return {n: float(t) for n, t, p in zip(self.names, told, precision, strict=True) if p > 0.0}


def require_orders(transmission: int | str) -> int | None:
    """Orders of joint maps as asked for; None: as many as the evidence favours.

    Raises:
        InputError: no such number.
    """
    if transmission == "auto":
        return None
    if isinstance(transmission, str) or not 0 <= transmission <= MOST_ORDERS:
        raise InputError(f"transmission is {transmission}: expected orders from 0 to {MOST_ORDERS}, or auto")
    return transmission


def bands(orders: int) -> tuple[Band, ...]:
    """The bands of orders 1 to `orders`."""
    ends = list(ENDS)
    while ends[-1] < orders:
        ends.append(round(WIDER * ends[-1]))
    return tuple(Band(first + 1, min(last, orders)) for first, last in pairwise(ends) if first < orders)


def with_maps(robot: Robot, orders: int) -> Robot:
    """The robot with a map of at least so many orders on every joint; what it does not have is zero."""
    maps = dict(robot.transmission)
    for row in robot.joints:
        element = row.joint_element or ""
        known = maps.get(element, JointMap())
        missing = (0.0,) * max(orders - len(known.sin), 0)
        maps[element] = JointMap(known.sin + missing, known.cos + missing)
    return replace(robot, transmission=maps)


def geometry_kinds(robot: Robot, gauge: Gauge) -> dict[str, str]:
    """The kinds of all geometric parameters of rows that the measurements involve, and of compliances, by name."""
    parameters = parameters_of(robot)
    seen = [
        n for n in parameters if n in gauge.kept or (n in gauge.dropped and gauge.dropped[n].verdict == "dependent")
    ]
    kinds = {}
    for name in seen:
        parameter = parameters[name]
        if parameter.group == Group.OFFSET and parameter.unit == "rad":
            kinds[name] = "offset"
        elif parameter.group in (Group.OFFSET, Group.LENGTH, Group.TWIST, Group.SPARE):
            kinds[name] = "length" if parameter.unit == "m" else "angle"
        elif parameter.group == Group.COMPLIANCE and parameter.power == 1:
            kinds[name] = "compliance" if parameter.unit.startswith("rad") else "linear compliance"
    return kinds


def fit_with_priors(
    model: Model | Partitioned,
    solution: Solution,
    orders: int | None,
    kinds: Mapping[str, str],
    tolerance: Mapping[str, float],
) -> PriorFit:
    """Identify joint maps and geometry with priors together with the other parameters of a fit.

    Args:
        model: that was fitted without priors.
        solution: its fit.
        orders: of the maps; None: as many as the evidence favours, none perhaps.
        kinds: of the geometric parameters that get a prior about their nominal values, by name.
        tolerance: standard deviations by kind [m or rad]; of other kinds they are estimated.

    Raises:
        EquilibriumError: the robot does not settle under its load.
    """
    most = ENDS[-1] if orders is None else orders
    mapped = with_maps(model.robot, most) if most else model.robot
    maps = {n: p for n, p in parameters_of(mapped).items() if p.group == Group.MAP and 0 < _order(n) <= most}
    added = [name for name in (*kinds, *maps) if name not in model.names]
    extended = replace(model, robot=mapped, names=(*model.names, *added))
    start = np.append(solution.displacements, np.zeros(len(added)))
    start[[i for i, name in enumerate(extended.names) if name in kinds]] = 0.0  # a fit without priors may be far off
    groups = _Groups(maps, kinds, tolerance)
    evidence: dict[int, float] = {}
    if orders is None:
        sums = normal_sums(extended, start, solution.variances)
        evidence = _evidence(extended.names, sums, start, groups)
        most = min(count for count in ENDS if evidence[count] > max(evidence.values()) - NO_MORE)
        kept = groups.up_to(most, extended.names)
        robot = with_maps(model.robot, most) if most else model.robot
        extended = replace(extended, robot=robot, names=tuple(extended.names[i] for i in kept))
        start = start[kept]
    if not most and not kinds:
        return PriorFit(model.robot, model.names, solution, None, 0, (), evidence)
    found, posterior = fit_by_evidence(extended, start, groups.prior(extended.names, most), solution.variances)
    bands_found = _bands_of(posterior.prior, most)
    return PriorFit(extended.robot, extended.names, found, posterior.prior, most, bands_found, evidence)


@dataclass(frozen=True)
class _Groups:
    """Which parameters share a prior's variance: orders of a band, geometry of a kind."""

    maps: Mapping[str, Parameter]
    kinds: Mapping[str, str]
    tolerance: Mapping[str, float]

    def prior(self, names: Sequence[str], orders: int) -> Prior:
        """The prior to start from, for maps of so many orders."""
        last = np.array([band.last for band in bands(orders)])

        def group(name: str) -> str:
            if name in self.maps:
                return f"{self.maps[name].unit} {np.searchsorted(last, _order(name))}"
            return self.kinds.get(name, "")

        keys = [group(name) for name in names]
        groups = tuple(dict.fromkeys(key for key in keys if key))
        member = np.array([groups.index(key) if key else -1 for key in keys], dtype=int)
        first = {**FIRST_TOLERANCE, **self.tolerance}
        spread = np.array([first.get(g, FIRST_GUESS) for g in groups])
        given = np.array([g in self.tolerance for g in groups], dtype=bool)
        optional = np.array([g not in FIRST_TOLERANCE for g in groups], dtype=bool)
        least = np.array([LEAST_TOLERANCE.get(g, np.sqrt(NOTHING)) for g in groups])
        return Prior(groups, member, spread**2, given, optional, least**2)

    def up_to(self, orders: int, names: Sequence[str]) -> NDArray[np.intp]:
        """Which parameters remain if maps have so many orders."""
        return np.array([i for i, name in enumerate(names) if name not in self.maps or _order(name) <= orders])


def _order(name: str) -> int:
    """The order of a map's coefficient, by its name."""
    found = re.search(r"\d+$", name)
    return int(found.group()) if found else 0


def _bands_of(prior: Prior, orders: int) -> tuple[Band, ...]:
    """The bands with the prior's standard deviations; those of revolute joints where there are both."""
    spread = dict(zip(prior.groups, np.sqrt(prior.variances).tolist(), strict=True))
    return tuple(
        replace(band, std=spread.get(f"rad {i}", spread.get(f"m {i}", 0.0))) for i, band in enumerate(bands(orders))
    )


def _evidence(
    names: Sequence[str], sums: Sums, displacements: NDArray[np.float64], groups: _Groups
) -> dict[int, float]:
    """Log evidence of maps with fewer orders, from the sums of those with most; relative to none."""
    found = {}
    for orders in ENDS:
        kept = groups.up_to(orders, names)
        with_residual = np.append(kept, len(names))
        part = {kind: replace(one, gram=one.gram[np.ix_(with_residual, with_residual)]) for kind, one in sums.items()}
        prior = groups.prior([names[i] for i in kept], orders)
        found[orders] = most_likely(part, displacements[kept], prior).log_evidence
    return {orders: value - found[0] for orders, value in found.items()}
