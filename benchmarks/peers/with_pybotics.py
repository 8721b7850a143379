"""pybotics: modified DH, fitted with SciPy through its OptimizationHandler."""

# user code: default, best, unaligned, distances
import numpy as np
from exchange import Arm, Predict, main
from pybotics.kinematic_chain import MDHKinematicChain
from pybotics.optimization import OptimizationHandler, optimize_accuracy
from pybotics.robot import Robot
from pybotics.tool import Tool
from scipy.optimize import least_squares

# end of user code


def default(arm: Arm) -> Predict:
    """The way of its calibration example: joint offsets, on distances. It fits no base: it is given the aligned one."""
    # user code: default
    measured = arm.table("fit.csv")
    tool = Tool()
    tool.position = arm.flange_p_target
    chain = MDHKinematicChain.from_parameters(arm.table("mdh.csv"))
    mask = np.zeros((6, 4), dtype=bool)
    mask[:, 2] = True
    handler = OptimizationHandler(Robot(chain, tool, arm.instrument_T_base), mask.ravel())
    start = handler.generate_optimization_vector()
    found = least_squares(optimize_accuracy, start, args=(handler, measured[:, :6], measured[:, 6:]))
    handler.apply_optimization_vector(found.x)
    return lambda q: np.array([handler.robot.fk(pose)[:3, 3] for pose in q])
    # end of user code


def distances(arm: Arm) -> Predict:
    """All of the chain, the tool's point and the world frame, on distances, as its optimize_accuracy has them."""
    # user code: distances
    measured = arm.table("fit.csv")
    tool = Tool()
    tool.position = arm.flange_p_target
    chain = MDHKinematicChain.from_parameters(arm.table("mdh.csv"))
    point = [True, True, True, False, False, False]
    handler = OptimizationHandler(Robot(chain, tool, arm.instrument_T_base), True, point, True)
    start = handler.generate_optimization_vector()
    arguments = (handler, measured[:, :6], measured[:, 6:])
    found = least_squares(optimize_accuracy, start, args=arguments, x_scale="jac")
    handler.apply_optimization_vector(found.x)
    return lambda q: np.array([handler.robot.fk(pose)[:3, 3] for pose in q])
    # end of user code


def fit_coordinates(arm: Arm, base: np.ndarray, point: np.ndarray) -> Predict:
    """All parameters, on coordinates, from a base and a target point.

    Joints 2 and 3 are parallel, where modified DH cannot tilt the third axis out of the plane: a link that does not
    move, Rx(0) Tx(a) Rz(90 deg), gives the next one's alpha the sense of Hayati's beta.
    """
    # user code: best, unaligned
    measured = arm.table("fit.csv")
    q, positions = measured[:, :6], measured[:, 6:]
    tool = Tool()
    tool.position = point
    rows = arm.table("mdh.csv")
    alpha, a, theta, d = rows[2]
    rows = np.vstack([rows[:2], [alpha, a, np.pi / 2, 0.0], [0.0, 0.0, theta - np.pi / 2, d], rows[3:]])
    mask = np.ones(rows.shape, dtype=bool)
    mask[2, 2:] = mask[3, 1] = False
    chain = MDHKinematicChain.from_parameters(rows)
    handler = OptimizationHandler(Robot(chain, tool, base), mask.ravel(), [True] * 3 + [False] * 3, True)

    def predict(q):
        return np.array([handler.robot.fk(pose)[:3, 3] for pose in np.insert(q, 2, 0.0, axis=1)])

    def residual(vector):
        handler.apply_optimization_vector(vector)
        return (predict(q) - positions).ravel()

    found = least_squares(residual, handler.generate_optimization_vector(), x_scale="jac")
    handler.apply_optimization_vector(found.x)
    # end of user code
    if not found.success:
        arm.notes.append(f"not converged: {found.message}")
    # user code: best, unaligned
    return predict
    # end of user code


def best(arm: Arm) -> Predict:
    """From the aligned frames."""
    # user code: best
    return fit_coordinates(arm, arm.instrument_T_base, arm.flange_p_target)
    # end of user code


def unaligned(arm: Arm) -> Predict:
    """From a base and a tool at the identity."""
    # user code: unaligned
    return fit_coordinates(arm, np.eye(4), np.zeros(3))
    # end of user code


if __name__ == "__main__":
    main({"default": default, "best": best, "unaligned": unaligned, "distances": distances})
