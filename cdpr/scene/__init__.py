"""View model: conversion of run rows or poses into geometry and colours, independent of any viewer.

- `Subject`: pose-independent part of a robot: frame, anchors, exits and the platform's shape.
- `Pictures`: a subject at n poses: cable lines, tensions and states, desired poses and forces.
- `SensorDrawing`: frustum, rays and points of a sensor.
- `solid`: the platform's shape as triangles and edges.
- `colours`: colours of cables, axes and tensions in light and dark mode.

Reports, pages, log markers and windows use this model. Lengths are in m, in world axes unless stated otherwise.
"""

from cdpr.scene.pictures import Pictures, State, pictures
from cdpr.scene.sensors import SensorDrawing
from cdpr.scene.shapes import Solid, solid
from cdpr.scene.subject import Subject

__all__ = ["Pictures", "SensorDrawing", "Solid", "State", "Subject", "pictures", "solid"]
