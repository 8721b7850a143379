"""URDF out: pinocchio puts it where we do, and elastocal reads the whole robot back."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import elastocal as ec
from elastocal.chain import forward, place
from elastocal.errors import InputError
from elastocal.io.urdf import tips_of
from elastocal.robot import Compliance, Payload, Robot, assemble
from elastocal.statics import load
from support.exports import CONVENTIONS, at_its_base, random_frame, random_robot, softened
from support.files import edited
from support.robots import arm

pinocchio = pytest.importorskip("pinocchio", reason="the oracle is not installed: pip install 'elastocal[test]'")

DOWN = (0.0, 0.0, -9.81)


def oracle(text: str, names: list[str], q: np.ndarray, tip: str = "tool0") -> tuple[np.ndarray, ...]:
    """Pinocchio's positions and rotations of a link, and the generalized gravity of the named joints.

    Joints that mimic another are moved as their elements say.
    """
    model = pinocchio.buildModelFromXML(text)
    data, frame = model.createData(), model.getFrameId(tip)
    mimics = {j.get("name"): j.find("mimic") for j in ElementTree.fromstring(text).findall("joint")}
    row = {name: model.joints[model.getJointId(name)].idx_v for name in mimics if model.existJointName(name)}
    positions, rotations, torques = [], [], []
    for pose in q:
        step = np.zeros(model.nv)
        for name, position in zip(names, pose, strict=True):
            step[row[name]] = position
        for name, mimic in mimics.items():
            if mimic is not None:
                step[row[name]] = float(mimic.get("multiplier")) * pose[names.index(mimic.get("joint"))]
        configuration = pinocchio.integrate(model, pinocchio.neutral(model), step)
        pinocchio.framesForwardKinematics(model, data, configuration)
        positions.append(data.oMf[frame].translation.copy())
        rotations.append(data.oMf[frame].rotation.copy())
        gravity = pinocchio.computeGeneralizedGravity(model, data, configuration)
        torques.append([gravity[row[name]] for name in names])
    return np.array(positions), np.array(rotations), np.array(torques)


def assert_same(robot: Robot, text: str, q: np.ndarray, model_q: np.ndarray | None = None) -> None:
    """The URDF's tool is where the rigid robot's is."""
    names = [row.name for row in robot.joints]
    theirs = oracle(text, names, q if model_q is None else model_q)
    ours = ec.predict(at_its_base(replace(robot, elastic={}, transmission={})), q)
    np.testing.assert_allclose(theirs[0], ours[0], rtol=0, atol=1e-12)
    np.testing.assert_allclose(theirs[1], ours[1], rtol=0, atol=1e-12)


@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize("seed", range(8))
def test_pinocchio_puts_the_tool_where_we_do(seed: int, convention: str):
    robot = random_robot(np.random.default_rng(seed), convention)
    assert_same(robot, ec.export_robot(robot, "urdf").text, ec.random_poses(robot, 10, seed))


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_pinocchio_bears_the_same_loads(convention: str):
    robot = replace(random_robot(np.random.default_rng(20), convention), gravity=DOWN)
    q = ec.random_poses(robot, 10, 3)
    names = [row.joint_element for row in robot.joints]
    assembly = assemble(at_its_base(replace(robot, elastic={name: Compliance() for name in names})))
    mechanism = assembly.mechanism
    placement = place(mechanism.chain, mechanism.chain.values)
    ours = load(mechanism, placement, forward(placement, assembly.motion(q.T))).loads.T
    theirs = oracle(ec.export_robot(robot, "urdf").text, [row.name for row in robot.joints], q)[2]
    signs = np.array([row.sign for row in robot.joints])
    np.testing.assert_allclose(theirs, -ours * signs, rtol=0, atol=1e-10 * np.abs(ours).max())


def test_no_tip_need_be_chosen_of_an_exported_robot_with_several_targets(tmp_path: Path):
    robot = replace(arm(), targets={name: random_frame(np.random.default_rng(1)) for name in ("one", "other")})
    path = tmp_path / "robot.urdf"
    path.write_text(ec.export_robot(robot, "urdf").text)
    assert tips_of(path) == ()
    assert set(ec.load_robot(path).targets) == {"one", "other"}


def test_targets_are_links():
    rng = np.random.default_rng(21)
    robot = replace(random_robot(rng, "modified-dh"), targets={"nest": random_frame(rng)})
    q = ec.random_poses(robot, 10, 3)
    names = [row.name for row in robot.joints]
    position, rotation, _ = oracle(ec.export_robot(robot, "urdf").text, names, q, "target_nest")
    ours = ec.predict(at_its_base(robot), q, target="nest")
    np.testing.assert_allclose(position, ours[0], rtol=0, atol=1e-12)
    np.testing.assert_allclose(rotation, ours[1], rtol=0, atol=1e-12)


def coupled(robot: Robot, rng: np.random.Generator, diagonal: float) -> Robot:
    matrix = np.diag([diagonal] * 6) + np.tril(rng.uniform(-0.5, 0.5, (6, 6)), -1)
    return replace(robot, coupling=tuple(map(tuple, matrix.tolist())))


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_couplings_are_mimic_joints(convention: str):
    rng = np.random.default_rng(22)
    robot = coupled(random_robot(rng, convention), rng, 1.0)
    exported = ec.export_robot(robot, "urdf")
    assert exported.text.count("<mimic") == 15
    assert not any("coupling" in text for text in exported.cannot_hold)
    assert_same(robot, exported.text, ec.random_poses(robot, 10, 3))


def test_a_coupling_that_mimic_joints_cannot_hold_is_told_and_the_joints_are_the_models():
    rng = np.random.default_rng(23)
    robot = coupled(random_robot(rng, "modified-dh"), rng, 0.5)
    exported = ec.export_robot(robot, "urdf")
    assert "coupling of the joints" in exported.cannot_hold
    assert any("joints of the URDF are those of the model" in note for note in exported.notes)
    q = ec.random_poses(robot, 10, 3)
    assert_same(robot, exported.text, q, q @ np.array(robot.coupling).T)


def saved(robot: Robot, folder: Path) -> Path:
    path = folder / "robot.urdf"
    path.write_text(ec.export_robot(robot, "urdf").text, encoding="utf-8")
    return path


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_elastocal_reads_the_whole_robot_back(convention: str, tmp_path: Path):
    rng = np.random.default_rng(24)
    robot = softened(random_robot(rng, convention))
    robot = replace(
        robot,
        name='R&D <"arm">',
        targets={"nest": random_frame(rng)},
        stations={"north": random_frame(rng)},
        tolerance={"length": 1e-3},
    )
    if convention != "urdf":
        robot = replace(robot, elastic={**robot.elastic, f"{robot.rows[4].name}.beta": Compliance("linear", (1e-6,))})
    again = ec.load_robot(saved(robot, tmp_path))
    assert again.name == robot.name
    q = ec.random_poses(robot, 20, 3)
    for name in (None, "heavy"):
        one, other = (
            ec.predict(r, q, load=name, target="nest", station="north", wrench=np.full((20, 6), 5.0))
            for r in (robot, again)
        )
        np.testing.assert_allclose(one[0], other[0], rtol=0, atol=1e-12)
        np.testing.assert_allclose(one[1], other[1], rtol=0, atol=1e-12)


def test_without_the_extension_any_reader_of_urdf_has_the_rigid_robot(tmp_path: Path):
    robot = random_robot(np.random.default_rng(25), "standard-dh")
    path = saved(robot, tmp_path)
    root = ElementTree.fromstring(path.read_text())
    root.remove(root.find("elastocal"))
    path.write_bytes(ElementTree.tostring(root))
    q = ec.random_poses(robot, 20, 3)
    for one, other in zip(
        ec.predict(at_its_base(robot), q), ec.predict(ec.load_robot(path, tip="tool0"), q), strict=True
    ):
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-12)


def test_joints_of_a_urdf_keep_names_and_numbers():
    robot = random_robot(np.random.default_rng(26), "urdf", fixed=False)
    joints = ElementTree.fromstring(ec.export_robot(robot, "urdf").text).findall("joint")
    for joint, row in zip(joints, robot.rows, strict=False):
        assert joint.get("name") == row.name
        assert tuple(map(float, joint.find("origin").get("rpy").split())) == row.origin.rpy
        assert tuple(map(float, joint.find("origin").get("xyz").split())) == row.origin.xyz


def test_names_of_rows_may_be_those_that_the_export_would_take():
    rows = tuple(
        replace(row, name=name)
        for row, name in zip(
            arm().rows, ("base_link", "flange", "flange_fixed", "tool0_fixed", "x_joint", "x"), strict=True
        )
    )
    robot = replace(arm(), rows=rows)
    assert_same(robot, ec.export_robot(robot, "urdf").text, ec.random_poses(robot, 5, 1))


def test_the_residual_is_that_of_a_reader_without_the_extension():
    robot = softened(random_robot(np.random.default_rng(27), "modified-dh", prismatic=0.0))
    exported = ec.export_robot(robot, "urdf")
    q = ec.random_poses(robot, 3000, 99)
    position, _, _ = oracle(exported.text, [row.name for row in robot.joints], q)
    for residual in exported.residuals:
        if not residual.refitted:
            real = ec.predict(at_its_base(robot), q, load=residual.load)[0]
            left = np.linalg.norm(real - position, axis=1)
            assert residual.position.mean() == pytest.approx(left.mean(), rel=0.1)
            assert residual.position.mean() > 1e-5


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (('value="30.0"', 'value="31.0"'), "link '2_link', inertial/mass value: found '31.0', but '30.0' in"),
        (('xyz="0.6 0.0 0.0"', 'xyz="0.61 0.0 0.0"'), "joint '3', origin xyz: found '0.61 0.0 0.0', but"),
        (('<joint name="3"', '<joint name="elbow"'), "joint '3' of <elastocal> is missing"),
        (('<parent link="1_link" />', '<parent link="base_link" />'), "joint '2', parent link: found 'base_link', but"),
        (('format="elastocal-robot/1"', 'format="other"'), "format: expected 'elastocal-robot/1', found 'other'"),
        (("mass = 30.0", "mass = -30.0"), "expected 0 or a positive number, found -30.0"),
        (("mass = 30.0", "mass = = 30.0"), "not valid TOML"),
    ],
)
def test_a_urdf_that_was_changed_since_is_refused(edit: tuple[str, str], message: str, tmp_path: Path):
    path = saved(arm(), tmp_path)
    path.write_text(edited(path.read_text(), edit))
    with pytest.raises(InputError) as raised:
        ec.load_robot(path)
    assert message in str(raised.value)


def test_a_changed_urdf_says_what_to_do(tmp_path: Path):
    path = saved(arm(), tmp_path)
    path.write_text(edited(path.read_text(), ('value="30.0"', 'value="31.0"')))
    with pytest.raises(InputError, match="delete <elastocal> if the URDF around it is right, or export the robot anew"):
        ec.load_robot(path)


def test_what_else_is_added_to_the_urdf_does_not_matter(tmp_path: Path):
    path = saved(arm(), tmp_path)
    path.write_text(edited(path.read_text(), ('<link name="base_link" />', '<link name="base_link"><visual/></link>')))
    assert [row.mass for row in ec.load_robot(path).rows] == [row.mass for row in arm().rows]


def test_a_tip_goes_with_no_extension(tmp_path: Path):
    with pytest.raises(InputError, match="--tip: the element <elastocal> holds the whole robot: leave --tip out"):
        ec.load_robot(saved(arm(), tmp_path), tip="tool0")


def test_only_what_the_robot_has_cannot_be_held():
    robot = random_robot(np.random.default_rng(28), "modified-dh", prismatic=0.0)
    bare = replace(at_its_base(robot), gravity=DOWN, base=replace(robot.base, xyz=None, rpy=None))
    assert ec.export_robot(bare, "urdf").cannot_hold == ()
    full = replace(softened(bare), gravity=(0.0, 1.0, -9.81), loads={"b": Payload(1.0)})
    names = list(full.elastic)
    assert ec.export_robot(full, "urdf").cannot_hold == (
        f"compliance of {', '.join(names)}",
        f"joint maps of {names[0]}",
        "payloads b",
        "gravity (0, 1, -9.81) m/s² in the base frame: others take it along -z",
    )


def test_a_comment_cannot_end_early():
    robot = replace(softened(arm()), loads={"-->": Payload(1.0)})
    ElementTree.fromstring(ec.export_robot(robot, "urdf").text)
