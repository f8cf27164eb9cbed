"""A point mass on four elastic cables, which a short wrench pushes up until they are slack."""

from __future__ import annotations


def pushed_point(tension_max: float, duration: float, time: float) -> str:
    """Return a scenario: largest tension (N), duration of the run and time of the wrench (s)."""
    return f"""
robot:
  name: slacky
  dof: [x, y, z]
  platform: {{mass: 10}}
  tension: {{min: 5, max: {tension_max:g}}}
  home: {{position: [0, 0, 1.0]}}
  cable: {{model: elastic, axial_stiffness: 50000, damping: 50}}
  winch: {{drum_radius: 0.05, inertia: 0.002}}
  cables:
  - {{frame: [-2, -2, 3], platform: [0, 0, 0]}}
  - {{frame: [2, -2, 3], platform: [0, 0, 0]}}
  - {{frame: [2, 2, 3], platform: [0, 0, 0]}}
  - {{frame: [-2, 2, 3], platform: [0, 0, 0]}}
simulation: {{backend: reference, duration: {duration:g}, control_step: 0.001}}
trajectory: {{type: hold}}
events: [{{type: wrench, time: {time:g}, duration: 0.05, force: [0, 0, 1500]}}]
"""
