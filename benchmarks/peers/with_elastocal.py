"""elastocal: rigid, and with the law that `compare` recommends for joints 2 and 3."""

# user code: default, best
from exchange import Arm, Predict, main

import elastocal as ec

# end of user code


def default(arm: Arm) -> Predict:
    """Geometry, base and tool."""
    # user code: default
    robot = ec.load_robot(arm.folder / "robot.toml")
    data = ec.load_measurements(arm.folder / "fit.csv", robot)
    result = ec.calibrate(robot, data)
    return lambda q: ec.predict(result.robot, q)[0]
    # end of user code


def best(arm: Arm) -> Predict:
    """The recommended of rigid, linear, step, hinge and cubic; it is not told which is right."""
    # user code: best
    robot = ec.load_robot(arm.folder / "robot.toml")
    data = ec.load_measurements(arm.folder / "fit.csv", robot)
    law = ec.compare(robot, data, elastic=["2", "3"], folds=None).recommended
    elastic = {} if law == "rigid" else {"2": law, "3": law}
    result = ec.calibrate(robot, data, elastic=elastic)
    # end of user code
    arm.notes.append(f"recommended: {law}")
    # user code: best
    return lambda q: ec.predict(result.robot, q)[0]
    # end of user code


if __name__ == "__main__":
    main({"default": default, "best": best})
