"""SDF with cables as legs, written anew as the generators of the Gazebo plug-in write it: six decimals, SDF 1.4."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

FRAMES = np.array(
    [[-3, -2, 3.5], [3, -2, 3.5], [3, 2, 3.5], [-3, 2, 3.5], [-3, -2, 0], [3, -2, 0], [3, 2, 0], [-3, 2, 0]]
)
ANCHORS = np.array([[x, y, z] for z in (-0.2, 0.2) for x, y in ((0.6, -0.3), (-0.6, -0.3), (-0.6, 0.3), (0.6, 0.3))])
HOME, RPY = np.array([0.3, -0.2, 1.4]), (0.1, -0.2, 0.3)
R = Rotation.from_euler("xyz", RPY).as_matrix()


@dataclass
class Dialect:
    """Differences between generators."""

    slide: str = "cable{i}"
    swapped: bool = False  # the second hinge joins the other way round
    effort: float = 900.0
    velocity: float = 10.0
    pose: str = "0 0 0 0 0 0"  # of the model
    name: str = "hall"


def six(*values):
    return " ".join(f"{value:.6f}" for value in np.concatenate([np.ravel(value) for value in values]))


def link(name, pose, mass=0.001, inertia=(0.001, 0.001, 0.001), more=""):
    xx, yy, zz = inertia
    return f"""    <link name="{name}">
      <pose>{pose}</pose>{more}
      <inertial>
        <inertia><ixx>{xx}</ixx><iyy>{yy}</iyy><izz>{zz}</izz><ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia>
        <mass>{mass}</mass>
      </inertial>
    </link>
"""


def joint(name, kind, parent, child, pose, axis, limits=""):
    return f"""    <joint name="{name}" type="{kind}">
      <pose>{pose}</pose>
      <parent>{parent}</parent>
      <child>{child}</child>
      <axis><xyz>{axis}</xyz><limit>{limits}</limit></axis>
    </joint>
"""


def leg(i, dialect):
    """Two hinges, a slide, three hinges, as the generators name and place them."""
    begin, end = FRAMES[i], HOME + R @ ANCHORS[i]
    along = (end - begin) / np.linalg.norm(end - begin)
    turned = Rotation.align_vectors([along], [[0, 0, 1]])[0].as_euler("xyz")
    cylinder = (
        "<visual name='v'><geometry><cylinder><radius>0.005</radius><length>8</length></cylinder></geometry></visual>"
    )
    turn = six(np.zeros(3), turned)
    limits = f"<effort>{dialect.effort}</effort><velocity>{dialect.velocity}</velocity>"
    hinge = "<effort>10000</effort>"
    second = (f"virt_Y{i}", f"virt_X{i}") if dialect.swapped else (f"virt_X{i}", f"virt_Y{i}")
    return "".join(
        [
            link(f"cable{i}", six(end - 4 * along, turned), more=cylinder),
            link(f"virt_X{i}", six(begin, turned)),
            joint(f"rev_X{i}", "revolute", "frame", f"virt_X{i}", turn, "1 0 0", hinge),
            link(f"virt_Y{i}", six(begin, turned)),
            joint(f"rev_Y{i}", "revolute", *second, turn, "0 1 0", hinge),
            joint(dialect.slide.format(i=i), "prismatic", f"virt_Y{i}", f"cable{i}", turn, "0 0 1", limits),
            link(f"virt_Xpf{i}", six(end, turned)),
            joint(f"rev_Xpf{i}", "revolute", "platform", f"virt_Xpf{i}", turn, "1 0 0", hinge),
            link(f"virt_Ypf{i}", six(end, turned)),
            joint(f"rev_Ypf{i}", "revolute", f"virt_Xpf{i}", f"virt_Ypf{i}", turn, "0 1 0", hinge),
            joint(f"rev_Zpf{i}", "revolute", f"cable{i}", f"virt_Ypf{i}", turn, "0 0 1", hinge),
        ]
    )


def text(dialect=None, legs=8):
    dialect = dialect or Dialect()
    box = "<visual name='b'><geometry><box><size>1.2 0.6 0.4</size></box></geometry></visual>"
    return "".join(
        [
            f'<?xml version="1.0"?>\n<sdf version="1.4">\n  <model name="{dialect.name}">\n',
            f"    <pose>{dialect.pose}</pose>\n",
            link("frame", "0 0 0 0 0 0", 100000, (1e5, 1e5, 1e5)),
            link("platform", six(HOME, RPY), 150, (6.5, 20, 22.5), box),
            *(leg(i, dialect) for i in range(legs)),
            '    <plugin name="cdpr_plugin" filename="libcdpr_plugin.so"/>\n  </model>\n</sdf>\n',
        ]
    )
