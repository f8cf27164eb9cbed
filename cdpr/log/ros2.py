"""Standard ROS 2 messages of logs and live links: fields, schema text and bytes (CDR)."""

from __future__ import annotations

import json
import re
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
    "geometry_msgs/Inertia": (
        "float64 m\ngeometry_msgs/Vector3 com\nfloat64 ixx\nfloat64 ixy\nfloat64 ixz\nfloat64 iyy\nfloat64 iyz\n"
        "float64 izz"
    ),
    "geometry_msgs/InertiaStamped": "std_msgs/Header header\ngeometry_msgs/Inertia inertia",
    "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/PointStamped": "std_msgs/Header header\ngeometry_msgs/Point point",
    "geometry_msgs/Pose": "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation",
    "geometry_msgs/PoseStamped": "std_msgs/Header header\ngeometry_msgs/Pose pose",
    "geometry_msgs/PoseWithCovariance": "geometry_msgs/Pose pose\nfloat64[36] covariance",
    "geometry_msgs/PoseWithCovarianceStamped": "std_msgs/Header header\ngeometry_msgs/PoseWithCovariance pose",
    "geometry_msgs/Quaternion": "float64 x\nfloat64 y\nfloat64 z\nfloat64 w",
    "geometry_msgs/Transform": "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation",
    "geometry_msgs/TransformStamped": (
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform"
    ),
    "geometry_msgs/Twist": "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular",
    "geometry_msgs/TwistStamped": "std_msgs/Header header\ngeometry_msgs/Twist twist",
    "geometry_msgs/TwistWithCovariance": "geometry_msgs/Twist twist\nfloat64[36] covariance",
    "geometry_msgs/TwistWithCovarianceStamped": "std_msgs/Header header\ngeometry_msgs/TwistWithCovariance twist",
    "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Wrench": "geometry_msgs/Vector3 force\ngeometry_msgs/Vector3 torque",
    "geometry_msgs/WrenchStamped": "std_msgs/Header header\ngeometry_msgs/Wrench wrench",
    "rosgraph_msgs/Clock": "builtin_interfaces/Time clock",
    "sensor_msgs/CameraInfo": (
        "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\nfloat64[] d\nfloat64[9] k\n"
        "float64[9] r\nfloat64[12] p\nuint32 binning_x\nuint32 binning_y\nsensor_msgs/RegionOfInterest roi"
    ),
    "sensor_msgs/CompressedImage": "std_msgs/Header header\nstring format\nuint8[] data",
    "sensor_msgs/Imu": (
        "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\nfloat64[9] orientation_covariance\n"
        "geometry_msgs/Vector3 angular_velocity\nfloat64[9] angular_velocity_covariance\n"
        "geometry_msgs/Vector3 linear_acceleration\nfloat64[9] linear_acceleration_covariance"
    ),
    "sensor_msgs/JointState": (
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort"
    ),
    "sensor_msgs/LaserScan": (
        "std_msgs/Header header\nfloat32 angle_min\nfloat32 angle_max\nfloat32 angle_increment\n"
        "float32 time_increment\nfloat32 scan_time\nfloat32 range_min\nfloat32 range_max\nfloat32[] ranges\n"
        "float32[] intensities"
    ),
    "sensor_msgs/Range": (  # of Iron and later: Humble's has no variance
        "std_msgs/Header header\nuint8 radiation_type\nfloat32 field_of_view\nfloat32 min_range\n"
        "float32 max_range\nfloat32 range\nfloat32 variance"
    ),
    "sensor_msgs/RegionOfInterest": ("uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify"),
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

