"""Frames: their elements, and displacements that compose."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from elastocal.chain import rotation_about
from elastocal.robot import FRAME_KEYS, Frame
from support.urdf import frame_matrix

triples = st.tuples(*[st.floats(-3.0, 3.0)] * 3)
frames = st.builds(Frame, triples, triples)
deltas = st.dictionaries(st.sampled_from(FRAME_KEYS), st.floats(-1.0, 1.0))
same_examples = settings(deadline=None, derandomize=True, database=None)
ROUNDING = 1e-13


def turn(delta: dict[str, float]) -> np.ndarray:
    whole = np.eye(3)
    for axis, key in zip(np.eye(3), FRAME_KEYS[3:], strict=True):
        whole = whole @ rotation_about(axis, delta.get(key, 0.0))
    return whole


def shift(delta: dict[str, float]) -> np.ndarray:
    return np.array([delta.get(key, 0.0) for key in FRAME_KEYS[:3]])


@same_examples
@given(frames, deltas)
def test_a_displaced_frame_is_shifted_in_its_parent_and_turned_about_its_own_axes(frame: Frame, delta: dict) -> None:
    moved = frame.displaced(delta)
    np.testing.assert_allclose(moved.translation, frame.translation + shift(delta), rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(moved.rotation, frame.rotation @ turn(delta), rtol=0, atol=ROUNDING)


@same_examples
@given(frames, deltas, deltas)
def test_displacements_of_a_frame_compose(frame: Frame, first: dict, second: dict) -> None:
    moved = frame.displaced(first).displaced(second)
    np.testing.assert_allclose(
        moved.translation, frame.translation + shift(first) + shift(second), rtol=0, atol=ROUNDING
    )
    np.testing.assert_allclose(moved.rotation, frame.rotation @ turn(first) @ turn(second), rtol=0, atol=ROUNDING)


@same_examples
@given(frames, st.sampled_from(FRAME_KEYS), st.floats(-1.0, 1.0))
def test_a_displacement_and_its_opposite_cancel(frame: Frame, key: str, size: float) -> None:
    there_and_back = frame.displaced({key: size}).displaced({key: -size})
    np.testing.assert_allclose(frame_matrix(there_and_back), frame_matrix(frame), rtol=0, atol=ROUNDING)


@same_examples
@given(frames, st.sampled_from(FRAME_KEYS[3:]), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_turns_about_one_axis_add_up(frame: Frame, key: str, first: float, second: float) -> None:
    twice, once = frame.displaced({key: first}).displaced({key: second}), frame.displaced({key: first + second})
    np.testing.assert_allclose(frame_matrix(twice), frame_matrix(once), rtol=0, atol=ROUNDING)


@same_examples
@given(frames)
def test_the_elements_of_a_frame_make_it_up(frame: Frame) -> None:
    elements = frame.elements("base")
    assert [element.name for element in elements] == [*(f"base.{k}" for k in FRAME_KEYS[:3]), ""] + [
        f"base.{k}" for k in FRAME_KEYS[3:]
    ]
    rotation = np.eye(3)
    for element in elements:
        if element.rotation:
            rotation = rotation @ rotation_about(element.axis, element.value)
    np.testing.assert_allclose(rotation, frame.rotation, rtol=0, atol=ROUNDING)
    np.testing.assert_array_equal([element.value for element in elements[:3]], frame.translation)


@pytest.mark.parametrize(
    "rpy", [(0.3, np.pi / 2, -0.4), (0.0, -np.pi / 2, 2.0), (np.pi, 0.0, 0.0), (np.pi, 0.0, np.pi)]
)
def test_no_orientation_of_a_frame_loses_a_displacement(rpy: tuple[float, float, float]) -> None:
    frame = Frame((1.0, 2.0, 3.0), rpy)
    for key in FRAME_KEYS[3:]:
        moved = frame.displaced({key: 1e-3})
        np.testing.assert_allclose(moved.rotation, frame.rotation @ turn({key: 1e-3}), rtol=0, atol=ROUNDING)


def test_a_frame_without_a_guess_is_the_identity_until_it_is_displaced() -> None:
    open_frame = Frame()
    np.testing.assert_array_equal(frame_matrix(open_frame), np.eye(4))
    assert open_frame.displaced({}) is open_frame
    moved = open_frame.displaced({"tz": 0.5})
    assert moved.xyz == (0.0, 0.0, 0.5)
    assert moved.rpy == (0.0, 0.0, 0.0)


def test_displacing_a_known_frame_keeps_it_known() -> None:
    assert Frame((0.0, 0.0, 0.0), known=True).displaced({"rx": 0.1}).known
