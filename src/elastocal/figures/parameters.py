"""Figures of parameters: deviations from nominal, correlations, singular values."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from elastocal.chain import Array
from elastocal.figures.panel import Panel, Trace, axes, level, numbers, plain, points, stripe
from elastocal.figures.style import DIVERGING, LAW, MARK
from elastocal.identification import AnyResult, IdentifiedParameter
from elastocal.parameters import Group, parameters_of

GEOMETRY = (Group.OFFSET, Group.LENGTH, Group.TWIST, Group.SPARE)

MOST_CORRELATED = 80
"""Parameters of a correlation matrix: of more, those that are correlated most."""

UNSEEN = 1e-6
"""Singular values below this share of the largest count as not seen."""

KINDS = {"length": ("Lengths", "mm", 1e3), "angle": ("Angles", "mrad", 1e3), "offset": ("Joint offsets", "mrad", 1e3)}
"""Of geometric parameters: title, unit, factor from SI."""


def kinds_of(result: AnyResult) -> dict[str, str]:
    """The geometric parameters that were identified from a nominal value, and of which kind of KINDS they are."""
    there, found = parameters_of(result.robot), {}
    for p in result.parameters:
        parameter = there.get(p.name)
        if p.std is not None and p.nominal is not None and parameter is not None and parameter.group in GEOMETRY:
            turned = "offset" if parameter.group == Group.OFFSET else "angle"
            found[p.name] = "length" if parameter.unit == "m" else turned
    return found


def deviation(p: IdentifiedParameter) -> float:
    """Identified less nominal [SI], angles within half a turn."""
    change = p.identified - (p.nominal or 0.0)
    return float((change + np.pi) % (2.0 * np.pi) - np.pi) if p.unit == "rad" else change


def tolerances_of(result: AnyResult) -> dict[str, float]:
    """Tolerances by kind [m or rad]: those of the robot file, else those that a fit with priors estimated."""
    return {**result.tolerances, **result.robot.tolerance}


def deviation_panels(result: AnyResult) -> list[Panel]:
    """Deviations from nominal by kind, in units of the tolerance where there is one."""
    kinds, tolerances = kinds_of(result), tolerances_of(result)
    found = []
    for kind, (title, unit, scale) in KINDS.items():
        mine = [p for p in result.parameters if kinds.get(p.name) == kind]
        if not mine:
            continue
        tolerance = tolerances.get(kind)
        if tolerance:
            label = f"deviation [tolerance of {scale * tolerance:.3g} {unit}]"
            found.append(_deviations(title, mine, 1.0 / tolerance, label, toleranced=True))
        else:
            found.append(_deviations(title, mine, scale, f"deviation [{unit}]"))
    return found


def _deviations(
    title: str, mine: Iterable[IdentifiedParameter], scale: float, label: str, toleranced: bool = False
) -> Panel:
    listed = list(mine)[::-1]
    values = np.array([scale * deviation(p) for p in listed])
    spread = np.array([2.0 * scale * (p.std or 0.0) for p in listed])
    names = [plain(p.name) for p in listed]
    trace: Trace = points(
        values, np.zeros(len(listed)), "identified - nominal", LAW, marker={"size": 8, "opacity": 1.0}
    )
    trace |= {"y": names, "error_x": {"type": "data", "array": numbers(spread), "thickness": 1.5, "width": 4}}
    trace |= {"hovertemplate": "%{y}: %{x:.4g} ± %{error_x.array:.2g}<extra></extra>"}
    shapes = [stripe(-1.0, 1.0, LAW)] if toleranced else []
    layout = axes(label, "", shapes=shapes, showlegend=False, yaxis={"type": "category", "dtick": 1})
    return Panel(title, [trace], layout, height=90 + 21 * len(listed))


def correlations(result: AnyResult) -> tuple[list[str], Array]:
    """Names and correlation matrix of the identified parameters, coefficients of joint maps left out."""
    maps = {f"{e}.{key}" for e, error in result.robot.transmission.items() for key in error.coefficients}
    index = [i for i, name in enumerate(result.names) if name not in maps]
    covariance = result.covariance[np.ix_(index, index)]
    deviation = np.sqrt(np.clip(np.diag(covariance), 0.0, None))
    scale = np.where(deviation > 0.0, deviation, np.inf)
    return [result.names[i] for i in index], covariance / np.outer(scale, scale)


def correlation_panels(result: AnyResult) -> list[Panel]:
    """The correlation matrix of the identified parameters."""
    names, matrix = correlations(result)
    if len(names) < 2:
        return []
    note = ""
    if len(names) > MOST_CORRELATED:
        strongest = np.abs(matrix - np.diag(np.diag(matrix))).max(axis=0)
        kept = np.sort(np.argsort(-strongest, kind="stable")[:MOST_CORRELATED])
        note = f"the {MOST_CORRELATED} most correlated of {len(names)} parameters drawn"
        names, matrix = [names[i] for i in kept], matrix[np.ix_(kept, kept)]
    labels = [plain(name) for name in names]
    trace: Trace = {
        "type": "heatmap",
        "x": labels,
        "y": labels,
        "z": numbers(matrix),
        "zmin": -1.0,
        "zmax": 1.0,
        "colorscale": DIVERGING,
        "colorbar": {"thickness": 12},
        "hovertemplate": "%{x}, %{y}: %{z:.3f}<extra></extra>",
    }
    small = {"tickfont": {"size": 10 if len(names) <= 40 else 7}, "type": "category", "showgrid": False}
    axis = axes("", "", xaxis=small | {"tickangle": -90}, yaxis=small | {"autorange": "reversed"})
    return [
        Panel(
            "Correlation of the parameters' errors",
            [trace],
            axis,
            note,
            height=max(360, 160 + 14 * len(names)),
            wide=True,
        )
    ]


def singular_panels(result: AnyResult) -> list[Panel]:
    """The singular values of the identification Jacobian."""
    values = () if result.observability is None else result.observability.singular_values
    if not values:
        return []
    number, sizes = np.arange(1.0, len(values) + 1.0), np.array(values)
    bars: Trace = {
        "type": "bar",
        "x": numbers(number),
        "y": numbers(np.maximum(sizes, 1e-12)),
        "name": "singular values",
        "marker": {"color": LAW},
        "hovertemplate": "%{x}: %{y:.3g}<extra></extra>",
    }
    shapes = [level(UNSEEN * float(sizes.max()), MARK, "dot")] if sizes.min() < 1e-4 * sizes.max() else []
    lowest = np.floor(np.log10(max(float(sizes.min()), 1e-9 * float(sizes.max()), 1e-12)))
    highest = np.ceil(np.log10(max(float(sizes.max()), 1e-12)))
    yaxis = {"type": "log", "range": [float(lowest), float(highest)], "exponentformat": "power", "dtick": 1}
    layout = axes("direction of the parameters", "singular value [m/m]", yaxis=yaxis, shapes=shapes, showlegend=False)
    return [Panel("Singular values", [bars], layout, height=300)]