# Services (request, response) and the types that only they use, as in the .srv and .msg files of Jazzy.
SERVICES = {
    "rcl_interfaces/srv/DescribeParameters": ("string[] names", "rcl_interfaces/ParameterDescriptor[] descriptors"),
    "rcl_interfaces/srv/GetParameters": ("string[] names", "rcl_interfaces/ParameterValue[] values"),
    "rcl_interfaces/srv/GetParameterTypes": ("string[] names", "uint8[] types"),
    "rcl_interfaces/srv/ListParameters": (
        "string[] prefixes\nuint64 depth",
        "rcl_interfaces/ListParametersResult result",
    ),
    "rcl_interfaces/srv/SetParameters": (
        "rcl_interfaces/Parameter[] parameters",
        "rcl_interfaces/SetParametersResult[] results",
    ),
    "rcl_interfaces/srv/SetParametersAtomically": (
        "rcl_interfaces/Parameter[] parameters",
        "rcl_interfaces/SetParametersResult result",
    ),
    "std_srvs/srv/Trigger": ("", "bool success\nstring message"),
}
_PARTS = {
    "rcl_interfaces/FloatingPointRange": "float64 from_value\nfloat64 to_value\nfloat64 step",
    "rcl_interfaces/IntegerRange": "int64 from_value\nint64 to_value\nuint64 step",
    "rcl_interfaces/ListParametersResult": "string[] names\nstring[] prefixes",
    "rcl_interfaces/Parameter": "string name\nrcl_interfaces/ParameterValue value",
    "rcl_interfaces/ParameterDescriptor": (
        "string name\nuint8 type\nstring description\nstring additional_constraints\nbool read_only\n"
        "bool dynamic_typing\nrcl_interfaces/FloatingPointRange[<=1] floating_point_range\n"
        "rcl_interfaces/IntegerRange[<=1] integer_range"
    ),
    "rcl_interfaces/ParameterValue": (
        "uint8 type\nbool bool_value\nint64 integer_value\nfloat64 double_value\nstring string_value\n"
        "byte[] byte_array_value\nbool[] bool_array_value\nint64[] integer_array_value\n"
        "float64[] double_array_value\nstring[] string_array_value"
    ),
    "rcl_interfaces/SetParametersResult": "bool successful\nstring reason",
    "service_msgs/ServiceEventInfo": (
        "uint8 event_type\nbuiltin_interfaces/Time stamp\nuint8[16] client_gid\nint64 sequence_number"
    ),
}
_ALONE = "uint8 structure_needs_at_least_one_member"  # member of ROS 2 messages without fields

_FORMATS = {"bool": "?", "byte": "B", "uint8": "B", "int32": "i", "uint32": "I", "int64": "q", "uint64": "Q"}
_FORMATS |= {"float32": "f", "float64": "d"}
ENCAPSULATION = b"\0\1\0\0"  # plain CDR, little-endian; alignment counts from its end
_BIG_ENDIAN = b"\0\0"
_SEQUENCE = re.compile(r"(.+)\[(<=)?(\d*)\]")


def _definition(kind: str) -> str:
    if kind in DEFINITIONS or kind in _PARTS:
        return DEFINITIONS.get(kind) or _PARTS[kind]
    service, _, part = kind.rpartition("_")
    if part == "Event":
        parts = (f"{service}_{name}[<=1] {name.lower()}" for name in ("Request", "Response"))
        return "\n".join(("service_msgs/ServiceEventInfo info", *parts))
    return SERVICES[service][part == "Response"] or _ALONE


@cache
def fields(kind: str) -> tuple[tuple[str, str], ...]:
    """Return (type, name) of each field of a message type such as "geometry_msgs/Pose".

    For a service, such as "std_srvs/srv/Trigger", return the fields of its ROS 2 description; its messages are
    "..._Request", "..._Response" and "..._Event".
    """
    if kind in SERVICES:
        return tuple((f"{kind}_{name}", f"{name.lower()}_message") for name in ("Request", "Response", "Event"))
    pairs = (line.split() for line in _definition(kind).splitlines())
    return tuple((field_kind, name) for field_kind, name in pairs)


@cache
def item(kind: str) -> tuple[str, int | None, bool]:
    """Return (element type, size, variable): "T[]" gives (T, 0, True), "T[<=4]" (T, 4, True), "T[4]" (T, 4, False).

    Other types T give (T, None, False).
    """
    found = _SEQUENCE.fullmatch(kind)
    if found is None:
        return kind, None, False
    return found[1], int(found[3] or 0), bool(found[2]) or not found[3]


