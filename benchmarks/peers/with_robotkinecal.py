"""robotkinecal: product of exponentials, from a URDF, on measured points."""

# user code: default, best
import numpy as np
import roboticstoolbox as rtb
from exchange import Arm, Predict, main
from robotkinecal import SerialRobotKineCal

# end of user code


def fit(arm: Arm, base: np.ndarray) -> Predict:
    """Fit points in the base frame of the nominal robot; its end effector is the aligned target."""
    # user code: default, best
    measured = arm.table("fit.csv")
    points = (measured[:, 6:] - base[:3, 3]) @ base[:3, :3]
    nominal = rtb.ERobot.URDF(str(arm.folder / "robot.urdf"))
    calibration = SerialRobotKineCal(nominal, "target")
    calibration.set_observations(list(measured[:, :6]), list(points))
    result = calibration.solve()
    # end of user code
    if not result.has_converged:
        arm.notes.append("it says that it diverges" if result.is_diverging else "not converged")

    # user code: default, best
    def predict(q):
        points = [calibration.forward_kinematics(calibration.N_JOINTS + 1, pose).t for pose in q]
        return np.array(points) @ base[:3, :3].T + base[:3, 3]

    return predict
    # end of user code


def default(arm: Arm) -> Predict:
    """As its documents have it, with the points as measured: in the instrument's frame."""
    # user code: default
    return fit(arm, np.eye(4))
    # end of user code


def best(arm: Arm) -> Predict:
    """Points taken to the nominal robot's base frame beforehand: then its axes can take up all the rest."""
    # user code: best
    return fit(arm, arm.instrument_T_base)
    # end of user code


if __name__ == "__main__":
    np.random.seed(0)  # noqa: NPY002 - it draws bases of its parameters from here
    main({"default": default, "best": best})
