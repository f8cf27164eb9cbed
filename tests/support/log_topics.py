"""Topics of a log and their types, and vectors of its messages."""

from __future__ import annotations

from typing import Any

FULL_RATE = {
    "/cdpr/cable_states": "sensor_msgs/msg/JointState",
    "/cdpr/platform/pose": "geometry_msgs/msg/PoseStamped",
    "/cdpr/platform/pose_desired": "geometry_msgs/msg/PoseStamped",
    "/cdpr/platform/twist": "geometry_msgs/msg/TwistStamped",
    "/cdpr/platform/twist_desired": "geometry_msgs/msg/TwistStamped",
    "/cdpr/platform/acceleration_desired": "geometry_msgs/msg/AccelStamped",
    "/cdpr/platform/wrench": "geometry_msgs/msg/WrenchStamped",
    "/cdpr/solver": "std_msgs/msg/Float64MultiArray",
    "/cdpr/platform/external_wrench": "geometry_msgs/msg/WrenchStamped",
    "/cdpr/energy": "std_msgs/msg/Float64MultiArray",
}
PICTURES = {
    "/clock": "rosgraph_msgs/msg/Clock",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/cdpr/markers": "visualization_msgs/msg/MarkerArray",
}


def xyz(vector: Any) -> list[float]:
    return [vector.x, vector.y, vector.z]


def wxyz(q: Any) -> list[float]:
    return [q.w, q.x, q.y, q.z]
