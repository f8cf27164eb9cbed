"""Messages of the Foxglove WebSocket protocol, version 1, according to its public specification.

Both subprotocol names denote this protocol. Numbers are little-endian; times are nanoseconds.
"""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Mapping, Sequence
from typing import Any

from cdpr.log.ros2 import full_name, schema_text
from cdpr.log.topics import Topic

SUBPROTOCOLS = ("foxglove.sdk.v1", "foxglove.websocket.v1")
CAPABILITIES = ("clientPublish", "parameters", "parametersSubscribe", "services", "time")
ENCODINGS = ("json", "cdr")  # of messages from clients
WARNING, ERROR = 1, 2  # levels of a status

# First byte of a binary message.
MESSAGE_DATA, TIME, SERVICE_RESPONSE = 1, 2, 3  # from the server
PUBLISHED, SERVICE_CALL = 1, 2  # from a client

_DATA = struct.Struct("<BIQ")
_TIME = struct.Struct("<BQ")
_CALL = struct.Struct("<III")
_CHANNEL = struct.Struct("<I")


def encoded(op: str, **content: Any) -> str:
    """Return a message in JSON."""
    return json.dumps({"op": op, **content}, separators=(",", ":"), allow_nan=False)


def server_info(session: str, version: str) -> str:
    """Return the first message to each client."""
    lists = {"capabilities": CAPABILITIES, "supportedEncodings": ENCODINGS}
    return encoded("serverInfo", name="cdpr", **lists, metadata={"cdpr": version}, sessionId=session)


def status(level: int, text: str) -> str:
    """Return a status message."""
    return encoded("status", level=level, message=text)


def advertise(topics: Sequence[Topic]) -> str:
    """Return the list of topics; the number of a channel is its index."""
    channels = [
        {
            "id": number,
            "topic": topic.name,
            "encoding": "cdr",
            "schemaName": full_name(topic.kind),
            "schemaEncoding": "ros2msg",
            "schema": schema_text(topic.kind),
        }
        for number, topic in enumerate(topics)
    ]
    return encoded("advertise", channels=channels)


def advertise_services(names: Sequence[str]) -> str:
    """Return the list of services; the number of a service is its index."""
    services = [
        {"id": number, "name": f"/cdpr/{name}", "type": f"cdpr/{name}", "requestSchema": "", "responseSchema": ""}
        for number, name in enumerate(names)
    ]
    return encoded("advertiseServices", services=services)


def parameter_values(parameters: Mapping[str, Any], number: Any = None) -> str:
    """Return parameter values; `number` is the id of the answered request, if any.

    Non-finite numbers are sent as text, because JSON has none.
    """
    plain = {name: _json_value(value) for name, value in parameters.items()}
    values = [{"name": name, "value": value, **_kind(value)} for name, value in plain.items()]
    return encoded("parameterValues", parameters=values, **({} if number is None else {"id": number}))


def _json_value(value: Any) -> Any:
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value


def _kind(value: Any) -> dict[str, str]:
    """Return the type, which distinguishes whole floats from integers."""
    if isinstance(value, float):
        return {"type": "float64"}
    if isinstance(value, list) and all(isinstance(each, float) for each in value):
        return {"type": "float64_array"}
    return {}


def message_data(subscription: int, time: int, data: bytes) -> bytes:
    """Return a message of a topic."""
    return _DATA.pack(MESSAGE_DATA, subscription, time) + data


def time_data(time: int) -> bytes:
    """Return the time of the simulation."""
    return _TIME.pack(TIME, time)


def service_response(service: int, call: int, answer: Mapping[str, Any]) -> bytes:
    """Return the answer to a service call, in JSON."""
    return bytes([SERVICE_RESPONSE]) + _CALL.pack(service, call, 4) + b"json" + json.dumps(answer).encode()


def service_failure(service: int, call: int, text: str) -> str:
    """Return the answer to a rejected service call."""
    return encoded("serviceCallFailure", serviceId=service, callId=call, message=text)


def parse_published(data: bytes) -> tuple[int, bytes]:
    """Return the channel and the content of a message published by a client.

    Raises:
        ValueError: if it is malformed.
    """
    if len(data) < 1 + _CHANNEL.size:
        raise ValueError("a published message has 5 bytes or more")
    return _CHANNEL.unpack_from(data, 1)[0], data[1 + _CHANNEL.size :]


def parse_call(data: bytes) -> tuple[int, int, str]:
    """Return the service, call number and encoding of a service call.

    Raises:
        ValueError: if it is malformed.
    """
    if len(data) < 1 + _CALL.size:
        raise ValueError("a service call has 13 bytes or more")
    service, call, length = _CALL.unpack_from(data, 1)
    encoding = data[1 + _CALL.size : 1 + _CALL.size + length]
    if len(encoding) < length:
        raise ValueError("a service call is shorter than its encoding's name")
    return service, call, encoding.decode()
