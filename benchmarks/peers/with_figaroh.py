"""FIGAROH: pinocchio's kinematics from a URDF, a configuration in YAML, frames aligned in closed form."""

# user code: default, tolerances, documented elastic, best
import numpy as np
from exchange import Arm, Predict, main
from figaroh.calibration.base_calibration import BaseCalibration
from figaroh.calibration.calibration_tools import calc_updated_fkm
from figaroh.tools.robot import Robot

CONFIGURATION = """
robot:
  name: arm
tasks:
  calibration:
    parameters:
      calibration_level: full_params
      {parameters}
    kinematics:
      base_frame: universe
      tool_frame: flange
    measurements:
      markers:
        - measurable_dof: [true, true, true, false, false, false]
      poses:
        base_pose: [0, 0, 0, 0, 0, 0]
        tool_pose: [0, 0, 0, 0, 0, 0]
    data:
      source_file: {data}
"""


class Calibration(BaseCalibration):  # noqa: D101
    def cost_function(self, var):  # noqa: D102
        predicted = calc_updated_fkm(self.model, self.data, var, self.q_measured, self.calib_config)
        return self._compute_logmap_residuals(self.PEE_measured, predicted)


# end of user code


def prepared(arm: Arm, parameters: str, data: str, known_baseframe: bool) -> Calibration:
    """The calibration with its data read and its parameters chosen."""
    # user code: default, tolerances, documented elastic, best
    path = arm.scratch / "calibration.yaml"
    path.write_text(CONFIGURATION.format(parameters=parameters, data=data), encoding="utf-8")
    robot = Robot(str(arm.folder / "robot.urdf"), package_dirs=str(arm.folder))
    calibration = Calibration(robot, str(path))
    calibration.calib_config["known_baseframe"] = known_baseframe
    calibration.calib_config["known_tipframe"] = False
    calibration.initialize()
    return calibration
    # end of user code


def solved(arm: Arm, calibration: Calibration) -> Predict:
    """The fit."""
    # user code: default, tolerances, documented elastic, best
    calibration.solve(enable_logging=False)

    def predict(q):
        configuration = dict(calibration.calib_config, NbSample=len(q))
        found = calc_updated_fkm(calibration.model, calibration.data, calibration.var_, q, configuration)
        return found.reshape(3, -1).T

    # end of user code
    if calibration.STATUS != "CALIBRATED":
        arm.notes.append(f"status {calibration.STATUS}")
    # user code: default, tolerances, documented elastic, best
    return predict
    # end of user code


def default(arm: Arm) -> Predict:
    """Its default level and method: full_params, structural."""
    # user code: default
    calibration = prepared(arm, "include_non_geometric: false", arm.folder / "figaroh.csv", False)
    return solved(arm, calibration)
    # end of user code


def tolerances(arm: Arm) -> Predict:
    """Priors of the sizes that the errors have: its method for the best prediction where tolerances are known."""
    # user code: tolerances
    priors = "{translation: 0.5e-3, rotation: 0.5e-3, joint_offset: 0.5e-3}"
    calibration = prepared(arm, f"estimation: {{method: map, priors: {priors}}}", arm.folder / "figaroh.csv", False)
    return solved(arm, calibration)
    # end of user code


def documented_elastic(arm: Arm) -> Predict:
    """Its elasticity as documented, with `known_baseframe = True`: points taken to the base frame beforehand.

    With an unknown base frame the names of its six parameters overwrite those of the six compliances.
    """
    # user code: documented elastic
    base = arm.instrument_T_base
    measured = arm.table("figaroh.csv")
    measured[:, 6:] = (measured[:, 6:] - base[:3, 3]) @ base[:3, :3]
    header = ",".join([*(f"joint_{i}" for i in range(1, 7)), "x1", "y1", "z1"])
    np.savetxt(arm.scratch / "aligned.csv", measured, delimiter=",", header=header, comments="", fmt="%.17g")
    calibration = prepared(arm, "include_non_geometric: true", arm.scratch / "aligned.csv", True)
    predict = solved(arm, calibration)
    return lambda q: predict(q) @ base[:3, :3].T + base[:3, 3]
    # end of user code


def best(arm: Arm) -> Predict:
    """Parameters chosen by its method `excitation`, and the compliances of joints 2 and 3 added after that.

    Its documents say that only `structural` goes with elasticity; the model itself has no such limit.
    """
    # user code: best
    calibration = prepared(arm, "estimation: {method: excitation}", arm.folder / "figaroh.csv", False)
    calibration.calib_config["non_geom"] = True
    calibration.calib_config["param_name"] += ["k_RZ_joint_2", "k_RZ_joint_3"]
    return solved(arm, calibration)
    # end of user code


if __name__ == "__main__":
    main(
        {
            "default": default,
            "tolerances": tolerances,
            "documented elastic": documented_elastic,
            "best": best,
        }
    )
