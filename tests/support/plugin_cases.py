"""Robots as the Gazebo plug-in, its successor and WireX write them, made anew."""

from __future__ import annotations

POINTS = """points:
- {frame: [-2.0, 1.0, 3.0], platform: [0.2, 0.15, 0.125]}
- {frame: [2.0, 1.0, 3.0], platform: [-0.2, 0.15, -0.125]}
- {frame: [-2.0, -1.0, 3.0], platform: [-0.2, -0.15, 0.125]}
- {frame: [2.0, -1.0, 3.0], platform: [0.2, -0.15, -0.125]}
"""
SUCCESSOR = f"""cable: {{mass: 0.001, radius: 0.005}}
frame: {{type: poles, color: Grey, lower: [-2, -1, 0], upper: [2, 1, 3], radius: 0.02}}
joints:
  actuated: {{damping: 1, effort: 900, min: 5, velocity: 10}}
  passive: {{damping: 0.01, effort: 1000, velocity: 10}}
platform:
  {{type: box, color: Turquoise, mass: 15, inertia: [0.5, 0.6, 0.7, 0.01, 0.02, 0.03], size: [0.4, 0.3, 0.25],
   position: {{xyz: [0.1, 0.2, 0.3], rpy: [0.1, 0.2, 0.3]}}}}
{POINTS}sim_cables: true
"""
THESIS = f"""controllers:
  config: {{joints: {{command: cable_command}}}}
model:
  cable: {{mass: 0.001, radius: 0.005}}
  global_frame: {{position: [0, 0, 1.5], rotation: [0, 0, 0]}}
  joints:
    actuated: {{damping: 1, effort: 6500, min: 5, velocity: 100}}
  platform:
    {{inertial: {{xx: 9, xy: 0, xz: 0, yy: 9, yz: 0, zz: 9}}, lower: [-0.2, -0.15, -0.125], upper: [0.2, 0.15, 0.125],
     mass: 50.0, position: {{rpy: [0, 0, 0], xyz: [0.0, 0.0, 1.5]}}, type: box}}
  {POINTS.replace(chr(10), chr(10) + "  ")}
"""
TRAJECTORY = """time: {t0: 0.0, t1: 4.0, t4: 15.0}
position: {A: [0.1, 0.2, 0.3], B: [0.5, 0.2, 1.0], C: [0, 0, 1]}
gain: {Kp: 20, Kd: 10}
parameter: {ab: 0.001}
"""
WIREX = """<models version="0.31"><robot name="Crane 1" author="nobody" motionpattern="3R3T"><geometry>
{chains}</geometry>
<platform name="p" mass="20"><inertiatensor Ixx="3" Iyy="4" Izz="5" Ixy="0.1"/>
<centerofgravity x="0.1" y="0" z="-0.2"/></platform></robot>
<cable name="c" elasticity="1.1e9" radius="0.003" breaking_load="9000" weight="0.02" damping="1"/>
<winch name="W"><cable f_max="700" max_velocity="2"/></winch></models>"""
CHAIN = (
    '<chain id="{id}" winchtype="W"><base x="{x}" y="{y}" z="3" a11="1" a22="0" a23="-1" a32="1" a33="0" radius="{r}"/>'
    '<platform x="0.1" y="{y}" z="0"/></chain>\n'
)


def wirex(radius=0.0, **change):
    rows = [(-2, -1), (2, -1), (2, 1), (-2, 1)]
    chains = "".join(CHAIN.format(id=k + 1, x=x, y=y, r=radius) for k, (x, y) in enumerate(rows))
    text = WIREX.format(chains=chains)
    for old, new in change.items():
        text = text.replace(old, new)
    return text
