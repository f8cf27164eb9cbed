"""The standard ROS 2 messages that a log holds: their fields, their schema text and their bytes (CDR)."""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from functools import cache, lru_cache
from typing import Any

# Field lists as in the .msg files of ROS 2 Humble to Jazzy, without constants and comments.
DEFINITIONS = {
    "builtin_interfaces/Duration": "int32 sec\nuint32 nanosec",
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec",
    "geometry_msgs/Accel": "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular",
    "geometry_msgs/AccelStamped": "std_msgs/Header header\ngeometry_msgs/Accel accel",
    "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Pose": "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation",
    "geometry_msgs/PoseStamped": "std_msgs/Header header\ngeometry_msgs/Pose pose",
    "geometry_msgs/Quaternion": "float64 x\nfloat64 y\nfloat64 z\nfloat64 w",
    "geometry_msgs/Transform": "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation",
    "geometry_msgs/TransformStamped": (
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform"
    ),
    "geometry_msgs/Twist": "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular",
    "geometry_msgs/TwistStamped": "std_msgs/Header header\ngeometry_msgs/Twist twist",
    "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Wrench": "geometry_msgs/Vector3 force\ngeometry_msgs/Vector3 torque",
    "geometry_msgs/WrenchStamped": "std_msgs/Header header\ngeometry_msgs/Wrench wrench",
    "rosgraph_msgs/Clock": "builtin_interfaces/Time clock",
    "sensor_msgs/CompressedImage": "std_msgs/Header header\nstring format\nuint8[] data",
    "sensor_msgs/JointState": (
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort"
    ),
    "std_msgs/ColorRGBA": "float32 r\nfloat32 g\nfloat32 b\nfloat32 a",
    "std_msgs/Float64MultiArray": "std_msgs/MultiArrayLayout layout\nfloat64[] data",
    "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id",
    "std_msgs/MultiArrayDimension": "string label\nuint32 size\nuint32 stride",
    "std_msgs/MultiArrayLayout": "std_msgs/MultiArrayDimension[] dim\nuint32 data_offset",
    "tf2_msgs/TFMessage": "geometry_msgs/TransformStamped[] transforms",
    "visualization_msgs/Marker": (
        "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\ngeometry_msgs/Pose pose\n"
        "geometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\nbuiltin_interfaces/Duration lifetime\n"
        "bool frame_locked\ngeometry_msgs/Point[] points\nstd_msgs/ColorRGBA[] colors\n"
        "string texture_resource\nsensor_msgs/CompressedImage texture\n"
        "visualization_msgs/UVCoordinate[] uv_coordinates\nstring text\nstring mesh_resource\n"
        "visualization_msgs/MeshFile mesh_file\nbool mesh_use_embedded_materials"
    ),
    "visualization_msgs/MarkerArray": "visualization_msgs/Marker[] markers",
    "visualization_msgs/MeshFile": "string filename\nuint8[] data",
    "visualization_msgs/UVCoordinate": "float32 u\nfloat32 v",
}

_FORMATS = {"bool": "<?", "uint8": "<B", "int32": "<i", "uint32": "<I", "float32": "<f", "float64": "<d"}
ENCAPSULATION = b"\0\1\0\0"  # plain CDR, little-endian; alignment counts from its end


@cache
def fields(kind: str) -> tuple[tuple[str, str], ...]:
    """Return (type, name) of each field of a message type such as "geometry_msgs/Pose"."""
    pairs = (line.split() for line in DEFINITIONS[kind].splitlines())
    return tuple((field_kind, name) for field_kind, name in pairs)


@cache
def schema_text(kind: str) -> str:
    """Return the definition of a type and of all that it is made of, in MCAP's `ros2msg` form."""
    needed = [kind]
    for known in needed:  # grows while it is walked
        parts = (part.removesuffix("[]") for part, _ in fields(known))
        needed += [part for part in dict.fromkeys(parts) if part in DEFINITIONS and part not in needed]
    rule = "=" * 80
    return "\n".join([DEFINITIONS[kind], *(f"{rule}\nMSG: {name}\n{DEFINITIONS[name]}" for name in needed[1:]), ""])


def encode(kind: str, value: Mapping[str, Any]) -> tuple[bytes, Mapping[str, int]]:
    """Return the CDR bytes of a message, and where in them each field begins.

    Fields left out of `value` are zero or empty. A field is named by its path, "pose.position.x" or
    "markers.0.points"; of a message or a sequence, the place is that of its first number.
    """
    return _encoded(kind, json.dumps(value))


@lru_cache(maxsize=64)
def _encoded(kind: str, content: str) -> tuple[bytes, Mapping[str, int]]:
    """Encode a message's content, given as JSON: the cases of a study share what is constant in theirs."""
    data = bytearray(ENCAPSULATION)
    places: dict[str, int] = {}

    def number(form: str, value: Any) -> int:
        data.extend(bytes((len(ENCAPSULATION) - len(data)) % struct.calcsize(form)))
        data.extend(struct.pack(form, value))
        return len(data) - struct.calcsize(form)

    def put(kind: str, value: Any, path: str) -> int:
        if kind.endswith("[]"):
            items = value or ()
            number("<I", len(items))
            starts = [put(kind[:-2], item, f"{path}.{i}") for i, item in enumerate(items)]
        elif kind == "string":
            text = (value or "").encode() + b"\0"
            starts = [number("<I", len(text))]
            data.extend(text)
        elif kind in _FORMATS:
            starts = [number(_FORMATS[kind], value or 0)]
        else:
            value = value or {}
            starts = [put(part, value.get(name), f"{path}.{name}".lstrip(".")) for part, name in fields(kind)]
        places[path] = starts[0] if starts else len(data)
        return places[path]

    put(kind, json.loads(content), "")
    return bytes(data), places
