"""What docs/benchmarks.md says in words."""

from __future__ import annotations

INTRODUCTION = """\
# Benchmark against the peers

Calibration packages for Python on the same simulated arms. This page and its figure are written by

```
python benchmarks/peers/run.py
```

from a run on {date} (Python {python}, {machine}); every fit is a row of `benchmarks/peers/results.csv`.

Four kinds of arm, 20 of each: the built-in 1.45 m example arm with normal errors of 0.5 mm and 0.5 mrad on
every length and angle, an instrument and a target somewhere, and joints 2 and 3 rigid, or giving way in
proportion to their load, or with a step or a kink at a transition torque (2.5 times stiffer above it). 60
positions of one target are fitted, with 0.03 mm noise per axis, and 200 others predicted. The masses are
known, base and tool are not; robotkinecal and pybotics are given frames that elastocal has aligned, where it
says so below."""

HOW = """\
Each tool runs in a virtual environment of its own, each fit in a process of its own. All get the same poses and
readings, in the form that they read; "default" is what their documents show first, "best" the best that their
documents and source let us find. Scripts: `benchmarks/peers/with_*.py`.

- **elastocal**. Default: `calibrate`. Best: `compare` on joints 2 and 3, then `calibrate` with the law it
  recommends.
- **figaroh** finds base and tool itself, in closed form. Default: level `full_params`, method `structural`.
  Best: its method `excitation` chooses the geometry, then elasticity is switched on and the compliances of
  joints 2 and 3 are added to the list of parameters by hand. As documented, with `include_non_geometric`, the
  six names of an unknown base frame overwrite the six compliances of a six-joint arm, so `known_baseframe=True`
  is needed, and measurements in the robot's base frame; and only `structural` may be used, which on these
  arms leaves out two or three parameters that the data do tell. Its fit of that is under "other settings".
- **robotkinecal** expects the end effector measured relative to the base. Default: measurements as they are, in
  the instrument's frame. Best: taken to the nominal robot's base frame by our alignment beforehand; what is
  left of the base its axes take up. The target's place on the nominal tool is in the URDF, also from our
  alignment, in both settings.
- **pybotics** gives the kinematics and a vector of parameters; the fit is SciPy's. Default: its calibration
  example, joint offsets fitted to distances; it fits no base, so it is given our aligned base and tool. Best:
  all parameters, base and tool, coordinates instead of distances as residuals, from our alignment. Modified DH
  cannot tilt the third axis against the second, which is parallel to it: a seventh link that does not move
  gives Hayati's parameter, and its joint is always zero."""

BELOW = {
    "errors": """\
Mean error [mm], averaged over the arms / largest error at any held-out pose of any arm. Errors are distances
from where the simulated arm really is.""",
    "effort": """\
Seconds of the processor, one thread, medians over the arms, on a machine that other programs shared: compare
them with one another. A fit includes reading the files; if it took less than a second, it is timed anew with all
libraries loaded. The process has the start of Python and all imports. Lines are those marked as user code in the
scripts, configuration included, without blank lines and comments; the alignment that
some are given is not counted.""",
    "failed": """\
- robotkinecal stops at the first step that makes the residual larger. From the identity as the base, metres and
  radians away, there often is one; where there is none, it ends where it does from an aligned base.
- pybotics' example fits joint offsets only: what is wrong with lengths and twists stays, and an offset fitted
  in its place can make an arm worse.
- figaroh's `structural` chooses parameters at random configurations, for the flange instead of the measured
  point, and leaves out some that the data tell; its documents say so, and offer `excitation` and others.""",
    "others": """\
- figaroh, tolerances: method `map`, told the standard deviations that the errors were drawn with. The best for
  rigid arms in its documents; it does not go with elasticity.
- figaroh, documented elastic: `include_non_geometric` with `known_baseframe=True`, measurements taken to the
  base frame by our alignment.
- pybotics, unaligned: as best, from a base and a tool at the identity. It needs no alignment.
- pybotics, distances: all parameters through its own `optimize_accuracy`, whose residuals are distances. They
  have no derivative at zero, so that the fit is slow and stops short, and there is no Hayati parameter.""",
}

CAPABILITIES = """\
| | elastocal | figaroh | robotkinecal | pybotics |
|---|---|---|---|---|
| robot | DH table, modified DH table, URDF | URDF; trees, floating bases | URDF, Robotics Toolbox models | modified DH |
| joints | revolute, prismatic, coupled | pinocchio's | revolute | revolute, prismatic |
| observations | points, poses, distances; several targets, payloads, stations | points, poses, single coordinates; several targets; cameras | points, poses | points, distances between poses |
| base and tool | from no first guess | from no first guess | near the truth | fitted from a guess |
| compliance | linear, step, hinge, cubic, any element | linear, joints | no | no |
| gears' errors | joint maps | no | no | no |
| which parameters | by theory, with reasons | five methods, cross-validation among them | by rank | by the user's mask |
| uncertainty | parameters, torques, positions; bootstrap | parameters | joints | no |
| outliers | robust losses, named rows | threshold | no | no |
| choice of poses | five criteria | D-optimal | no | no |
| masses, inertias, friction identified | no | yes, with trajectories that excite them | no | joint torques only |

From the source and documents of the versions above. Where you need the dynamics, a humanoid, a mobile base or a
camera in the chain, take FIGAROH: elastocal does none of them. Where the robot is rigid and the measurements
are in its base frame, robotkinecal does the job in a dozen lines.

[robot_calibration](https://github.com/mikeferguson/robot_calibration) (ROS 2, C++) was not run: it calibrates
joint offsets, frames and cameras from a robot's own sensors, not from a tracker, and its README names no
compliance."""  # noqa: E501 - a table

CAVEAT = """\
Simulated arms are made by elastocal, so its model is the true one wherever it has the law; so is that of the
others on rigid arms, and FIGAROH's on linear ones, up to where the load is taken. What is left on a real robot
is in the README."""