def full_name(kind: str) -> str:
    """Return the ROS 2 name of a type: "geometry_msgs/msg/Pose"; services already have it."""
    return kind if kind.count("/") == 2 else kind.replace("/", "/msg/")


@cache
def schema_text(kind: str) -> str:
    """Return the definition of a type and of all types that it contains, in MCAP's `ros2msg` form."""
    needed = [kind]
    for known in needed:  # grows during the iteration
        parts = (item(part)[0] for part, _ in fields(known))
        needed += [part for part in dict.fromkeys(parts) if part in DEFINITIONS and part not in needed]
    rule = "=" * 80
    return "\n".join([DEFINITIONS[kind], *(f"{rule}\nMSG: {name}\n{DEFINITIONS[name]}" for name in needed[1:]), ""])


def encode(kind: str, value: Mapping[str, Any]) -> tuple[bytes, Mapping[str, int]]:
    """Return the CDR bytes of a message, and the offset of each field.

    Fields missing in `value` are zero or empty. A field is named by its path, such as "pose.position.x" or
    "markers.0.points"; the offset of a message or a sequence is that of its first number.
    """
    return _encoded(kind, json.dumps(value))


@lru_cache(maxsize=64)
def _encoded(kind: str, content: str) -> tuple[bytes, Mapping[str, int]]:
    """Encode a message given as JSON; the cases of a study share the constant content."""
    data = bytearray(ENCAPSULATION)
    places: dict[str, int] = {}

    def number(form: str, value: Any) -> int:
        data.extend(bytes((len(ENCAPSULATION) - len(data)) % struct.calcsize(form)))
        data.extend(struct.pack(f"<{form}", value))
        return len(data) - struct.calcsize(form)

    def put(kind: str, value: Any, path: str) -> int:
        part, size, counted = item(kind)
        if size is not None:
            items = value or ((None,) * size if not counted else ())
            if counted:
                number("I", len(items))
            starts = [put(part, each, f"{path}.{i}") for i, each in enumerate(items)]
        elif kind == "string":
            text = (value or "").encode() + b"\0"
            starts = [number("I", len(text))]
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


def decode(kind: str, data: bytes) -> dict[str, Any]:
    """Return the content of a message from its CDR bytes, in the form of `encode`.

    Raises:
        ValueError: if the bytes are no such message.
    """
    if len(data) < len(ENCAPSULATION) or data[:2] not in (ENCAPSULATION[:2], _BIG_ENDIAN):
        raise ValueError("expected plain CDR")
    order, at = ">" if data[:2] == _BIG_ENDIAN else "<", len(ENCAPSULATION)

    def number(form: str) -> Any:
        nonlocal at
        at += (len(ENCAPSULATION) - at) % struct.calcsize(form)
        at += struct.calcsize(form)
        if at > len(data):
            raise ValueError("it ends too early")
        return struct.unpack_from(order + form, data, at - struct.calcsize(form))[0]

    def text() -> str:
        nonlocal at
        size = number("I")
        if size > len(data) - at:
            raise ValueError("it ends too early")
        at += size
        try:
            return data[at - size : at].rstrip(b"\0").decode()
        except UnicodeDecodeError:
            raise ValueError("a string is not UTF-8") from None

    def get(kind: str) -> Any:
        part, size, counted = item(kind)
        if size is not None:
            count = number("I") if counted else size
            if count > len(data) - at or 0 < size < count:  # each element has at least one byte
                raise ValueError("it ends too early" if count > len(data) - at else f"{count} of {kind}")
            return [get(part) for _ in range(count)]
        if kind == "string":
            return text()
        if kind in _FORMATS:
            return number(_FORMATS[kind])
        return {name: get(part) for part, name in fields(kind)}

    content: dict[str, Any] = get(kind)
    return content
