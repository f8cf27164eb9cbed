"""The view model: from a row of a run, or a pose, to primitives and colours; it knows no viewer.

- `Subject`: what of a robot is drawn whatever its pose: frame, anchors, exits, the platform's shape.
- `Pictures`: the subject at n poses: where each cable runs, its tension and its state, the desired pose, the force.
- `solid`: the platform's shape as triangles and edges.
- `colours`: which colour stands for which cable, axis and tension, on light and on dark ground.

Report, page, markers of logs and windows all draw from these: lengths in m, world axes unless said.
"""

from cdpr.view.pictures import Pictures, State, pictures
from cdpr.view.shapes import Solid, solid
from cdpr.view.subject import Subject

__all__ = ["Pictures", "Solid", "State", "Subject", "pictures", "solid"]
