"""Loads on elastic elements against energy and virtual work, from slow plain matrices."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from elastocal.chain import forward, place
from elastocal.robot import Robot, assemble
from elastocal.statics import Statics, load
from support.differences import central_difference
from support.robots import arm, placed, random_dh_robot
from support.urdf import compliant, equipped, posed

OTHERS = ("1.a", "2.alpha", "3.a", "4.b", "5.beta", "tool.rx", "tool.tz", "tool.rz")
STEP = 1e-3
SCENES = [
    (convention, where, seed)
    for seed, convention in enumerate(("modified-dh", "standard-dh"))
    for where in ((None, None, None), ("north", "near", "heavy"), (None, "far", None))
]


def laden(convention: str, seed: int) -> Robot:
    rng = np.random.default_rng(seed)
    return compliant(equipped(random_dh_robot(rng, convention, prismatic=0.35), rng), OTHERS, 0.0, 0.0)


def loads_of(robot: Robot, q: np.ndarray, where: tuple, wrench: np.ndarray | None = None) -> tuple[Statics, list[str]]:
    """The undeflected robot under load, and the names of the loaded elements."""
    assembly = assemble(robot, *where)
    mechanism = assembly.mechanism
    placement = place(mechanism.chain, mechanism.chain.values)
    state = load(mechanism, placement, forward(placement, assembly.motion(q.T)), None if wrench is None else wrench.T)
    return state, [mechanism.chain.elements[i].name for i in mechanism.elastic]


@pytest.mark.parametrize(("convention", "where", "seed"), SCENES)
def test_load_is_minus_the_derivative_of_the_potential_energy(convention: str, where: tuple, seed: int) -> None:
    robot = laden(convention, seed)
    q = np.random.default_rng(seed).uniform(-2.0, 2.0, (3, 6))
    state, names = loads_of(robot, q, where)
    for pose, loads in zip(q, state.loads.T, strict=True):
        slopes = [
            central_difference(lambda t, p=pose, n=name: posed(robot, p, {n: t}, *where).potential, STEP)
            for name in names
        ]
        np.testing.assert_allclose(loads, -np.array(slopes), rtol=0, atol=1e-8 * np.abs(slopes).max())


@pytest.mark.parametrize(("convention", "where", "seed"), SCENES)
def test_load_is_the_moment_or_the_force_of_all_that_hangs_beyond(convention: str, where: tuple, seed: int) -> None:
    robot = laden(convention, seed)
    rng = np.random.default_rng(seed)
    q, wrench = rng.uniform(-2.0, 2.0, (3, 6)), 50.0 * rng.normal(size=(3, 6))
    state, names = loads_of(robot, q, where, wrench)
    expected = [[posed(robot, p, {}, *where).load(name, w) for p, w in zip(q, wrench, strict=True)] for name in names]
    np.testing.assert_allclose(state.loads, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize(("convention", "where", "seed"), SCENES)
def test_load_of_a_wrench_is_its_virtual_work(convention: str, where: tuple, seed: int) -> None:
    robot = replace(laden(convention, seed), gravity=(0.0, 0.0, 0.0))
    rng = np.random.default_rng(seed)
    q, wrench = rng.uniform(-2.0, 2.0, (3, 6)), 50.0 * rng.normal(size=(3, 6))
    state, names = loads_of(robot, q, where, wrench)
    for pose, (force, moment), loads in zip(q, wrench.reshape(-1, 2, 3), state.loads.T, strict=True):
        at = posed(robot, pose, {}, *where)
        held = at.frames[at.tool][:3, :3]

        def moved(t: float, name: str, p: np.ndarray = pose, held: np.ndarray = held) -> np.ndarray:
            there = posed(robot, p, {name: t}, *where)
            frame = there.frames[there.tool]
            return np.concatenate([frame[:3, 3], Rotation.from_matrix(frame[:3, :3] @ held.T).as_rotvec()])

        pull = np.concatenate([held @ force, held @ moment])
        work = [pull @ central_difference(lambda t, n=name, m=moved: m(t, n), STEP) for name in names]
        np.testing.assert_allclose(loads, work, rtol=0, atol=1e-8 * np.abs(work).max())


def test_masses_of_the_tool_do_not_press_on_elements_of_the_tool_frame() -> None:
    robot = laden("modified-dh", 4)
    state, names = loads_of(robot, np.zeros((1, 6)), (None, None, "heavy"))
    for name, value in zip(names, state.loads[:, 0], strict=True):
        assert (value == 0.0) == name.startswith("tool.")


def test_a_joint_about_a_vertical_axis_carries_no_load_of_gravity() -> None:
    robot = placed(arm(elastic=True), np.random.default_rng(3))
    state, names = loads_of(robot, np.random.default_rng(4).uniform(-2.0, 2.0, (10, 6)), (None, None, None))
    assert names[0] == "1.theta"
    assert np.abs(state.loads[0]).max() < 1e-12 * np.abs(state.loads[1]).max()


def test_nothing_loads_a_robot_without_gravity() -> None:
    robot = replace(laden("standard-dh", 5), gravity=(0.0, 0.0, 0.0))
    state, _ = loads_of(robot, np.ones((2, 6)), ("north", "far", "heavy"))
    assert not state.loads.any()


@pytest.mark.parametrize("shift", [0.0, 5.0], ids=["turned", "turned and moved"])
def test_where_the_instrument_stands_changes_no_load(shift: float) -> None:
    robot = laden("standard-dh", 6)
    rng = np.random.default_rng(7)
    q, wrench = rng.uniform(-2.0, 2.0, (5, 6)), 50.0 * rng.normal(size=(5, 6))
    moved = replace(robot, base=robot.base.displaced({"rx": 0.7, "ry": -1.1, "tx": shift, "tz": -shift}))
    before, after = (loads_of(r, q, (None, "near", "heavy"), wrench)[0].loads for r in (robot, moved))
    np.testing.assert_allclose(before, after, rtol=0, atol=1e-12 * np.abs(before).max())
