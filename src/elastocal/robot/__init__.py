"""The robot: rows, frames, masses and compliance, and how they are put together into a chain."""

from elastocal.robot.assembly import Assembly, Drive, assemble
from elastocal.robot.frames import FRAME_KEYS, Frame
from elastocal.robot.model import Compliance, JointMap, Payload, Robot, harmonics
from elastocal.robot.rows import CONVENTIONS, DH_KEYS, JOINT_KEYS, ROTATION_KEYS, Convention, Joint, Row

__all__ = [
    "CONVENTIONS",
    "DH_KEYS",
    "FRAME_KEYS",
    "JOINT_KEYS",
    "ROTATION_KEYS",
    "Assembly",
    "Compliance",
    "Convention",
    "Drive",
    "Frame",
    "Joint",
    "JointMap",
    "Payload",
    "Robot",
    "Row",
    "assemble",
    "harmonics",
]
