"""Stand-ins for the interfaces of ROS 2 of a generated node: messages with the fields of theirs, no others."""

from __future__ import annotations

import sys
from types import ModuleType, SimpleNamespace
from typing import Any, ClassVar


class Message:
    """Common base of messages: values for their fields, of the field's type if that is simple."""

    fields: ClassVar[dict[str, Any]]

    def __init__(self, **values):
        for key, make in self.fields.items():
            object.__setattr__(self, key, make())
        for key, value in values.items():
            setattr(self, key, value)

    def __setattr__(self, key, value):
        if key not in self.fields:
            raise AttributeError(f"{type(self).__name__} has no field {key}")
        kind = self.fields[key]
        if kind in (float, int, bool, str) and type(value) is not kind:
            raise TypeError(f"{type(self).__name__}.{key} is a {kind.__name__}, not {value!r}")
        object.__setattr__(self, key, value)


def message(title, /, **fields):
    """A type whose instances have these fields alone; each begins as its type does."""
    return type(title, (Message,), {"fields": fields})


Time = message("Time", sec=int, nanosec=int)
Header = message("Header", stamp=Time, frame_id=str)
Vector3 = message("Vector3", x=float, y=float, z=float)
Quaternion = message("Quaternion", x=float, y=float, z=float, w=float)
Pose = message("Pose", position=Vector3, orientation=Quaternion)
Pair = message("Twist", linear=Vector3, angular=Vector3)
Wrench = message("Wrench", force=Vector3, torque=Vector3)
Transform = message("Transform", translation=Vector3, rotation=Quaternion)
Request = message("Request", pose=Pose, wrench=Wrench)
Response = message("Response", feasible=bool, message=str, tension=list, residual=float)
TriggerResponse = message("TriggerResponse", success=bool, message=str)

TYPES = {
    "builtin_interfaces.msg": {"Time": Time},
    "geometry_msgs.msg": {
        "PoseStamped": message("PoseStamped", header=Header, pose=Pose),
        "TwistStamped": message("TwistStamped", header=Header, twist=Pair),
        "WrenchStamped": message("WrenchStamped", header=Header, wrench=Wrench),
        "TransformStamped": message("TransformStamped", header=Header, child_frame_id=str, transform=Transform),
    },
    "rosgraph_msgs.msg": {"Clock": message("Clock", clock=Time)},
    "sensor_msgs.msg": {
        "JointState": message("JointState", header=Header, name=list, position=list, velocity=list, effort=list)
    },
    "std_srvs.srv": {"Trigger": SimpleNamespace(Request=object, Response=TriggerResponse)},
    "tf2_msgs.msg": {"TFMessage": message("TFMessage", transforms=list)},
}


class Publisher:
    def __init__(self, kind):
        self.kind, self.sent = kind, []

    def publish(self, what):
        assert type(what) is self.kind
        self.sent.append(what)


class Node:
    """Stand-in for rclpy.node.Node, without ROS; `given` are the parameters of a launch file."""

    given: ClassVar[dict[str, object]] = {}

    def __init__(self, name):
        self.name, self.published, self.subscribed, self.services, self.said = name, {}, {}, {}, []

    def declare_parameter(self, name, value):
        value = self.given.get(name, value)
        return SimpleNamespace(value=value)

    def create_publisher(self, kind, topic, depth):
        self.published[topic] = Publisher(kind)
        return self.published[topic]

    def create_subscription(self, kind, topic, callback, depth):
        self.subscribed[topic] = callback

    def create_service(self, kind, name, callback):
        self.services[name] = lambda request: callback(request, kind.Response())

    def create_timer(self, period, callback):
        return SimpleNamespace(period=period, tick=callback)

    def get_logger(self):
        return SimpleNamespace(**dict.fromkeys(("info", "warning", "error"), self.said.append))

    def destroy_node(self):
        self.destroyed = True


def install(monkeypatch, package, share, spin):
    """Put all modules in place; `spin` gets the node."""
    types = {**TYPES, f"{package}_interfaces.srv": {}}
    types[f"{package}_interfaces.srv"]["DistributeWrench"] = SimpleNamespace(Request=Request, Response=Response)
    types["ament_index_python.packages"] = {"get_package_share_directory": lambda name: str(share)}
    types["rclpy.node"] = {"Node": Node}
    types["launch"] = {"LaunchDescription": list}
    types["launch_ros.actions"] = {"Node": lambda **said: said}
    nothing = lambda *_: None  # noqa: E731
    types["rclpy"] = {"init": nothing, "shutdown": nothing, "try_shutdown": nothing, "spin": spin}
    for name, content in types.items():
        parts = name.split(".")
        for depth in range(1, len(parts) + 1):
            whole = ".".join(parts[:depth])
            if not isinstance(sys.modules.get(whole), ModuleType) or whole == name:
                monkeypatch.setitem(sys.modules, whole, sys.modules.get(whole) or ModuleType(whole))
        for key, value in content.items():
            monkeypatch.setattr(sys.modules[name], key, value, raising=False)
