"""A robot with seven cables that tests of the window edit: what the thesis's window shows is all there."""

ROBOT = """\
# Seven cables, to be edited.
name: seven
dof: [x, y, z, rx, ry, rz]
platform:
  mass: 20                                           # kg, as weighed
  inertia: [0.866667, 0.866667, 1.2, 0, 0, 0]        # kg m^2: a homogeneous box
  shape: {box: [0.6, 0.6, 0.4]}                      # m
tension: {min: 10, max: 500}                         # N
home: {position: [0, 0, 1.5]}                        # m
cables:                                              # m: A_i in the world, B_i on the platform
- {frame: [-2, -2, 3], platform: [-0.3, -0.15, 0.2]}   # the first
- {frame: [-2, 2, 3], platform: [-0.3, -0.3, 0]}
- {frame: [2, -2, 3], platform: [-0.3, -0.3, 0.1]}
- {frame: [2, 2, 3], platform: [0.3, 0.3, -0.2]}
- {frame: [-2, 2, 0], platform: [-0.3, 0.3, 0.2]}
- {frame: [-2, 2, 0], platform: [0.15, 0, -0.2]}
- {frame: [2, -2, 1], platform: [0.3, 0.3, -0.2]}      # the last
"""

SCENARIO = """\
# It rises and comes back to rest.
robot: seven.yaml                  # beside this file
simulation: {duration: 30.0, control_step: 0.001, physics_step: 0.001}
trajectory:
  type: quintic
  duration: 1.0                    # s
  to: {position: [0.1, 0, 1.6]}    # m
controller: {type: computed_torque, kp: 100, kd: 20}   # stiff enough
solver: {type: qp}
"""
